//! Colours: viridis for heights and forces, and line colours that colour-blind readers can distinguish.

use plotters::style::RGBColor;

/// Nine points of the viridis map (S. van der Walt and N. Smith, matplotlib 2.0), evenly spaced; linear in between.
const VIRIDIS: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];

/// Okabe and Ito's palette without yellow, which is invisible on white, and five of P. Tol's muted scheme: as many as
/// runs on a page.
const LINES: [RGBColor; 12] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(136, 34, 85),
    RGBColor(153, 153, 51),
    RGBColor(51, 34, 136),
    RGBColor(221, 204, 119),
    RGBColor(68, 170, 153),
];

/// Colour of levels that are not valid.
pub(super) const UNVOUCHED: RGBColor = RGBColor(190, 190, 190);

/// Colour of a range between two curves.
pub(super) const RANGE: RGBColor = RGBColor(213, 229, 240);

/// A colour in SVG's notation.
pub(super) fn as_svg(RGBColor(red, green, blue): RGBColor) -> String {
    format!("#{red:02X}{green:02X}{blue:02X}")
}

/// Colour at the part `fraction` of a range, limited to \[0, 1\].
pub(super) fn viridis(fraction: f64) -> RGBColor {
    between(&VIRIDIS, fraction)
}

/// Linear interpolation between the points of a map.
fn between(points: &[[u8; 3]], fraction: f64) -> RGBColor {
    let position = fraction.clamp(0.0, 1.0) * (points.len() - 1) as f64;
    let below = (position as usize).min(points.len() - 2);
    let share = position - below as f64;
    let channel = |c: usize| {
        let (from, to) = (f64::from(points[below][c]), f64::from(points[below + 1][c]));
        (from + share * (to - from)).round() as u8
    };
    RGBColor(channel(0), channel(1), channel(2))
}

/// Colour of the n-th line; they repeat after twelve.
pub(super) fn line(index: usize) -> RGBColor {
    LINES[index % LINES.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brightness_rises_evenly() {
        // Perceptually even means an even rise of lightness; CIE luminance to the 1/3 is proportional to it.
        let linear = |c: u8| (f64::from(c) / 255.0).powf(2.2);
        let lightness = |x: f64| {
            let RGBColor(r, g, b) = viridis(x);
            (0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b)).cbrt()
        };
        for step in 0..20 {
            let x = f64::from(step) / 20.0;
            let rise = lightness(x + 0.05) - lightness(x);
            assert!((0.02..0.07).contains(&rise), "{x}: {rise}");
        }
        assert_eq!(viridis(-1.0), RGBColor(68, 1, 84));
        assert_eq!(viridis(7.0), RGBColor(253, 231, 37));
    }
}

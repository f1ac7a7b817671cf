//! Colours: viridis for heights and forces, and line colours that colour-blind readers can distinguish.

use std::fmt;

/// Red, green and blue, a byte each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Colour(u32);

/// As SVG writes it. The style of pages replaces some colours, by these texts, on a dark background.
impl fmt::Display for Colour {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "#{:06X}", self.0)
    }
}

pub(super) const INK: Colour = Colour(0x1E1E1E);
pub(super) const GRID: Colour = Colour(0xDEDEDE);
pub(super) const FAINT_GRID: Colour = Colour(0xF0F0F0);
pub(super) const WHITE: Colour = Colour(0xFFFFFF);
pub(super) const GREY: Colour = Colour(0x969696);
pub(super) const GOLD: Colour = Colour(0xFFCD28);
/// Range between two curves.
pub(super) const RANGE: Colour = Colour(0xD5E5F0);
/// Levels that are not valid.
pub(super) const INVALID: Colour = Colour(0xBEBEBE);
/// Cells of a map that have no value.
pub(super) const NO_VALUE: Colour = Colour(0xC8C8C8);

/// Nine points of the viridis map (S. van der Walt and N. Smith, matplotlib 2.0), evenly spaced; linear in between.
const VIRIDIS: [u32; 9] = [0x440154, 0x472C7A, 0x3B518B, 0x2C718E, 0x21908D, 0x27AD81, 0x5CC863, 0xAADC32, 0xFDE725];

/// Okabe and Ito's palette without yellow, which is invisible on white, and five of P. Tol's muted scheme: as many as
/// runs on a page.
const LINES: [u32; 12] = [
    0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0xE69F00, 0x56B4E9, 0x000000, 0x882255, 0x999933, 0x332288, 0xDDCC77,
    0x44AA99,
];

/// Colour at the part `fraction` of a range, limited to \[0, 1\].
pub(super) fn viridis(fraction: f64) -> Colour {
    let position = fraction.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let below = (position as usize).min(VIRIDIS.len() - 2);
    let share = position - below as f64;
    let channel = |shift: u32| {
        let [from, to] = [VIRIDIS[below], VIRIDIS[below + 1]].map(|point| f64::from((point >> shift) & 0xFF));
        ((from + share * (to - from)).round() as u32) << shift
    };
    Colour(channel(16) | channel(8) | channel(0))
}

/// Colour of the n-th line; they repeat after twelve.
pub(super) fn line(index: usize) -> Colour {
    Colour(LINES[index % LINES.len()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brightness_rises_evenly() {
        // Perceptually even means an even rise of lightness; CIE luminance to the 1/3 is proportional to it.
        let linear = |c: u32| (f64::from(c & 0xFF) / 255.0).powf(2.2);
        let lightness = |x: f64| {
            let Colour(rgb) = viridis(x);
            (0.2126 * linear(rgb >> 16) + 0.7152 * linear(rgb >> 8) + 0.0722 * linear(rgb)).cbrt()
        };
        for step in 0..20 {
            let x = f64::from(step) / 20.0;
            let rise = lightness(x + 0.05) - lightness(x);
            assert!((0.02..0.07).contains(&rise), "{x}: {rise}");
        }
        let written = [viridis(-1.0), viridis(0.5), viridis(7.0)];
        assert_eq!(written.map(|colour| colour.to_string()), ["#440154", "#21908D", "#FDE725"]);
        assert_eq!(line(12).to_string(), "#0072B2");
    }
}

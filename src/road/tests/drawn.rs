//! Drawn roads: levels in all directions, Gaussian heights, no seams between patches, independent patches and levels.

use super::*;
use crate::road::sources::made::{Patches, RingSpectrum, RoadDesign, TargetSpectrum, Texture};
use crate::road::texture::{ProfileSpectrum, nearest_band};
use crate::scene::MadeRoad;

const SPACING: f64 = 0.001;

fn texture(target: &TargetSpectrum, lattice: Lattice) -> Texture {
    let design = RoadDesign { target: target.clone(), shape: None, spacing: SPACING, seed: 4 };
    Texture::new(&design, lattice, 1 << 30).unwrap()
}

/// A single range of waves, 25 to 10 mm, as high as those of asphalt.
fn short_waves() -> TargetSpectrum {
    TargetSpectrum::third_octaves(&[0.025, 0.02, 0.016, 0.0125, 0.01], &[46.0, 46.8, 46.2, 45.6, 43.1]).unwrap()
}

fn drawn(texture: &Texture, first: i64, rows: usize, columns: usize) -> Vec<f64> {
    let mut heights = vec![f64::NAN; rows * columns];
    texture.rows(first, &mut Patches::default(), &mut heights);
    heights
}

/// Profiles along, across and at 45 degrees of a strip of 50 m by 0.4 m must have the surface's levels. A band of
/// relative width 0.23 has in a profile of length l about 0.23 l/wavelength lines, of which the Hann window leaves two
/// in three independent; profiles half a wavelength apart are independent, too. The tolerance is four standard
/// deviations of the mean of so many squares.
#[test]
fn levels_are_the_same_in_every_direction() {
    let columns = 400;
    let lattice = Lattice { dx: SPACING, along: 1, dy: SPACING, columns };
    let texture = texture(&TargetSpectrum::dense_asphalt(), lattice);
    let rows = 50_000;
    let heights = drawn(&texture, -700, rows, columns);
    let mut along = ProfileSpectrum::new(rows, SPACING);
    for column in (0..columns).step_by(50) {
        along.add(&heights.iter().skip(column).step_by(columns).copied().collect::<Vec<_>>());
    }
    let mut across = ProfileSpectrum::new(columns, SPACING);
    heights.chunks_exact(columns).step_by(20).for_each(|row| across.add(row));
    let mut diagonal = ProfileSpectrum::new(columns, SPACING * 2_f64.sqrt());
    for begin in (0..rows - columns).step_by(20) {
        diagonal.add(&(0..columns).map(|i| heights[(begin + i) * columns + i]).collect::<Vec<_>>());
    }
    for band in texture.spectrum().band_fit() {
        let number = nearest_band(band.wavelength);
        let area = rows as f64 * columns as f64 * SPACING * SPACING;
        let independent = 0.15 * area / (0.5 * band.wavelength * band.wavelength);
        for (name, spectrum, length) in
            [("along", &along, 50.0), ("across", &across, 0.4), ("at 45 degrees", &diagonal, 0.56)]
        {
            // In a short profile the window spreads the steep flanks of the spectrum over the longest bands.
            if band.wavelength > 0.1 * length {
                continue;
            }
            let (found, allowed) = (spectrum.level(number), 0.15 + 4.0 * 4.34 / independent.sqrt());
            println!(
                "{:6.1} mm {name}: {found:.2} dB for {:.2} dB, +-{allowed:.2}",
                1e3 * band.wavelength,
                band.fitted
            );
            assert!(
                (found - band.fitted).abs() < allowed,
                "{:.4} m {name}: {found} for {}",
                band.wavelength,
                band.fitted
            );
        }
    }
}

/// 40 m by 0.12 m of waves of 10 to 25 mm are some 40 000 independent heights; the standard error of their kurtosis is
/// sqrt(24/40 000) = 0.025.
#[test]
fn heights_are_gaussian_with_the_variance_of_the_spectrum() {
    let (rows, columns) = (20_000, 60);
    let lattice = Lattice { dx: 0.002, along: 1, dy: 0.002, columns };
    let heights = drawn(&texture(&short_waves(), lattice), 0, rows, columns);
    let mean = |power: i32| heights.iter().map(|z| z.powi(power)).sum::<f64>() / heights.len() as f64;
    let variance = RingSpectrum::fit(&short_waves()).variance();
    assert!((mean(2) / variance - 1.0).abs() < 0.03, "{} for {variance}", mean(2));
    assert!(mean(3).abs() / mean(2).powf(1.5) < 0.06);
    assert!((mean(4) / mean(2).powi(2) - 3.0).abs() < 0.1, "{}", mean(4) / mean(2).powi(2));
}

/// Mean squares, and mean squared differences over 2 and 6 mm, must be the same where patches fade into each other as
/// elsewhere: the fade reduces the covariance at most by the factor cos(pi/2 pi/2 lag/fade), 1 % here. 60 seams of 0.23
/// m by 0.12 m have some 20 000 independent heights: four standard errors of the ratio are 6 %.
#[test]
fn patches_join_without_a_seam() {
    let columns = 60;
    let lattice = Lattice { dx: 0.002, along: 1, dy: 0.002, columns };
    let texture = texture(&short_waves(), lattice);
    // Longest wave 28 mm: blocks of 128 of them follow each other by 120.
    let longest = short_waves().longest();
    let (pitch, fade) = (120.0 * longest, 8.0 * longest);
    let (mut inside, mut elsewhere) = ([0.0; 3], [0.0; 3]);
    for seam in 0..60_i64 {
        for (sums, begin) in [(&mut inside, 0.0), (&mut elsewhere, 0.5 * pitch)] {
            let first = ((seam as f64 * pitch + begin) / 0.002).ceil() as i64;
            let rows = (fade / 0.002) as usize;
            let heights = drawn(&texture, first, rows, columns);
            for (sum, lag) in sums.iter_mut().zip([0, 1, 3]) {
                let later = &heights[lag * columns..];
                let square = |(a, b): (&f64, &f64)| if lag == 0 { a * a } else { (b - a) * (b - a) };
                *sum += heights.iter().zip(later).map(square).sum::<f64>() / later.len() as f64;
            }
        }
    }
    for (lag, (inside, elsewhere)) in inside.iter().zip(&elsewhere).enumerate() {
        println!("lag {lag}: {:.4} of elsewhere", inside / elsewhere);
        assert!((inside / elsewhere - 1.0).abs() < 0.07, "lag {lag}: {inside} for {elsewhere}");
    }
}

/// The period of a patch must not be that of the road: the same places of neighbouring blocks are uncorrelated, and so
/// are both ends of one.
#[test]
fn blocks_are_drawn_by_themselves() {
    let columns = 60;
    let lattice = Lattice { dx: 0.002, along: 1, dy: 0.002, columns };
    let texture = texture(&short_waves(), lattice);
    let (block, pitch) = (128.0 * short_waves().longest(), 120.0 * short_waves().longest());
    let at = |place: f64| drawn(&texture, (place / 0.002).round() as i64, 600, columns);
    let correlation = |a: &[f64], b: &[f64]| {
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        product(a, b) / (product(a, a) * product(b, b)).sqrt()
    };
    let here = at(0.3);
    // 1.2 m by 0.12 m are some 1200 independent heights: five standard errors.
    assert!(correlation(&here, &here) > 0.999);
    for other in [pitch, 2.0 * pitch, -pitch, block] {
        let found = correlation(&here, &at(0.3 + other));
        assert!(found.abs() < 0.15, "{other} m later: {found}");
    }
}

/// Cells of half the size must only halve their distance: every other height of the fine road is the coarse one's, but
/// for what the coarse cells do not resolve.
#[test]
fn a_finer_lattice_sees_the_same_road() {
    let spec = Road::Made(MadeRoad {
        wavelengths: Some(vec![0.05, 0.04, 0.0315, 0.025, 0.02, 0.016]),
        levels: Some(vec![43.0, 44.0, 45.0, 46.0, 46.0, 45.0]),
        ..MadeRoad::default()
    });
    let coarse = Lattice { dx: 0.006, along: 3, dy: 0.003, columns: 40 };
    let fine = Lattice { dx: 0.006, along: 3 * 3, dy: 0.001, columns: 120 };
    let (a, b) = (rows(&mut open(&spec, coarse), 500, 200), rows(&mut open(&spec, fine), 500, 200));
    let rms = crate::road::texture::rms(&a);
    for row in 0..600 {
        for column in 0..40 {
            let (a, b) = (a[row * 40 + column], b[(3 * row + 1) * 120 + 3 * column + 1]);
            // The interpolation attenuates by 70 dB.
            assert!((a - b).abs() < 3e-3 * rms, "row {row}, column {column}: {a} and {b}, rms {rms}");
        }
    }
}

/// 100 m of asphalt by 0.12 m are some 200 000 cells of 8 mm, about its mean wavelength: the standard errors of the
/// moments of a Gaussian are sqrt(6/n) and sqrt(24/n), 0.006 and 0.011, and the long waves, of which there are few, add
/// as much again.
#[test]
fn skewed_roads_have_their_moments_and_their_levels() {
    let lattice = Lattice { dx: 0.002, along: 1, dy: 0.002, columns: 60 };
    for (skewness, kurtosis) in [(-0.3, 2.5), (0.5, 3.5)] {
        let road = MadeRoad { skewness: Some(skewness), kurtosis: Some(kurtosis), seed: 3, ..MadeRoad::default() };
        let mut road = open(&Road::Made(road), lattice);
        let heights = rows(&mut road, 0, 50_000);
        let count = heights.len() as f64;
        let mean = heights.iter().sum::<f64>() / count;
        let central = |power: i32| heights.iter().map(|z| (z - mean).powi(power)).sum::<f64>() / count;
        let found = [central(3) / central(2).powf(1.5), central(4) / central(2).powi(2)];
        println!("asked {skewness}, {kurtosis}, found {found:?}");
        assert!((found[0] - skewness).abs() < 0.05 && (found[1] - kurtosis).abs() < 0.1, "{found:?}");
        let mut spectrum = ProfileSpectrum::new(50_000, 0.002);
        for column in [0, 15, 30, 45, 59] {
            spectrum.add(&heights.iter().skip(column).step_by(60).copied().collect::<Vec<_>>());
        }
        // From 8 mm on: cells of 2 mm attenuate shorter waves. 100 m in five profiles: 1 dB is four standard deviations
        // at 0.1 m, 0.5 dB at shorter waves.
        for band in road.report().bands.iter().filter(|band| (0.0078..0.11).contains(&band.wavelength)) {
            let level = spectrum.level(nearest_band(band.wavelength));
            let allowed = if band.wavelength > 0.03 { 1.0 } else { 0.5 };
            println!("{:.1} mm: {level:.2} dB for {:.2} dB", 1e3 * band.wavelength, band.fitted);
            assert!((level - band.fitted).abs() < allowed, "{:.4} m: {level} for {}", band.wavelength, band.fitted);
        }
    }
    let wrong = Road::Made(MadeRoad { skewness: Some(1.5), kurtosis: Some(3.0), ..MadeRoad::default() });
    assert!(matches!(refused(&wrong, lattice), RoadError::Moments { .. }));
}

/// With flat tops more of a slice makes contact: the mean S past the highest cell grows with negative skewness, at the
/// same levels.
#[test]
fn flat_tops_are_met_by_more_of_the_slice() {
    let lattice = Lattice { dx: 1.95 / 512.0, along: 2, dy: 0.002, columns: 60 };
    let builder = slices::SliceBuilder::winkler(60).unwrap().with_lines(2).unwrap();
    let mean = |skewness: f64, kurtosis: f64| {
        let road = MadeRoad { skewness: Some(skewness), kurtosis: Some(kurtosis), seed: 3, ..MadeRoad::default() };
        let curves = builder.build_rows(&rows(&mut open(&Road::Made(road), lattice), 0, 4000)).unwrap();
        [0.5e-3, 1e-3, 2e-3].map(|y| curves.iter().map(|curve| curve.displacement_at(y)).sum::<f64>() / 4000.0)
    };
    let (gaussian, flat) = (mean(0.0, 3.0), mean(-0.3, 2.5));
    println!("mean S at 0.5, 1, 2 mm: Gaussian {gaussian:?}, -0.3 and 2.5 {flat:?}");
    assert!(flat.iter().zip(gaussian).all(|(flat, gaussian)| *flat > gaussian));
}

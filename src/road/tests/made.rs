use super::*;
use crate::road::sources::made::TargetSpectrum;
use crate::road::texture::{ProfileSpectrum, mid_wavelength};
use crate::scene::{MadeRoad, NamedTexture, PowerLawTexture};

fn made(seed: u64) -> Road {
    Road::Made(MadeRoad { seed, ..MadeRoad::default() })
}

/// Levels along x over 60 m: a band has about 60 m x 0.23/wavelength independent lines, 87 at 158 mm: 0.5 dB standard
/// deviation (times 1.4 for the window); the mean over 12 columns 17 mm apart helps for short waves only. 1.8 dB are
/// 2.5 deviations.
#[test]
fn levels_along_are_those_asked_for() {
    let lattice = Lattice { dx: 0.001, along: 1, dy: 0.001, columns: 200 };
    let mut road = open(&made(1), lattice);
    let (length, pick) = (60_000, 12);
    let mut profiles = vec![Vec::with_capacity(length); pick];
    for block in 0..length / 1000 {
        let heights = rows(&mut road, block as i64 * 1000, 1000);
        for row in heights.chunks_exact(lattice.columns) {
            for (column, profile) in profiles.iter_mut().enumerate() {
                profile.push(row[column * 17]);
            }
        }
    }
    let mut spectrum = ProfileSpectrum::new(length, 0.001);
    profiles.iter().for_each(|profile| spectrum.add(profile));
    for band in TargetSpectrum::dense_asphalt().bands() {
        let number = crate::road::texture::nearest_band((band.lower * band.upper).sqrt().recip());
        let (target, found) = (crate::road::texture::level(band.energy), spectrum.level(number));
        println!("{:6.1} mm: asked {target:.2} dB, found {found:.2} dB", 1e3 * mid_wavelength(number));
        let allowed = if number > -16 { 1.8 } else { 0.6 };
        assert!((found - target).abs() < allowed, "{:.4} m: {found} dB for {target} dB", mid_wavelength(number));
    }
    let depth = crate::road::texture::ProfileDepth::of([(&profiles[0][..], &[][..])], 0.001).mean.unwrap();
    println!("mean profile depth {:.2} mm, rms {:.3} mm", 1e3 * depth, 1e3 * crate::road::texture::rms(&profiles[0]));
    assert!((0.6e-3..1.8e-3).contains(&depth), "dense asphalt has about 1.1 mm, found {depth}");
}

/// Lateral profiles of a wide strip compared with its longitudinal ones, with the same number of independent waves in
/// both.
#[test]
fn levels_across_equal_levels_along() {
    let spec = Road::Made(MadeRoad {
        wavelengths: Some(vec![0.05, 0.04, 0.0315, 0.025, 0.02]),
        levels: Some(vec![44.0, 45.0, 46.0, 45.0, 44.0]),
        spacing: 0.004,
        seed: 9,
        ..MadeRoad::default()
    });
    let points = 500;
    let mut road = open(&spec, Lattice { dx: 0.004, along: 1, dy: 0.004, columns: points });
    let (mut along, mut across) = (ProfileSpectrum::new(points, 0.004), ProfileSpectrum::new(points, 0.004));
    for piece in 0..8 {
        let heights = rows(&mut road, piece * points as i64, points);
        heights.chunks_exact(points).for_each(|row| across.add(row));
        for column in 0..points {
            along.add(&heights.iter().skip(column).step_by(points).copied().collect::<Vec<f64>>());
        }
    }
    for (band, target) in [(-13, 44.0), (-14, 45.0), (-15, 46.0), (-16, 45.0), (-17, 44.0)] {
        let (x, y) = (along.level(band), across.level(band));
        println!("{band}: along {x:.2} dB, across {y:.2} dB, asked {target} dB");
        assert!((x - y).abs() < 0.5, "band {band}: {x} dB along, {y} dB across");
        assert!((x - target).abs() < 0.5, "band {band}: {x} dB along for {target} dB");
    }
}

#[test]
fn any_order_of_access_gives_the_same_bits() {
    let mut forwards = open(&made(3), lattice());
    let mut other = open(&made(3), lattice());
    let all = rows(&mut forwards, -3000, 6000);
    let columns = lattice().columns;
    for (first, count) in [(2500, 400), (-3000, 17), (-1, 2), (0, 1), (1499, 3), (-2000, 3500)] {
        let piece = rows(&mut other, first, count);
        let begin = (first + 3000) as usize * columns;
        assert!(piece.iter().zip(&all[begin..]).all(|(a, b)| a.to_bits() == b.to_bits()), "rows from {first}");
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let single = pool.install(|| rows(&mut open(&made(3), lattice()), -3000, 6000));
    assert!(single.iter().zip(&all).all(|(a, b)| a.to_bits() == b.to_bits()));
}

#[test]
fn chunks_join_without_a_seam() {
    // Across every chunk border the second difference must be as elsewhere.
    let mut road = open(&made(5), lattice());
    let columns = lattice().columns;
    let heights = rows(&mut road, -4000, 8000);
    let second = |row: usize| {
        let z = |row: usize| heights[row * columns];
        (z(row + 1) - 2.0 * z(row) + z(row - 1)).abs()
    };
    let rms = ((1..7999).map(|row| second(row).powi(2)).sum::<f64>() / 7998.0).sqrt();
    let worst = (1..7999).map(second).fold(0.0, f64::max);
    assert!(worst < 5.5 * rms, "a jump of {worst}, rms {rms}");
}

#[test]
fn seeds_give_unrelated_roads() {
    let (a, b) = (rows(&mut open(&made(1), lattice()), 0, 4000), rows(&mut open(&made(2), lattice()), 0, 4000));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let correlation = product(&a, &b) / (product(&a, &a) * product(&b, &b)).sqrt();
    assert!(correlation.abs() < 0.1, "{correlation}");
}

#[test]
fn road_is_the_same_at_another_number_of_elements() {
    let spec = Road::Made(MadeRoad {
        wavelengths: Some(vec![0.1, 0.08, 0.063, 0.05, 0.04, 0.0315, 0.025, 0.02]),
        levels: Some(vec![40.0, 41.0, 42.0, 43.0, 44.0, 45.0, 46.0, 46.0]),
        ..MadeRoad::default()
    });
    let coarse = lattice();
    let fine = Lattice { dx: coarse.dx / 2.0, ..coarse };
    let (a, b) = (rows(&mut open(&spec, coarse), -100, 1000), rows(&mut open(&spec, fine), -200, 2000));
    let rms = crate::road::texture::rms(&a);
    for row in 0..1000 {
        for column in 0..70 {
            let (a, b) = (a[row * 70 + column], b[2 * row * 70 + column]);
            assert!((a - b).abs() < 2e-3 * rms, "row {row}: {a} and {b}, rms {rms}");
        }
    }
}

/// A kilometre of a constructed road has its levels and its skewness, and so have its extremes: of some 200 000 places
/// 5 mm apart, the standard error of the skewness is 0.02.
#[test]
fn constructed_roads_have_their_skewness_and_bounded_heights() {
    // Cells of a run that are larger smooth the heights before they are skewed.
    let lattice = Lattice { dx: 0.001, along: 1, dy: 0.001, columns: 3 };
    for skewness in [NamedTexture::DEFAULT.moments()[0], -1.85] {
        let texture = Some(NamedTexture::DEFAULT);
        let made = MadeRoad { seed: 2, skewness: Some(skewness), texture, ..MadeRoad::default() };
        let mut road = open(&Road::Made(made), lattice);
        let worst = road.report().bands.iter().map(|band| band.deviation()).fold(0.0, f64::max);
        assert!(worst < 0.3, "{skewness}: {worst} dB");
        let mut sums = [0.0; 4];
        let mut ends = [0.0_f64; 2];
        for piece in 0..1000 {
            for height in rows(&mut road, 1000 * piece, 1000) {
                let mut power = 1.0;
                sums.iter_mut().for_each(|sum| {
                    *sum += power;
                    power *= height;
                });
                ends = [ends[0].min(height), ends[1].max(height)];
            }
        }
        let [_, mean, square, cube] = sums.map(|sum| sum / sums[0]);
        let variance = square - mean * mean;
        let found = (cube - 3.0 * mean * square + 2.0 * mean.powi(3)) / variance.powf(1.5);
        let [low, high] = ends.map(|end| end / variance.sqrt());
        println!("asked {skewness}, found {found}; from {low} to {high} rms heights");
        assert!((found - skewness).abs() < 0.1, "{found}");
        assert!((-12.5..-5.0).contains(&low) && (1.5..4.0).contains(&high), "{low} to {high}");
    }
}

/// 20 m of eight neighbouring profiles: a band of relative width 0.23 has 20 m x 0.23/wavelength lines, of a standard
/// deviation of 4.3 dB each, 1.4 times that for the window. The tolerance is three of them, plus the deviation of the
/// nearest isotropic surface.
#[test]
fn named_roads_have_the_depth_and_the_levels_of_their_names() {
    for texture in NamedTexture::ALL {
        let spec = Road::Made(MadeRoad { texture: Some(texture), seed: 1, ..MadeRoad::default() });
        let found = describe(&spec, lattice(), 80.0 / 3.6, Limits::default()).unwrap();
        let ([depth, within], measured) = (texture.depth(), found.mean_profile_depth.unwrap());
        let mean = measured.mean.unwrap();
        println!("{}: {:.3} mm for {:.3}", texture.name(), 1e3 * mean, 1e3 * depth);
        assert!((mean - depth).abs() < 0.1 * depth && within > 0.1 * depth, "{}: {mean} for {depth}", texture.name());
        if texture == NamedTexture::Iso10844 {
            assert_eq!(measured.reference_surface, Some(true));
        }
        for (band, level) in texture.levels() {
            let wavelength = mid_wavelength(band);
            let at = found.levels.iter().find(|at| (at.wavelength / wavelength - 1.0).abs() < 0.01).unwrap();
            let off = found.report.bands.iter().find(|fit| (fit.wavelength / wavelength - 1.0).abs() < 0.01).unwrap();
            let allowed = 3.0 * 4.34 * 1.4 / (20.0 * 0.23 / wavelength).sqrt() + off.deviation() + 0.1;
            assert!((at.level - level).abs() < allowed, "{wavelength}: {} for {level}, {allowed}", at.level);
        }
        let named = |note: &RoadNote| matches!(note, RoadNote::NamedTexture { .. });
        assert!(found.report.notes.iter().any(named), "{:?}", found.report.notes);
    }
}

#[test]
fn default_road_is_the_dense_asphalt_by_its_name() {
    let named = Road::Made(MadeRoad { seed: 4, texture: Some(NamedTexture::DEFAULT), ..MadeRoad::default() });
    let [plain, named] = [made(4), named].map(|spec| rows(&mut open(&spec, lattice()), 0, 500));
    assert!(plain.iter().zip(&named).all(|(a, b)| a.to_bits() == b.to_bits()));
}

#[test]
fn power_law_road_has_its_rms() {
    let law = PowerLawTexture { rms: 0.5e-3, exponent: 2.0, longest: 0.1, shortest: 0.01 };
    let spec = Road::Made(MadeRoad { power_law: Some(law), ..MadeRoad::default() });
    let fine = Lattice { dx: 0.002, along: 1, dy: 0.01, columns: 1 };
    let mut road = open(&spec, fine);
    let profile = rows(&mut road, 0, 30_000);
    let mut spectrum = ProfileSpectrum::new(profile.len(), 0.002);
    spectrum.add(&profile);
    let rms = spectrum.energy(10.0, 100.0).sqrt();
    assert!((rms / 0.5e-3 - 1.0).abs() < 0.08, "{rms}");
    assert!(road.report().highest_frequency(80.0 / 3.6).is_some_and(|f| (f - 80.0 / 3.6 / 0.01).abs() < 1e-6));
}

#[test]
fn unsuitable_lattices_are_refused() {
    let coarse = Road::Made(MadeRoad { spacing: 0.003, ..MadeRoad::default() });
    assert!(matches!(refused(&coarse, lattice()), RoadError::Spacing { .. }));
    let nothing = Road::Made(MadeRoad { spacing: f64::NAN, ..MadeRoad::default() });
    assert!(matches!(refused(&nothing, lattice()), RoadError::NotPositive { .. }));
    let limits = Limits { bytes: 1 << 20 };
    assert!(matches!(RoadSurface::open(&made(0), lattice(), limits), Err(RoadError::TextureTooLarge { .. })));
    // All levels are the same, however long the waves.
    let law = PowerLawTexture { rms: 0.1, exponent: 2.0, longest: 1e5, shortest: 0.01 };
    let vast = Road::Made(MadeRoad { power_law: Some(law), ..MadeRoad::default() });
    assert!(rows(&mut open(&vast, lattice()), 0, 10).iter().all(|height| height.is_finite()));
}

#[test]
fn unrealisable_spectrum_is_noted() {
    let spec = Road::Made(MadeRoad {
        wavelengths: Some(vec![0.1, 0.08]),
        levels: Some(vec![20.0, 60.0]),
        ..MadeRoad::default()
    });
    let road = open(&spec, lattice());
    assert!(road.report().notes.iter().any(|note| matches!(note, RoadNote::NotRealisable { .. })));
    assert_eq!(open(&made(0), lattice()).report().notes, [RoadNote::DefaultTexture]);
}

#[test]
fn smooth_road_is_level_and_endless() {
    let mut road = open(&Road::Smooth, Lattice::choose(&Road::Smooth, 0.004, 0.14, None, None).unwrap());
    assert!(road.is_smooth() && road.extent().is_none() && road.check_covers(-1e9, 1e9).is_ok());
    assert!(rows(&mut road, -5, 10).iter().all(|z| z.to_bits() == 0));
    assert!(matches!(road.heights(0, 2, &mut [0.0; 3]), Err(RoadError::BufferSize { needed: 2, found: 3 })));
}

//! Valid files that mutants are made of.

use std::fmt::Write as _;

use npyz::WriterBuilder;

/// A scene with sound, vibration and a power law.
pub(super) const SOUND: &str = include_str!("../../../scenes/sound.toml");
/// A tyre file.
pub(super) const TYRE: &str = include_str!("../../../scenes/tyres/car.toml");
/// The key of no entry.
pub(super) const KEY: [u8; 32] = [7; 32];

pub(super) const COMPLIANCE: &str = r#"{"tyres": [
 {"name": "flat", "layers": [{"thickness": 0.006, "tension_x": 4e4, "tension_y": 2e4, "material":
  {"law": "power-law", "modulus": 5e8, "loss_factor": 0.08, "poisson": 0.3, "density": 1300}},
  {"thickness": 0.013, "material": {"law": "prony", "modulus": 7e6, "poisson": 0.49, "density": 1000,
  "weights": [0.5, 2], "times": [1e-3, 1e-5]}}], "foundation": {"normal": 2e6, "tangential": 1e6}},
 {"name": "round", "curved": true, "circumference": 1.95, "width": 0.2, "pressure": 2e5, "foundation":
  {"normal": 2e6, "tangential": 1e6}, "cavity": {"radius": 0.23, "depth": 0.08, "density": 3.8},
  "layers": [{"thickness": 0.01, "modulus": 1e8, "poisson": 0.4, "density": 1200, "tension": [4e4, 0]}]}],
 "cases": [{"tyre": "flat", "kx": 20, "ky": 15.7, "s": [1, 600]}, {"tyre": "round", "n": 3, "m": 2, "s": [0, 900]}]}"#;

pub(super) const RADIATION: &str = r#"{"density": 1.2, "sound_speed": 343, "nodes_per_wavelength": 4, "cases": [
 {"name": "a", "body": {"shape": "sphere", "radius": 0.5}, "plane": false, "wavenumber": 1,
  "velocity": "uniform", "receivers": [[1, 0, 0.5]]},
 {"name": "b", "body": {"shape": "tyre", "radius": 0.3, "width": 0.2, "shoulder": 0.02, "height": 0.29},
  "plane": true, "wavenumber": 2, "velocity": {"circumferential": 2, "across": 1}, "receivers": [[1, 2, 1]]}]}"#;

pub(super) const MOBILITIES: [&str; 2] = [
    "# measured\nfrequency_hz,patch_m,re,im\n100,0.01,1e-3,2e-4\n200,0.02,1.2e-3,-3e-4\n400,0.02,9e-4,1e-4\n",
    "patch_m;frequency_hz;phase_deg;level_db;note\n0.02;100;12.5;-58.2;a\n\n0.02;300;-40;-61;\"b;c\"\n",
];

fn height(row: usize) -> f64 {
    0.3 * (0.9 * row as f64).sin() + 0.1 * (row * row % 7) as f64
}

/// A profile in millimetres.
pub(super) fn profile(delimiter: u8) -> Vec<u8> {
    let delimiter = char::from(delimiter);
    let mut text = format!("x{delimiter}z\n");
    for row in 0..200 {
        writeln!(text, "{}{delimiter}{:.3}", 2 * row, height(row)).unwrap();
    }
    text.into_bytes()
}

/// A file of the CAPTIF kind.
pub(super) fn captif() -> Vec<u8> {
    let mut text = String::from("Site\tNowhere\n*****DATA*****\nData Point No:\tDistance (mm)\tDepth (mm)\n");
    for row in 0..200 {
        writeln!(text, "{row}\t{}\t{:.3}", 10 * row, height(row)).unwrap();
    }
    text.into_bytes()
}

fn crg_header(format: &str) -> String {
    format!(
        "$CT\nsmall\n$\n$ROAD_CRG ! of a test\nreference_line_start_u = 0.0\nreference_line_end_u = 2.0\n\
         reference_line_increment = 0.01\nlong_section_v_right = -0.1\nlong_section_v_left = 0.1\n\
         long_section_v_increment = 0.1\n$\n$ROAD_CRG_MODS\nscale_z_grid = 0.5\nscale_length = 2\n\
         grid_nan_mode = 2\n$\n$KD_DEFINITION\n#:{format}\nU:reference line u,m,0,0.01\nD:reference line slope,m/m\n\
         D:long section 1,m\nD:long section 2,m\nD:long section 3,m\n$\n$$$$\n"
    )
}

/// An OpenCRG road in text.
pub(super) fn crg_text() -> Vec<u8> {
    let mut text = crg_header("LRFI");
    for row in 0..201 {
        let z = 1e-3 * height(row);
        writeln!(text, "{:10.7}{z:10.7}{z:10.7}{z:10.7}", 0.001).unwrap();
    }
    text.into_bytes()
}

/// The same in bytes.
pub(super) fn crg_binary() -> Vec<u8> {
    let mut bytes = crg_header("KRBI").into_bytes();
    let begin = bytes.len();
    for row in 0..201 {
        let z = 1e-3 * height(row) as f32;
        [0.001, z, z, z].into_iter().for_each(|value| bytes.extend(value.to_be_bytes()));
    }
    while !(bytes.len() - begin).is_multiple_of(80) {
        bytes.extend(f32::NAN.to_be_bytes());
    }
    bytes
}

/// Height maps in either order.
pub(super) fn grids() -> Vec<Vec<u8>> {
    let map = |order| {
        let mut bytes = Vec::new();
        let options = npyz::WriteOptions::new().default_dtype().order(order).shape(&[40, 6]).writer(&mut bytes);
        let mut writer = options.begin_nd().unwrap();
        writer.extend((0..240).map(|place| 1e-3 * height(place))).unwrap();
        writer.finish().unwrap();
        bytes
    };
    vec![map(npyz::Order::C), map(npyz::Order::Fortran)]
}

/// The body of a sealed file: a key, and the first numbers of a model.
pub(super) fn body() -> Vec<u8> {
    let mut bytes = KEY.to_vec();
    bytes.extend([64, 2, 1, 0]);
    bytes.extend((0..40).flat_map(|number| (0.5 * f64::from(number)).to_le_bytes()));
    bytes
}

/// A whole sealed file of another kind.
pub(super) fn sealed() -> Vec<u8> {
    [&b"TWAVEINF\x09\0\0\0"[..], &64_u64.to_le_bytes(), &[3; 96]].concat()
}

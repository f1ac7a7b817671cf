//! Heights given on the command line: a `.npy` array of two dimensions.

use std::path::Path;

use crate::half_space::rough::{Extent, HeightMap};
use crate::storage::array::{Array, ArrayError};

use super::error::CliError;

/// Largest median slope that is accepted as metres per metre: real textures, steps and spikes included, stay below 2.
const STEEPEST: f64 = 20.0;

/// Reads a grid of heights \[m\] above cells of `dx` x `dy` \[m\].
pub(super) fn read_grid(path: &Path, [dx, dy]: [f64; 2]) -> Result<HeightMap, CliError> {
    let name = path.display();
    let fault = |error| match error {
        ArrayError::Io(source) => CliError::Read { path: path.to_owned(), source },
        other => CliError::Usage(format!("{name}: {other}")),
    };
    let array = Array::open(path).map_err(fault)?;
    let extent = match *array.shape() {
        [rows, columns] if rows > 0 && columns > 0 => Extent { nx: rows as usize, ny: columns as usize },
        ref shape => {
            return Err(CliError::Usage(format!(
                "{name} has shape {shape:?}: a two-dimensional array with at least one height is needed"
            )));
        }
    };
    let map = HeightMap { heights: array.into_values().map_err(fault)?, extent, dx, dy };
    check_unit(&map, path)?;
    Ok(map)
}

/// Refuses heights that are plausible in millimetres or micrometres only, by the median slope between neighbouring
/// finite heights: a few spikes or walls do not matter.
fn check_unit(map: &HeightMap, path: &Path) -> Result<(), CliError> {
    let (heights, columns) = (&map.heights, map.extent.ny);
    let across = heights.chunks_exact(columns).flat_map(|row| row.windows(2)).map(|z| (z[1] - z[0]).abs() / map.dy);
    let along = heights.iter().zip(heights.iter().skip(columns)).map(|(a, b)| (b - a).abs() / map.dx);
    let mut slopes: Vec<f64> = across.chain(along).filter(|slope| slope.is_finite()).collect();
    if slopes.is_empty() {
        return Ok(());
    }
    let middle = slopes.len() / 2;
    let slope = *slopes.select_nth_unstable_by(middle, f64::total_cmp).1;
    if slope <= STEEPEST {
        return Ok(());
    }
    let finite = || heights.iter().copied().filter(|z| z.is_finite());
    let unit = if slope < 1e3 * STEEPEST { "millimetres" } else { "micrometres" };
    let [least, greatest] = [finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max)];
    Err(CliError::Usage(format!(
        "the median slope of {} is {slope:.0}: heights or cell sizes are not in metres (most likely the heights \
         are in {unit}; they rise from {least} to {greatest})",
        path.display()
    )))
}

#[cfg(test)]
mod tests {
    use npyz::WriterBuilder;

    use super::*;

    fn grid(heights: Vec<f64>, columns: usize) -> HeightMap {
        HeightMap { extent: Extent { nx: heights.len() / columns, ny: columns }, heights, dx: 4e-3, dy: 2e-3 }
    }

    #[test]
    fn millimetres_and_micrometres_are_recognised() {
        let texture = |i: usize| 4e-4 * (i as f64 * 0.9).sin() + 1e-4 * (i as f64 * 2.3).cos();
        let in_unit = |unit: f64| grid((0..600).map(|i| texture(i) * unit).collect(), 20);
        let check = |map: &HeightMap| check_unit(map, Path::new("z.npy"));
        let unit = |map: &HeightMap| check(map).unwrap_err().to_string();
        assert!(check(&in_unit(1.0)).is_ok());
        assert!(unit(&in_unit(1e3)).contains("in millimetres"));
        assert!(unit(&in_unit(1e6)).contains("in micrometres"));
        // A wall and a spike half a metre high among flat parts; a sphere's cap; a single column.
        let mut steps = vec![0.0; 400];
        steps[..20].fill(0.5);
        steps[130] = 0.5;
        assert!(check(&grid(steps, 20)).is_ok());
        assert!(check(&grid(vec![0.0, f64::NAN, 1e-3], 1)).is_ok());
        assert!(check(&grid(vec![7.0], 1)).is_ok());
    }

    #[test]
    fn arrays_of_another_shape_or_none_at_all_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("z.npy");
        let mut bytes = Vec::new();
        let options = npyz::WriteOptions::new().default_dtype().shape(&[2, 3]).writer(&mut bytes);
        let mut writer = options.begin_nd().unwrap();
        writer.extend([0.0_f32, 1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        writer.finish().unwrap();
        std::fs::write(&path, bytes).unwrap();
        let expected = HeightMap { dx: 1.0, dy: 1.0, ..grid(vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0], 3) };
        assert_eq!(read_grid(&path, [1.0; 2]).unwrap(), expected);
        let wrong = |error: Result<HeightMap, CliError>| error.unwrap_err().to_string();
        let mut bytes = Vec::new();
        let options = npyz::WriteOptions::new().default_dtype().shape(&[3]).writer(&mut bytes);
        let mut writer = options.begin_nd().unwrap();
        writer.extend([0.0_f32, 1.0, 2.0]).unwrap();
        writer.finish().unwrap();
        std::fs::write(&path, bytes).unwrap();
        assert!(wrong(read_grid(&path, [1.0; 2])).contains("has shape [3]"));
        std::fs::write(&path, b"heights").unwrap();
        assert!(wrong(read_grid(&path, [1.0; 2])).contains("is not a complete .npy array"));
        let missing = read_grid(&folder.path().join("none.npy"), [1.0; 2]);
        assert!(matches!(missing, Err(CliError::Read { .. })));
    }
}

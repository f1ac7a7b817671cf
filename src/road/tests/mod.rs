//! Tests of whole roads, from a scene's table to heights.

mod cells;
mod conditioning;
mod crg;
mod drawn;
mod formats;
mod grids;
mod made;
mod measured;

use std::path::PathBuf;

use npyz::WriterBuilder;

use super::error::RoadFileFault;
use super::file_fault::FileFault;
use super::report::RoadNote;
use super::*;
use crate::scene::Road;
use crate::test_models::{CHIP_SEAL, COBBLES, reference};

fn open(spec: &Road, lattice: Lattice) -> RoadSurface {
    RoadSurface::open(spec, lattice, Limits::default()).unwrap()
}

fn refused(spec: &Road, lattice: Lattice) -> RoadError {
    match RoadSurface::open(spec, lattice, Limits::default()) {
        Ok(_) => panic!("the road should be refused"),
        Err(error) => error,
    }
}

fn rows(road: &mut RoadSurface, first: i64, count: usize) -> Vec<f64> {
    let mut out = vec![f64::NAN; count * road.lattice().cells()];
    road.heights(first, count, &mut out).unwrap();
    out
}

fn lattice() -> Lattice {
    Lattice { dx: 1.95 / 512.0, along: 1, dy: 0.002, columns: 70 }
}

fn write(folder: &tempfile::TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

fn npy<T: npyz::Serialize + npyz::AutoSerialize>(
    shape: &[u64],
    order: npyz::Order,
    data: impl IntoIterator<Item = T>,
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer =
        npyz::WriteOptions::new().default_dtype().order(order).shape(shape).writer(&mut bytes).begin_nd().unwrap();
    writer.extend(data).unwrap();
    writer.finish().unwrap();
    bytes
}

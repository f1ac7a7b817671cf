//! A made road on a run's lattice, and its slices: share in contact and displacement as each is pressed into a tread.
//!
//! `cargo run --release --example road_slices`
#![allow(clippy::print_stdout, reason = "an example shows what it found")]

use std::error::Error;

use tyrewave::Scene;
use tyrewave::road::{Lattice, Limits, RoadSurface, SliceBuilder};
use tyrewave::scene::{MadeRoad, NamedTexture, Road};

/// Number of slices shown.
const SLICES: usize = 8;

fn main() -> Result<(), Box<dyn Error>> {
    let road = Road::Made(MadeRoad { seed: 7, texture: Some(NamedTexture::ChipSeal), ..MadeRoad::default() });
    // Elements of 3.8 mm, each of two by sixty cells.
    let lattice = Lattice { dx: 0.0038, along: 2, dy: 0.002, columns: 60 };
    let mut surface = RoadSurface::open(&road, lattice, Limits::default())?;
    let mut heights = vec![0.0; SLICES * lattice.cells()];
    surface.heights(0, SLICES, &mut heights)?;

    // Independent springs under all cells of a slice.
    let springs = SliceBuilder::winkler(lattice.columns)?.with_lines(lattice.along)?;
    println!("highest [mm]  pushed in by 0.5 mm, 1 mm and 2 mm: share that touches, displacement [mm]");
    for curve in springs.build_rows(&heights)? {
        let at = |depth: f64| {
            let (share, displacement) = (curve.stiffness_at(depth), curve.displacement_at(depth));
            format!("{:3.0} % {:5.2}", 100.0 * share, 1e3 * displacement)
        };
        println!("{:12.2}  {}", 1e3 * curve.peak, [5e-4, 1e-3, 2e-3].map(at).join("   "));
    }

    // The lattice that the plan of a scene chooses.
    let loaded = Scene::from_str(tyrewave::scene::DEFAULT, "default")?;
    let lattice = tyrewave::Plan::of(&loaded)?.lattice()?;
    println!("the default scene's elements: {:.2} mm, {} cells across", 1e3 * lattice.dx, lattice.columns);
    Ok(())
}

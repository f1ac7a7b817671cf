//! Profiles of a named road as a table for other tools: distance and height in mm, the profiles one after the other.
//!
//! `cargo run --release --example road_profile -- dac-11 > dac-11.csv`
#![allow(clippy::print_stdout, reason = "an example shows what it found")]

use std::error::Error;

use tyrewave::road::{Lattice, Limits, RoadSurface};
use tyrewave::scene::{MadeRoad, NamedTexture, Road};

/// Length of a profile \[mm\].
const LENGTH: usize = 20_000;
/// Neighbouring profiles, at the spacing of the road: those further apart are means over the width between them.
const PROFILES: usize = 8;

fn main() -> Result<(), Box<dyn Error>> {
    let name = std::env::args().nth(1).unwrap_or("dac-11".to_owned());
    let texture = NamedTexture::ALL.into_iter().find(|texture| texture.name() == name);
    let texture = texture.ok_or(format!("no road.texture is called {name}"))?;
    let road = Road::Made(MadeRoad { seed: 1, texture: Some(texture), ..MadeRoad::default() });
    let lattice = Lattice { dx: 1e-3, along: 1, dy: 1e-3, columns: PROFILES };
    let mut heights = vec![0.0; LENGTH * PROFILES];
    RoadSurface::open(&road, lattice, Limits::default())?.heights(0, LENGTH, &mut heights)?;
    println!("profile,distance_mm,height_mm");
    for profile in 0..PROFILES {
        for (distance, across) in heights.chunks_exact(PROFILES).enumerate() {
            println!("{profile},{distance},{:.6}", 1e3 * across[profile]);
        }
    }
    Ok(())
}

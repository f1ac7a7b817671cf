//! How large a synthesis is: known from its spectrum and lattice before any array is made.

use super::target::TargetSpectrum;
use crate::meter::Work;
use crate::numeric::transform_multiply_adds;
use crate::numeric::windowed_sinc::WindowedSinc;
use crate::road::error::RoadError;
use crate::road::lattice::{Lattice, positive};

/// Lateral period and reach of the filters, in longest wavelengths.
const PERIOD_IN_WAVELENGTHS: f64 = 8.0;
/// Smallest lateral period \[m\].
const SMALLEST_PERIOD: f64 = 1.0;
/// Largest share of the lattice's sampling wavenumber that the spectrum may reach.
const LARGEST_SHARE: f64 = 0.45;
/// Averages of the two-dimensional density over a cell, in multiply-adds for a sample.
const DENSITY: f64 = 600.0;
/// Streams whose samples are held at a time.
pub const STREAMS: usize = 64;

/// Sizes of a [synthesis](super::synthesis).
#[derive(Clone, Debug)]
pub struct Sizes {
    /// Lateral period P \[m\].
    pub period: f64,
    /// Samples on either side that a filtered sample depends on.
    pub reach: usize,
    /// Length M of the transforms.
    pub length: usize,
    /// Rows per chunk.
    pub chunk_rows: usize,
    /// From the lattice to the elements.
    pub interpolation: WindowedSinc,
    /// Lateral components, and streams of noise: as many, or one that is all of them where there is one column only.
    lines: f64,
    streams: f64,
    columns: f64,
}

impl Sizes {
    /// For a spectrum on a lattice of `spacing` \[m\] along; `limit` bounds the bytes of the working arrays.
    ///
    /// # Errors
    /// A `spacing` too coarse for the spectrum's shortest wavelength; working arrays beyond `limit`.
    pub fn new(target: &TargetSpectrum, spacing: f64, lattice: Lattice, limit: u64) -> Result<Self, RoadError> {
        positive("road.spacing", spacing)?;
        let (longest, shortest) = (target.longest(), target.shortest());
        let allowed = LARGEST_SHARE * shortest;
        if spacing > allowed * (1.0 + 1e-9) {
            return Err(RoadError::Spacing { spacing, shortest, allowed });
        }
        let lattice_width = lattice.width();
        let mut period = (PERIOD_IN_WAVELENGTHS * longest).max(SMALLEST_PERIOD);
        while period < 2.0 * lattice_width {
            period *= 2.0;
        }
        let share = spacing / shortest;
        let interpolation = WindowedSinc::new(share, 1.0 - share, 80.0);
        let reach = (PERIOD_IN_WAVELENGTHS * longest / spacing).ceil();
        let margin = 2.0 * (reach + interpolation.half_width() + 2.0);
        let length = (2.0 * margin).max(margin + 16.0 * lattice.cell() / spacing).max(1024.0);
        let highest = if lattice.columns > 1 { (0.5 / lattice.dy).min(1.0 / shortest) } else { 1.0 / shortest };
        let lines = (highest * period).ceil() + 1.0;
        let streams = (period / shortest).ceil() + 1.0;
        let chunk = ((length - margin) * spacing / lattice.cell()).floor().max(1.0);
        // The length is yet to be rounded up to a power of two.
        let across = lattice.columns as f64;
        let needed = 2.0 * (length * (4.0 * streams + 16.0 * STREAMS as f64 + 8.0 * across) + chunk * 24.0 * across);
        if needed.is_nan() || needed > limit as f64 {
            return Err(RoadError::TextureTooLarge { longest, spacing, needed: needed as u64, limit });
        }
        let length = (length as usize).next_power_of_two();
        Ok(Self {
            period,
            reach: reach as usize,
            length,
            chunk_rows: (((length as f64 - margin) * spacing / lattice.cell()) as usize).max(1),
            interpolation,
            lines,
            streams: if lattice.columns > 1 { lines } else { 1.0 },
            columns: across,
        })
    }

    /// What making the filters takes: two transforms and a spectrum for each stream.
    pub fn opening(&self) -> Work {
        let multiply_adds =
            self.lines * self.length as f64 * DENSITY + self.streams * 2.0 * transform_multiply_adds(self.length);
        Work { multiply_adds: multiply_adds as u64, bytes: (4.0 * self.streams * self.length as f64) as u64 }
    }

    /// What a chunk takes, and the arrays that it is made from: noise and two transforms for each stream, the sum across.
    pub fn chunk(&self) -> Work {
        let length = self.length as f64;
        let noise = 40.0 * length;
        let multiply_adds =
            self.streams * (2.0 * transform_multiply_adds(self.length) + noise + 2.0 * length * self.columns);
        let bytes =
            length * (16.0 * STREAMS as f64 + 8.0 * self.columns) + 3.0 * 8.0 * self.chunk_rows as f64 * self.columns;
        Work { multiply_adds: multiply_adds as u64, bytes: bytes as u64 }
    }
}

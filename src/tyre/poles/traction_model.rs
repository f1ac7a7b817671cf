//! Rational models of waves under tractions: poles, and channels from forces to displacements, as they are stored.
//!
//! Forces and displacements have the phases of the fit (module `tractions`).

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use super::pole_model::PoleModel;
use crate::storage::{CacheKind, Cached, Format};
use crate::tyre::influence::COMPONENTS;

/// Rank-one part of a wave's influence at a pole: output times input.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct PoleChannel {
    /// Weight of each force.
    pub input: [Complex64; COMPONENTS],
    /// Displacement by component \[m/(N s)\].
    pub output: [Complex64; COMPONENTS],
    /// Displacement of the odd part; 0 at rest.
    pub odd: [Complex64; COMPONENTS],
}

impl PoleChannel {
    /// Residues of the even and of the odd part, of displacement a by force b.
    fn residues(&self, a: usize, b: usize) -> [Complex64; 2] {
        [self.output[a] * self.input[b], self.odd[a] * self.input[b]]
    }
}

/// Poles and channels of a list of waves; a pole with several channels is stored as often.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct TractionModel {
    pub(super) poles: PoleModel,
    pub(super) channels: Vec<PoleChannel>,
    pub(super) turns: bool,
    /// Largest error of all waves.
    pub(super) error: f64,
}

impl TractionModel {
    /// Bytes of a channel with its pole on disk, counting conjugates; pairs are stored once.
    pub(crate) const BYTES_OF_CHANNEL: f64 = (size_of::<Complex64>() + size_of::<PoleChannel>()) as f64 / 2.0;

    /// Number of waves.
    pub(crate) fn len(&self) -> usize {
        self.poles.len()
    }

    /// Number of channels of all waves, conjugates counted.
    pub(crate) fn order(&self) -> usize {
        self.poles.order()
    }

    pub(crate) fn evaluations(&self) -> u64 {
        self.poles.evaluations()
    }

    #[cfg(test)]
    pub(crate) fn error(&self) -> f64 {
        self.error
    }

    /// True for a tyre that turns: there are odd parts.
    pub(crate) fn turns(&self) -> bool {
        self.turns
    }

    /// A wave's poles by channel, how many of them are pairs, and the channels.
    pub(crate) fn wave(&self, wave: usize) -> (&[Complex64], usize, &[PoleChannel]) {
        let (poles, pairs) = self.poles.of(wave);
        (poles, pairs, &self.channels[self.poles.range(wave)])
    }

    /// Residues of displacement a by force b, by channel: even part, odd part.
    pub(crate) fn residues(&self, wave: usize, a: usize, b: usize) -> [Vec<Complex64>; 2] {
        let (_, _, channels) = self.wave(wave);
        [0, 1].map(|part| channels.iter().map(|channel| channel.residues(a, b)[part]).collect())
    }
}

impl Cached for TractionModel {
    const KIND: CacheKind = CacheKind {
        extension: "tractions",
        format: Format { magic: b"TWAVETRA", version: 2, name: "a model of tractions of contact cells" },
    };

    fn is_valid(&self) -> bool {
        self.poles.fits(0) && self.channels.len() == self.poles.stored()
    }
}

//! Poles and residues of a list of functions, one function after the other.

use std::ops::Range;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use super::modes::WaveModes;
use crate::numeric::rational::partial_fractions::is_pair;
use crate::storage::{CacheKind, Cached, Format};
use crate::tyre::influence::WaveValues;

/// Poles of a list of functions, and residues over them in each of some faces. A complex pole is stored once, with
/// Im lambda > 0, and stands for itself and its conjugate; a real pole has Im lambda = 0 and a real residue. Within a
/// function the pairs come first.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct PoleModel {
    /// Position of the first pole of each function; one more at the end.
    offsets: Vec<usize>,
    /// Position of the first real pole of each function.
    first_real: Vec<usize>,
    /// lambda \[1/s\].
    poles: Vec<Complex64>,
    /// R of the even and of the odd parts by face \[m/(N s)\]; no odd ones at rest.
    pub(super) residues: Vec<[Vec<Complex64>; 2]>,
    evaluations: u64,
}

impl PoleModel {
    /// No functions, whose residues are those of `faces` faces.
    pub(crate) fn new(faces: usize) -> Self {
        let residues = vec![Default::default(); faces];
        Self { offsets: vec![0], first_real: Vec::new(), poles: Vec::new(), residues, evaluations: 0 }
    }

    /// Appends a function: its poles, in the stored order, the residues of its even and odd parts by face, those of odd
    /// parts empty where these are 0, and the evaluations of the compliance that its fit took.
    pub(crate) fn push(&mut self, poles: &[Complex64], parts: [&[Vec<Complex64>]; 2], evaluations: u64) {
        let pairs = poles.iter().filter(|&&pole| is_pair(pole)).count();
        self.first_real.push(self.poles.len() + pairs);
        for (residues, (even, odd)) in self.residues.iter_mut().zip(parts[0].iter().zip(parts[1])) {
            residues[0].extend_from_slice(even);
            if !odd.is_empty() {
                // Zeros for functions before it that rotation does not affect.
                residues[1].resize(self.poles.len(), Complex64::ZERO);
                residues[1].extend_from_slice(odd);
            }
        }
        self.poles.extend_from_slice(poles);
        self.offsets.push(self.poles.len());
        self.evaluations += evaluations;
    }

    /// The model with all of its functions.
    pub(crate) fn complete(mut self) -> Self {
        for [_, odd] in self.residues.iter_mut().filter(|[_, odd]| !odd.is_empty()) {
            odd.resize(self.poles.len(), Complex64::ZERO);
        }
        self
    }

    /// Number of functions.
    pub fn len(&self) -> usize {
        self.first_real.len()
    }

    /// True without any function.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes on disk of one of a pair of poles, with residues in `faces` faces; a real pole takes twice as many.
    pub(crate) fn bytes_of_pole(faces: usize, turns: bool) -> f64 {
        let parts = if turns { 2 } else { 1 };
        (size_of::<Complex64>() * (1 + faces * parts)) as f64 / 2.0
    }

    /// Number of poles of all functions, conjugates counted.
    pub fn order(&self) -> usize {
        self.poles.iter().map(|&pole| if is_pair(pole) { 2 } else { 1 }).sum()
    }

    /// Number of poles as they are stored, pairs counted once.
    pub(crate) fn stored(&self) -> usize {
        self.poles.len()
    }

    /// Evaluations of the compliance that the fits took.
    pub fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// True for a tyre that turns: some functions then have odd parts.
    pub fn turns(&self) -> bool {
        self.residues.first().is_some_and(|[_, odd]| !odd.is_empty())
    }

    /// Positions of a function's poles, and of its residues.
    pub(super) fn range(&self, function: usize) -> Range<usize> {
        self.offsets[function]..self.offsets[function + 1]
    }

    /// A function's poles, and how many of them are pairs.
    pub(super) fn of(&self, function: usize) -> (&[Complex64], usize) {
        (&self.poles[self.range(function)], self.first_real[function] - self.offsets[function])
    }

    /// True if positions and lengths read from a file are consistent, with residues of `faces` faces.
    pub(super) fn fits(&self, faces: usize) -> bool {
        let (stored, odd) = (self.poles.len(), if self.turns() { self.poles.len() } else { 0 });
        let ends = self.offsets.get(1..).unwrap_or_default();
        let ranges = self.offsets.iter().zip(&self.first_real).zip(ends);
        self.offsets.first() == Some(&0)
            && self.offsets.last() == Some(&stored)
            && ends.len() == self.first_real.len()
            && ranges.into_iter().all(|((start, real), end)| start <= real && real <= end)
            && self.residues.len() == faces
            && self.residues.iter().all(|parts| parts.each_ref().map(Vec::len) == [stored, odd])
    }

    /// Poles and residues of a function in a face, without a constant.
    pub(super) fn modes(&self, function: usize, face: usize) -> WaveModes<'_> {
        let ((poles, pairs), range) = (self.of(function), self.range(function));
        let [even, odd] = &self.residues[face];
        WaveModes { poles, residues: &even[range.clone()], odd: odd.get(range).unwrap_or(&[]), pairs, constant: 0.0 }
    }

    /// Poles and residues of a wave in the only face, without odd ones where rotation does not affect it.
    pub(crate) fn wave(&self, wave: usize) -> WaveModes<'_> {
        let modes = self.modes(wave, 0);
        let is_affected = modes.odd.iter().any(|residue| residue.norm() > 0.0);
        WaveModes { odd: if is_affected { modes.odd } else { &[] }, ..modes }
    }

    /// Values of all waves at a real s \[1/s\], in their order.
    pub fn values(&self, s: f64) -> WaveValues {
        let all = |of: fn(WaveModes<'_>, Complex64) -> Complex64| -> Vec<f64> {
            (0..self.len()).map(|wave| of(self.wave(wave), s.into()).re).collect()
        };
        let odd = || all(|modes, s| modes.evaluate_odd(s));
        WaveValues { even: all(|modes, s| modes.evaluate(s)), odd: if self.turns() { odd() } else { Vec::new() } }
    }
}

impl Cached for PoleModel {
    const KIND: CacheKind = CacheKind {
        extension: "cells",
        format: Format { magic: b"TWAVECEL", version: 4, name: "a model of contact cells" },
    };

    fn is_valid(&self) -> bool {
        self.fits(1)
    }
}

//! Velocities by tangential forces, beside those by normal ones (`velocity_table`).
//!
//! A lateral number has three components of force, each in its own shape across. The tyre answers all of them at the s
//! of the run's rule by C_zx, C_zy and, along the tread, C_xx and C_xy, wave by wave ([`TractionLines`]). There are no
//! poles of them: shear waves are not among those of the normal motion.

use num_complex::Complex64;

use super::layout::SegmentLayout;
use super::transfer::{TransferKind, VibrationField, symbols};
use crate::scene::Tyre;
use crate::tyre::influence::TractionLines;

/// The tyre as it answers tangential forces.
pub(crate) struct TangentialForces {
    lines: TractionLines,
    /// Share that is observed of what each lateral number moves.
    shares: Vec<f64>,
    /// s at the bins of the material frame.
    symbols: Vec<Complex64>,
}

impl TangentialForces {
    /// Prepares the answer of a tyre to forces of some lateral numbers, each with the share that is observed of it;
    /// compliances within a relative `tolerance`.
    pub(crate) fn new(tyre: &Tyre, layout: &SegmentLayout, numbers: &[(usize, f64)], tolerance: f64) -> Self {
        let (kind, highest) = (TransferKind::Rule, 0.5 / layout.time_step);
        let angular = |frequency: f64| std::f64::consts::TAU * frequency;
        let symbol = |frequency: f64| kind.symbol(layout.rule, angular(frequency), layout.time_step);
        let (lateral, shares): (Vec<usize>, Vec<f64>) = numbers.iter().copied().unzip();
        let lines = TractionLines::new(tyre, layout.elements, lateral, (highest, tolerance), symbol);
        Self { lines, shares, symbols: symbols(layout, kind) }
    }

    /// Writes the velocities of a field for unit forces along, then across, in the waves n and -n \[m/(N s)\], into the
    /// channels behind those of normal forces, bin by bin; a motion along the tread over i, and over -i.
    pub(super) fn put(
        &self,
        layout: &SegmentLayout,
        field: VibrationField,
        n: usize,
        [forwards, backwards]: [&mut [Complex64]; 2],
    ) {
        let (count, bins) = (self.shares.len(), self.symbols.len());
        for (index, share) in self.shares.iter().enumerate() {
            let wave = self.lines.wave(index, n);
            for (bin, symbol) in self.symbols.iter().enumerate() {
                let answers = wave.at(bin as f64 * layout.resolution());
                let ways = [&mut *forwards, &mut *backwards].into_iter().zip([-Complex64::i(), Complex64::i()]);
                for ((out, turn), answer) in ways.zip(answers) {
                    let moved = match field {
                        VibrationField::Tread => answer.surface[2],
                        VibrationField::Belt => answer.bottom,
                        VibrationField::Tangential => answer.surface[0].map(|along| turn * along),
                    };
                    for force in 0..2 {
                        out[((1 + force) * count + index) * bins + bin] = share * symbol * moved[force];
                    }
                }
            }
        }
    }
}

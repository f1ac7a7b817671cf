//! Velocities due to tangential forces, beside those due to normal ones (`velocity_table`).
//!
//! A lateral number has three components of force, each with a different shape across. The tyre responds to all of them
//! at the s of the run's rule by C_zx, C_zy and, along the tread, C_xx and C_xy, wave by wave ([`TractionLines`]). They
//! have no poles here: shear waves are not among those of the normal motion.

use num_complex::Complex64;

use super::layout::SegmentLayout;
use super::transfer::{TransferKind, VibrationField, symbols};
use crate::scene::Tyre;
use crate::tyre::influence::TractionLines;

/// Response of the tyre to tangential forces.
pub(crate) struct TangentialForces {
    lines: TractionLines,
    /// Share of each lateral number's motion that is observed.
    shares: Vec<f64>,
    /// s at the bins of the material frame.
    symbols: Vec<Complex64>,
}

impl TangentialForces {
    /// Response to forces of some lateral numbers, each with the share of its motion that is observed; compliances
    /// within a relative `tolerance`.
    pub(crate) fn new(tyre: &Tyre, layout: &SegmentLayout, numbers: &[(usize, f64)], tolerance: f64) -> Self {
        let (kind, highest) = (TransferKind::Rule, 0.5 / layout.time_step);
        let angular = |frequency: f64| std::f64::consts::TAU * frequency;
        let symbol = |frequency: f64| kind.symbol(layout.rule, angular(frequency), layout.time_step);
        let (lateral, shares): (Vec<usize>, Vec<f64>) = numbers.iter().copied().unzip();
        let lines = TractionLines::new(tyre, layout.elements, lateral, (highest, tolerance), symbol);
        Self { lines, shares, symbols: symbols(layout, kind) }
    }

    /// Writes the velocities of a field for unit forces along, then across, in the waves n and -n \[m/(N s)\], into the
    /// channels behind those of normal forces, bin by bin; a motion along the tread divided by i, and by -i.
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

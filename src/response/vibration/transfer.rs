//! Velocity for unit force: s H_n(s) at the bins of the material frame.
//!
//! The standard transfer, [`TransferKind::Rule`], is that of the run's multistep rule: the s by which it stands for i w is mu(zeta)/dt at zeta = exp(-i w dt), difference quotients of the rule for
//! derivatives. The velocities are then those that the run's own recursion gives. The tyre's own transfer, s = i w, looks more exact and is not: the forces of a rolling contact have a notch
//! wherever the tyre they were found with resonates, and that is the rule's tyre. Peaks of another one, (w dt)^2/3 higher and less damped, stand beside the notches. Measured, N = 128, 4 steps an
//! element, `bdf2`, against elements followed in the time domain: +0.4 dB at 100 Hz, +1.4 at 200, +5 at 630. How far the two are apart is a measure of the rule's error.
//!
//! A rule of several stages has as many rates as stages; taken is the one nearest to i w, which moves the resonances as the rule does. The course of its forces within a step is not known,
//! only their mean, and the velocities are right to some decibel: at points before and behind the patch, N = 256, a step an element, `sdirk2` is up to 1.1 dB from the elements that pass in
//! the bands to 630 Hz (1.8 dB with i w), `sdirk3` 1.3 (3.6), `sdirk2` 12 dB at 1 kHz, w dt = 2.2, where the level is lowest (20 dB); `bdf2` 0.04 dB to 1 kHz (35 dB). The hold has i w.

use num_complex::Complex64;
use pulp::Arch;

use super::layout::SegmentLayout;
use crate::scene::TimeRule;
use crate::tyre::influence::Field;
use crate::tyre::rational::{Modes, RationalModel};
use crate::tyre::tangential::TangentialModel;

/// Which velocity is observed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum VibrationField {
    /// Normal velocity of the tread surface, local deformation included.
    Tread,
    /// Normal velocity of the belt's inner face.
    Belt,
    /// Tangential velocity of the tread surface.
    Tangential,
}

impl VibrationField {
    /// Its name in results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tread => "tread",
            Self::Belt => "belt",
            Self::Tangential => "tangential",
        }
    }
}

/// What stands for s at an angular frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TransferKind {
    /// i w.
    Exact,
    /// mu(zeta)/dt of a rule, of several the one nearest to i w; i w for the hold.
    Rule(TimeRule),
}

impl TransferKind {
    /// s at the angular frequency w \[rad/s\] for a time step \[s\].
    pub fn symbol(self, angular_frequency: f64, time_step: f64) -> Complex64 {
        let exact = Complex64::new(0.0, angular_frequency);
        match self {
            Self::Rule(rule) if angular_frequency != 0.0 => exact * rule.relative_rate(angular_frequency * time_step),
            _ => exact,
        }
    }
}

/// The tyre as it answers forces on the tread elements.
#[derive(Clone, Copy, Debug)]
pub struct TyreResponse<'a> {
    /// Poles and residues.
    pub model: &'a RationalModel,
    /// Factor of all influence functions; 1 unless a bedding's carcass is scaled.
    pub scale: f64,
    /// Compliance of an element's own spring \[m/N\]; 0 without a bedding.
    pub spring: f64,
    /// Residues of the tangential displacement over the same poles, where it is wanted.
    pub tangential: Option<&'a TangentialModel>,
}

impl TyreResponse<'_> {
    /// The modes of a wavenumber n >= 0 with the residues of a field; `None` where they are not there.
    fn modes(&self, n: usize, field: VibrationField) -> Option<Modes<'_>> {
        match field {
            VibrationField::Tread => self.model.modes(n, self.model.driven),
            VibrationField::Belt => self.model.modes(n, Field::Bottom),
            VibrationField::Tangential => {
                let tangential = self.tangential?;
                let modes = self.model.modes(n, self.model.driven)?;
                Some(Modes { residues: &tangential.residues[n], constant: tangential.constants[n], ..modes })
            }
        }
    }

    /// s H_n(s) \[m/(N s)\] of a field for every s of a list, n >= 0, into `out`; whether the field is there. The tangential displacement is odd in n and this times i.
    pub fn velocities(&self, n: usize, field: VibrationField, symbols: &[Complex64], out: &mut [Complex64]) -> bool {
        let Some(modes) = self.modes(n, field) else { return false };
        let mut own = 0.0;
        if field == VibrationField::Tread {
            own += self.spring / self.model.elements as f64;
        }
        partial_fractions(&modes, modes.constant, symbols, out);
        for (value, symbol) in out.iter_mut().zip(symbols) {
            *value = symbol * (self.scale * *value + own);
        }
        true
    }
}

/// s at the bins 0..=K/2 of the material frame.
pub fn symbols(layout: &SegmentLayout, kind: TransferKind) -> Vec<Complex64> {
    (0..layout.bins()).map(|bin| kind.symbol(layout.angular_frequency(bin), layout.time_step)).collect()
}

/// Points that are evaluated side by side.
const LANE: usize = 64;

/// constant + sum of the poles' shares at every s. A pair is (b s + a)/(s^2 - p s + m), a real pole b/(s - lambda): plain loops over many s, which the compiler makes vectors of.
fn partial_fractions(modes: &Modes<'_>, constant: f64, symbols: &[Complex64], out: &mut [Complex64]) {
    let arch = Arch::new();
    for (symbols, out) in symbols.chunks(LANE).zip(out.chunks_mut(LANE)) {
        let (mut s, mut square, mut sum) = ([[0.0; LANE]; 2], [[0.0; LANE]; 2], [[constant; LANE], [0.0; LANE]]);
        for (lane, &symbol) in symbols.iter().enumerate() {
            let second = symbol * symbol;
            (s[0][lane], s[1][lane]) = (symbol.re, symbol.im);
            (square[0][lane], square[1][lane]) = (second.re, second.im);
        }
        arch.dispatch(
            #[inline(always)]
            || {
                for (index, (pole, residue)) in modes.poles.iter().zip(modes.residues).enumerate() {
                    let pair = index < modes.pairs;
                    let [b, a] =
                        if pair { [2.0 * residue.re, -2.0 * (residue * pole.conj()).re] } else { [0.0, residue.re] };
                    let [two, p, m] = if pair { [1.0, 2.0 * pole.re, pole.norm_sqr()] } else { [0.0, -1.0, -pole.re] };
                    for lane in 0..LANE {
                        let (re, im) = (s[0][lane], s[1][lane]);
                        let (over_re, over_im) = (b * re + a, b * im);
                        let under_re = two * square[0][lane] - p * re + m;
                        let under_im = two * square[1][lane] - p * im;
                        let scale = 1.0 / (under_re * under_re + under_im * under_im);
                        sum[0][lane] += (over_re * under_re + over_im * under_im) * scale;
                        sum[1][lane] += (over_im * under_re - over_re * under_im) * scale;
                    }
                }
            },
        );
        for (lane, value) in out.iter_mut().enumerate() {
            *value = Complex64::new(sum[0][lane], sum[1][lane]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_points_at_once_are_the_partial_fractions() {
        let poles = [Complex64::new(-30.0, 600.0), Complex64::new(-900.0, 2e4), (-55.0).into()];
        let residues = [Complex64::new(0.3, -2.0), Complex64::new(-4.0, 9.0), 7.0.into()];
        let modes = Modes { poles: &poles, residues: &residues, pairs: 2, constant: 1e-3 };
        let points: Vec<Complex64> = (0..150).map(|k| Complex64::new(f64::from(k % 7), f64::from(k) * 211.0)).collect();
        let mut values = vec![Complex64::ZERO; points.len()];
        partial_fractions(&modes, modes.constant, &points, &mut values);
        for (&s, value) in points.iter().zip(values) {
            let exact = modes.evaluate(s);
            assert!((value - exact).norm() < 1e-13 * exact.norm(), "{s}: {value} {exact}");
        }
    }

    #[test]
    fn the_rules_symbol_is_i_w_at_low_frequencies() {
        for rule in TimeRule::ALL {
            let symbol = TransferKind::Rule(rule).symbol(100.0, 1e-4);
            assert!((symbol - TransferKind::Exact.symbol(100.0, 1e-4)).norm() < 0.6, "{rule:?}: {symbol}");
        }
    }
}

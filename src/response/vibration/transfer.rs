//! Velocity for unit force: s H_n(s) at the bins of the material frame.
//!
//! The standard transfer, [`TransferKind::Rule`], is that of the run's time rule. For a multistep rule the s that
//! replaces i w is mu(zeta)/dt at zeta = exp(-i w dt), difference quotients of the rule for derivatives. The velocities
//! are then those of the run's recursion. The exact transfer of the tyre, s = i w, seems more accurate and is not:
//! the forces of a rolling contact have a notch wherever the tyre that they were computed with resonates, and that is
//! the tyre under the rule. Peaks of another one, (w dt)^2/3 higher and less damped, stand beside the notches.
//! Measured, N = 128, 4 steps an element, `bdf2`, against elements followed in the time domain: +0.4 dB at 100 Hz, +1.4
//! at 200, +5 at 630. The difference of the two is a measure of the rule's error.
//!
//! The forces of a Runge-Kutta rule's stages each have a separate transfer, again that of the run's recursion:
//! `stage_transfer`.

use num_complex::Complex64;
use pulp::Arch;

use super::both_directions::BothDirections;
use super::layout::SegmentLayout;
use super::products;
use super::stage_transfer::{ScaledModes, StageTransfer};
use crate::scene::TimeRule;
use crate::tyre::influence::Field;
use crate::tyre::poles::{RationalModel, TangentialModel, WaveModes};

/// Velocity that is observed.
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
    /// Name in results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tread => "tread",
            Self::Belt => "belt",
            Self::Tangential => "tangential",
        }
    }
}

/// Choice of s at an angular frequency: that of the time rule, or the exact one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TransferKind {
    /// i w; the forces of a step's stages act at their times.
    Exact,
    /// mu(zeta)/dt of the run's rule. A Runge-Kutta rule has matrices instead.
    Rule,
}

impl TransferKind {
    /// Value of s at the angular frequency w \[rad/s\] for a rule and a time step \[s\]. For a Runge-Kutta rule i w,
    /// the factor of its displacements.
    pub fn symbol(self, rule: TimeRule, angular_frequency: f64, time_step: f64) -> Complex64 {
        let exact = Complex64::new(0.0, angular_frequency);
        if self == Self::Rule && rule.is_multistep() && angular_frequency != 0.0 {
            return exact * rule.relative_rate(angular_frequency * time_step);
        }
        exact
    }
}

/// Response of the tyre to forces on the tread elements.
#[derive(Clone, Copy, Debug)]
pub struct TyreResponse<'a> {
    /// Poles and residues.
    pub model: &'a RationalModel,
    /// Factor of all influence functions; 1 unless a bedding's carcass is scaled.
    pub scale: f64,
    /// Compliance of an element's spring \[m/N\]; 0 without a bedding.
    pub spring: f64,
    /// Residues of the tangential displacement over the same poles, where that field is needed.
    pub tangential: Option<&'a TangentialModel>,
}

impl TyreResponse<'_> {
    /// Modes of a wavenumber n >= 0 with the residues of a field; `None` where the field is missing.
    fn modes(&self, n: usize, field: VibrationField) -> Option<ScaledModes<'_>> {
        let mut odd_constant = 0.0;
        let modes = match field {
            VibrationField::Tread => self.model.modes(n, self.model.driven),
            VibrationField::Belt => self.model.modes(n, Field::Bottom),
            VibrationField::Tangential => {
                let tangential = self.tangential?;
                odd_constant = tangential.odd_constants.get(n).copied().unwrap_or(0.0);
                Some(tangential.modes(n, self.model.modes(n, self.model.driven)?))
            }
        };
        let added_compliance =
            if field == VibrationField::Tread { self.spring / self.model.elements as f64 } else { 0.0 };
        Some(ScaledModes { modes: modes?, scale: self.scale, added_compliance, odd_constant })
    }

    pub(super) fn turns(&self) -> bool {
        self.model.turns()
    }

    /// Writes s H_n(s) \[m/(N s)\] of a field for every s of a list, n >= 0, into `out`; false where the field is
    /// missing. The tangential displacement is odd in n and this times i. For a tyre that turns it is the even part E_n
    /// of H_n, and for the tangential displacement that of H_n/i.
    pub fn velocities(&self, n: usize, field: VibrationField, symbols: &[Complex64], out: &mut [Complex64]) -> bool {
        let Some(modes) = self.modes(n, field) else { return false };
        velocities_of(&modes, symbols, out);
        true
    }
}

fn velocities_of(
    ScaledModes { modes, scale, added_compliance, .. }: &ScaledModes<'_>,
    symbols: &[Complex64],
    out: &mut [Complex64],
) {
    partial_fractions(modes, modes.constant, symbols, out);
    for (value, symbol) in out.iter_mut().zip(symbols) {
        *value = symbol * (scale * *value + added_compliance);
    }
}

/// Values of s at the bins 0..=K/2 of the material frame.
pub fn symbols(layout: &SegmentLayout, kind: TransferKind) -> Vec<Complex64> {
    (0..layout.bins()).map(|bin| kind.symbol(layout.rule, layout.angular_frequency(bin), layout.time_step)).collect()
}

/// From the forces of a step's stages to velocities at the bins 0..=K/2 of the material frame.
pub(super) struct Transfers {
    stages: usize,
    symbols: Vec<Complex64>,
    action: ForceAction,
}

enum ForceAction {
    /// One force per step.
    OneForce,
    /// The recursion of a Runge-Kutta rule.
    Stages(StageTransfer),
    /// For every stage the weight of its force, with the phase of the time relative to the step's end at which it acts:
    /// stages x bins.
    Weighted(Vec<Complex64>),
}

/// Part of H_n.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// E_n; the whole at rest.
    Even,
    /// O_n; zero at rest.
    Odd,
}

/// Quadratic forms of the forces of one wavenumber and direction, bin by bin: weights of the stages' products.
#[derive(Clone, Debug, Default)]
pub(super) struct Forms {
    /// |v|^2.
    pub(super) squares: Vec<f64>,
    /// Power that the forces put in; empty where it is not needed.
    pub(super) powers: Vec<f64>,
}

impl Transfers {
    pub(super) fn new(layout: &SegmentLayout, kind: TransferKind) -> Self {
        let symbols = symbols(layout, kind);
        let action = match (layout.rule.runge_kutta(), kind) {
            (None, _) => ForceAction::OneForce,
            (Some(method), TransferKind::Rule) => {
                ForceAction::Stages(StageTransfer::new(method, symbols.clone(), layout.time_step))
            }
            (Some(_), TransferKind::Exact) => {
                let factors = layout
                    .actions()
                    .into_iter()
                    .flat_map(|[weight, delay]| symbols.iter().map(move |symbol| weight * (-symbol * delay).exp()));
                ForceAction::Weighted(factors.collect())
            }
        };
        Self { stages: layout.stages(), symbols, action }
    }

    /// Writes the velocities of a field by a part of H_n for unit force at each stage \[m/(N s)\], stages x bins, n >=
    /// 0; false where the field is missing.
    pub(super) fn velocities(
        &self,
        tyre: &TyreResponse<'_>,
        n: usize,
        field: VibrationField,
        part: Part,
        out: &mut [Complex64],
    ) -> bool {
        let Some(modes) = tyre.modes(n, field) else { return false };
        match (part, modes.odd()) {
            (Part::Even, _) => self.velocities_of(&modes, out),
            (Part::Odd, Some(odd)) => self.velocities_of(&odd, out),
            (Part::Odd, None) => out.fill(Complex64::ZERO),
        }
        true
    }

    fn velocities_of(&self, modes: &ScaledModes<'_>, out: &mut [Complex64]) {
        if let ForceAction::Stages(transfer) = &self.action {
            transfer.velocities(modes, out);
            return;
        }
        let (first, others) = out.split_at_mut(self.symbols.len());
        velocities_of(modes, &self.symbols, first);
        if let ForceAction::Weighted(factors) = &self.action {
            others.chunks_exact_mut(first.len()).for_each(|row| row.copy_from_slice(first));
            out.iter_mut().zip(factors).for_each(|(value, factor)| *value *= factor);
        }
    }

    /// Quantities linear in H_n, `rows` x bins, for waves of both directions.
    fn both_directions(
        &self,
        modes: &ScaledModes<'_>,
        rows: usize,
        linear: impl Fn(&ScaledModes<'_>, &mut [Complex64]),
    ) -> BothDirections<Vec<Complex64>> {
        let of = |modes: &ScaledModes<'_>| {
            let mut values = vec![Complex64::ZERO; rows * self.symbols.len()];
            linear(modes, &mut values);
            values
        };
        BothDirections::of_parts(of(modes), modes.odd().map(|odd| of(&odd)))
    }

    fn velocities_both_directions(&self, modes: &ScaledModes<'_>) -> BothDirections<Vec<Complex64>> {
        self.both_directions(modes, self.stages, |modes, out| self.velocities_of(modes, out))
    }

    /// Weights of the stages' products in the power that forces put in, bin by bin.
    pub(super) fn forms_of_power(&self, modes: &ScaledModes<'_>) -> BothDirections<Vec<f64>> {
        self.powers(modes, || self.velocities_both_directions(modes)).map(|matrices| self.weights_of_power(matrices))
    }

    fn weights_of_power(&self, matrices: &[Complex64]) -> Vec<f64> {
        let (stages, bins) = (self.stages, self.symbols.len());
        let count = products::count(stages);
        let mut powers = vec![0.0; bins * count];
        for (bin, weights) in powers.chunks_exact_mut(count).enumerate() {
            products::weights_of_power(stages, |i, j| matrices[(i * stages + j) * bins + bin], weights);
        }
        powers
    }

    /// Quadratic forms of a wavenumber n >= 0; that of the power only for the velocity on which the forces do work.
    /// `None` where the field is missing.
    pub(super) fn forms(
        &self,
        tyre: &TyreResponse<'_>,
        n: usize,
        field: VibrationField,
    ) -> Option<BothDirections<Forms>> {
        let (stages, bins) = (self.stages, self.symbols.len());
        let modes = tyre.modes(n, field)?;
        let velocities = self.velocities_both_directions(&modes);
        let count = products::count(stages);
        let mut forms = velocities.map(|rows| {
            let mut squares = vec![0.0; bins * count];
            for (bin, weights) in squares.chunks_exact_mut(count).enumerate() {
                products::weights_of_square(stages, |stage| rows[stage * bins + bin], weights);
            }
            Forms { squares, powers: Vec::new() }
        });
        if field == VibrationField::Tread {
            let powers = self.powers(&modes, || velocities).map(|matrices| self.weights_of_power(matrices));
            forms.forwards.powers = powers.forwards;
            forms.backwards.iter_mut().zip(powers.backwards).for_each(|(forms, powers)| forms.powers = powers);
        }
        Some(forms)
    }

    /// Matrices of the power put in, stages x stages x bins, for a tyre with these velocities.
    fn powers(
        &self,
        tyre: &ScaledModes<'_>,
        velocities: impl FnOnce() -> BothDirections<Vec<Complex64>>,
    ) -> BothDirections<Vec<Complex64>> {
        match &self.action {
            ForceAction::OneForce => velocities(),
            // These do not follow from the velocities.
            ForceAction::Stages(transfer) => {
                self.both_directions(tyre, self.stages * self.stages, |modes, out| transfer.powers(modes, out))
            }
            // The force is sum_i a_i F_i and the velocity the exact one for it, Y_i = Y a_i.
            ForceAction::Weighted(factors) => velocities().map(|velocities| {
                factors
                    .chunks_exact(self.symbols.len())
                    .flat_map(|factors| {
                        velocities.iter().zip(factors.iter().cycle()).map(|(v, factor)| factor.conj() * v)
                    })
                    .collect()
            }),
        }
    }
}

/// Points that are evaluated together, for vector instructions.
const LANE: usize = 64;

/// The constant plus the sum of the poles' contributions at every s. A pair is (b s + a)/(s^2 - p s + m), a real pole
/// b/(s - lambda). Plain loops over many s, which the compiler vectorises.
fn partial_fractions(modes: &WaveModes<'_>, constant: f64, symbols: &[Complex64], out: &mut [Complex64]) {
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
        let modes = WaveModes { poles: &poles, residues: &residues, odd: &[], pairs: 2, constant: 1e-3 };
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
            let [symbol, exact] = [TransferKind::Rule, TransferKind::Exact].map(|kind| kind.symbol(rule, 100.0, 1e-4));
            assert!((symbol - exact).norm() < 0.6, "{rule:?}: {symbol}");
        }
    }
}

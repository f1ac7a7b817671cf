//! Velocity and power for unit force at the stages of a Runge-Kutta rule, by the rule itself.
//!
//! For a pole lambda, z = lambda dt, the rule steps a' = lambda a + F from the forces F_i of a step's stages as
//!
//! ```text
//! a_l = R(z) a_(l-1) + dt sum_i q_i F_(l,i),   q = b^T G,   G = (1 - z A)^-1,   R = r_s,   r = G 1,
//! ```
//!
//! so with zeta = exp(-i w dt), the forces of each stage transformed as sequences over the steps, and the constant D of
//! H_n(s) = D + sum_r R_r/(s - lambda_r) following the last stage,
//!
//! 1. the displacement at the ends of the steps is U = sum_i F_i (D delta_is + sum_r R_r dt q_i/(1 - R zeta));
//! 2. the velocity is i w U: the rate of the displacement, interpolated between the ends of the steps without
//!    frequencies above half the sampling rate;
//! 3. the rates of the stages are V_i = sum_j Y_ij F_j, Y = (D/dt) A^-1 (1 - zeta 1 e_s^T) + sum_r R_r (G + z zeta r
//!    q^T/(1 - R zeta)), and the power that the forces put in is the rule's quadrature, Re sum_i b_i conj F_i V_i,
//!    in the frequency domain exactly as in the time domain ([`super::contact_power`]).
//!
//! Why i w U and not V: the stages' rates are accurate to first order, and their mean is the difference over a step,
//! lower by the sine of w dt/2 over w dt/2: 0.4 dB at w dt = 1.
//!
//! Cost of a pole and bin: two complex reciprocals, and four multiply-adds for each stage, or for each entry of Y.

use num_complex::Complex64;
use pulp::Arch;

use crate::time_rule::RungeKutta;
use crate::tyre::poles::WaveModes;

/// Bins that are evaluated together, for vector instructions.
const LANE: usize = 64;
/// Most numerators over one pole's denominator: entries of Y for three stages.
const MOST: usize = 9;

/// Transfers of a rule at the bins of the material frame.
pub(super) struct StageTransfer {
    method: RungeKutta,
    time_step: f64,
    /// i w.
    symbols: Vec<Complex64>,
    /// exp(-i w dt).
    zetas: Vec<Complex64>,
}

/// A pole under the rule.
struct Pole {
    /// R(z).
    growth: Complex64,
    /// 1 for a pair, 0 for a real pole.
    conjugate: f64,
    numerators: [Complex64; MOST],
}

/// H_n as it is needed here: the modes, a factor of them, and a compliance that is added \[m/N\].
pub(super) struct ScaledModes<'a> {
    pub(super) modes: WaveModes<'a>,
    pub(super) scale: f64,
    pub(super) added_compliance: f64,
    /// Constant of the odd part, which the modes do not hold \[m/N\].
    pub(super) odd_constant: f64,
}

impl<'a> ScaledModes<'a> {
    /// True for a tyre that turns.
    pub(super) fn turns(&self) -> bool {
        !self.modes.odd.is_empty()
    }

    /// The odd part; `None` at rest.
    pub(super) fn odd(&self) -> Option<ScaledModes<'a>> {
        let modes = self.modes;
        let odd = WaveModes { residues: modes.odd, odd: &[], constant: self.odd_constant, ..modes };
        self.turns().then_some(ScaledModes { modes: odd, added_compliance: 0.0, odd_constant: 0.0, ..*self })
    }

    /// D \[m/N\].
    fn constant(&self) -> f64 {
        self.scale * self.modes.constant + self.added_compliance
    }
}

impl StageTransfer {
    /// At i w of each bin, for a time step \[s\].
    pub(super) fn new(method: RungeKutta, symbols: Vec<Complex64>, time_step: f64) -> Self {
        let zetas = symbols.iter().map(|symbol| (-symbol * time_step).exp()).collect();
        Self { method, time_step, symbols, zetas }
    }

    fn stages(&self) -> usize {
        self.method.nodes.len()
    }

    /// i w U for unit force at each stage \[m/(N s)\]: stages x bins.
    pub(super) fn velocities(&self, tyre: &ScaledModes<'_>, out: &mut [Complex64]) {
        let (stages, bins) = (self.stages(), self.symbols.len());
        let poles = self.poles(tyre, |residue, _, _, ends| {
            let mut numerators = [Complex64::ZERO; MOST];
            for (numerator, end) in numerators.iter_mut().zip(&ends[..stages]) {
                *numerator = residue * self.time_step * end;
            }
            numerators
        });
        self.fractions(&poles, stages, out);
        let last = &mut out[(stages - 1) * bins..];
        last.iter_mut().for_each(|value| *value += tyre.constant());
        for row in out.chunks_exact_mut(bins) {
            row.iter_mut().zip(&self.symbols).for_each(|(value, symbol)| *value *= symbol);
        }
    }

    /// b_i Y_ij \[m/(N s)\]: stages x stages x bins.
    pub(super) fn powers(&self, tyre: &ScaledModes<'_>, out: &mut [Complex64]) {
        let (stages, bins) = (self.stages(), self.symbols.len());
        let (weights, bases) = (self.method.weights(), self.method.bases());
        let mut at_once = [0.0; MOST];
        // 1. The poles: the term with zeta over the denominator, and G itself, which does not depend on zeta.
        let poles = self.poles(tyre, |residue, z, inverse, ends| {
            let mut numerators = [Complex64::ZERO; MOST];
            for (slot, numerator) in numerators[..stages * stages].iter_mut().enumerate() {
                let (i, j) = (slot / stages, slot % stages);
                let begin: Complex64 = inverse[i].iter().sum();
                *numerator = weights[i] * residue * z * begin * ends[j];
                // A pair with its conjugate gives twice the real part.
                let count = if z.im == 0.0 { 1.0 } else { 2.0 };
                at_once[slot] += count * weights[i] * (residue * inverse[i][j]).re;
            }
            numerators
        });
        self.fractions(&poles, stages * stages, out);
        // 2. The constant D, whose rates are those of its values.
        let rate = tyre.constant() / (self.method.gamma * self.time_step);
        for (slot, row) in out.chunks_exact_mut(bins).enumerate() {
            let (i, j) = (slot / stages, slot % stages);
            let diagonal = if i == j { 1.0 } else { 0.0 };
            let before = if j < i { bases[i][j + 1] } else { 0.0 };
            let begin = if j + 1 == stages { bases[i][0] } else { 0.0 };
            for (value, &zeta) in row.iter_mut().zip(&self.zetas) {
                let difference = diagonal - before - begin * zeta;
                *value = zeta * *value + at_once[slot] + weights[i] * rate * difference;
            }
        }
    }

    /// Poles, with their numerators from `numerators(R_r, z, G, q)`.
    fn poles(
        &self,
        tyre: &ScaledModes<'_>,
        mut numerators: impl FnMut(Complex64, Complex64, &[[Complex64; 3]; 3], &[Complex64; 3]) -> [Complex64; MOST],
    ) -> Vec<Pole> {
        let (stages, weights) = (self.stages(), self.method.weights());
        let of_pole = |(index, (&pole, &residue)): (usize, (&Complex64, &Complex64))| {
            let z = pole * self.time_step;
            let inverse = self.method.resolvent(z);
            let mut ends = [Complex64::ZERO; 3];
            for (row, weight) in inverse.iter().zip(weights) {
                ends.iter_mut().zip(row).for_each(|(end, entry)| *end += weight * entry);
            }
            Pole {
                growth: inverse[stages - 1].iter().sum(),
                conjugate: if index < tyre.modes.pairs { 1.0 } else { 0.0 },
                numerators: numerators(tyre.scale * residue, z, &inverse, &ends),
            }
        };
        tyre.modes.poles.iter().zip(tyre.modes.residues).enumerate().map(of_pole).collect()
    }

    /// Sums numerator/(1 - R zeta) over all poles and their conjugates: numerators x bins. Plain loops over many bins,
    /// which the compiler vectorises.
    fn fractions(&self, poles: &[Pole], count: usize, out: &mut [Complex64]) {
        let (arch, bins) = (Arch::new(), self.zetas.len());
        for (block, zetas) in self.zetas.chunks(LANE).enumerate() {
            let (mut zeta, mut sums) = ([[0.0; LANE]; 2], [[[0.0; LANE]; 2]; MOST]);
            for (lane, value) in zetas.iter().enumerate() {
                (zeta[0][lane], zeta[1][lane]) = (value.re, value.im);
            }
            arch.dispatch(
                #[inline(always)]
                || {
                    for pole in poles {
                        let (re, im) = (pole.growth.re, pole.growth.im);
                        // 1/(1 - R zeta) + 1/(1 - conj R zeta), and i times their difference.
                        let (mut both, mut turned) = ([[0.0; LANE]; 2], [[0.0; LANE]; 2]);
                        for lane in 0..LANE {
                            let (x, y) = (zeta[0][lane], zeta[1][lane]);
                            let (under_re, under_im) = (1.0 - (re * x - im * y), -(re * y + im * x));
                            let (other_re, other_im) = (1.0 - (re * x + im * y), -(re * y - im * x));
                            let scale = 1.0 / (under_re * under_re + under_im * under_im);
                            let other = pole.conjugate / (other_re * other_re + other_im * other_im);
                            both[0][lane] = under_re * scale + other_re * other;
                            both[1][lane] = -under_im * scale - other_im * other;
                            turned[0][lane] = under_im * scale - other_im * other;
                            turned[1][lane] = under_re * scale - other_re * other;
                        }
                        for (sum, numerator) in sums.iter_mut().zip(&pole.numerators[..count]) {
                            for part in 0..2 {
                                for lane in 0..LANE {
                                    sum[part][lane] +=
                                        numerator.re * both[part][lane] + numerator.im * turned[part][lane];
                                }
                            }
                        }
                    }
                },
            );
            for (row, sum) in out.chunks_exact_mut(bins).zip(&sums[..count]) {
                for (lane, value) in row[block * LANE..].iter_mut().take(zetas.len()).enumerate() {
                    *value = Complex64::new(sum[0][lane], sum[1][lane]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::TimeRule;

    /// Forces proportional to zeta^-l at one stage, stepped until the transient has decayed.
    #[test]
    fn transfers_are_what_the_rule_gives_step_by_step() {
        let poles = [Complex64::new(-900.0, 2500.0), Complex64::new(-700.0, 0.0)];
        let residues = [Complex64::new(0.3, -2.0), Complex64::new(1.5, 0.0)];
        let tyre = ScaledModes {
            modes: WaveModes { poles: &poles, residues: &residues, odd: &[], pairs: 1, constant: 2e-3 },
            scale: 0.8,
            added_compliance: 5e-4,
            odd_constant: 0.0,
        };
        let (dt, w) = (2e-4, 3100.0);
        let turn = Complex64::new(0.0, w * dt).exp();
        for rule in [TimeRule::Sdirk2, TimeRule::Sdirk3] {
            let method = rule.runge_kutta().unwrap();
            let (a, stages) = (method.matrix(), method.nodes.len());
            let transfer = StageTransfer::new(method, vec![Complex64::new(0.0, w)], dt);
            let (mut velocities, mut powers) = (vec![Complex64::ZERO; stages], vec![Complex64::ZERO; stages * stages]);
            transfer.velocities(&tyre, &mut velocities);
            transfer.powers(&tyre, &mut powers);
            for loaded in 0..stages {
                let all = [(poles[0], residues[0]), (poles[0].conj(), residues[0].conj()), (poles[1], residues[1])];
                let mut states = [Complex64::ZERO; 3];
                let (mut displacement, mut rates) = (Complex64::ZERO, vec![Complex64::ZERO; stages]);
                let steps = 400;
                for l in 0..=steps {
                    let force = turn.powi(l - steps);
                    displacement = Complex64::ZERO;
                    rates.fill(Complex64::ZERO);
                    for (state, (pole, residue)) in states.iter_mut().zip(all) {
                        let mut derivatives = vec![Complex64::ZERO; stages];
                        for i in 0..stages {
                            let input = if i == loaded { force } else { Complex64::ZERO };
                            let before: Complex64 = (0..i).map(|k| dt * a[i][k] * derivatives[k]).sum();
                            derivatives[i] = (pole * (*state + before) + input) / (1.0 - a[i][i] * dt * pole);
                            rates[i] += tyre.scale * residue * derivatives[i];
                        }
                        let change: Complex64 = (0..stages).map(|k| dt * a[stages - 1][k] * derivatives[k]).sum();
                        *state += change;
                        displacement += tyre.scale * residue * *state;
                    }
                }
                // The part that follows the force at once has the rates that A gives for its values, the last of which
                // began the step.
                let at = |stage: usize| if stage == loaded { tyre.constant() } else { 0.0 };
                displacement += at(stages - 1);
                let begin = at(stages - 1) / turn;
                let mut instant = vec![Complex64::ZERO; stages];
                for i in 0..stages {
                    let before: Complex64 = (0..i).map(|k| dt * a[i][k] * instant[k]).sum();
                    instant[i] = (at(i) - begin - before) / (a[i][i] * dt);
                }
                let expected = Complex64::new(0.0, w) * displacement;
                assert!((velocities[loaded] - expected).norm() < 1e-11 * expected.norm(), "{rule:?}, {loaded}");
                for i in 0..stages {
                    let expected = method.weights()[i] * (rates[i] + instant[i]);
                    let found = powers[i * stages + loaded];
                    assert!((found - expected).norm() < 1e-11 * expected.norm(), "{rule:?}: {found} {expected}");
                }
            }
        }
    }
}

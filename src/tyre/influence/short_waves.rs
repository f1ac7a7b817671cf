//! Effect of curvature on the short waves of a curved tyre, which the sums take as those of a flat layer.
//!
//! A wave so short that it does not feel the tread's thickness is evaluated on the flat layers, or not at all, as part
//! of the half-space's tail. Curvature still changes its C_zz, by 1/(k R) to first order: 6e-5 of it at low
//! frequencies, 1e-3 at 3 kHz, 3e-2 at the Rayleigh wave of the tread. The change is smooth in k and in the wave's
//! direction, so it is found for a few waves at each s, and the sum over all others takes moments:
//!
//! 1. the wavenumbers from the shortest prepared wave on are divided into bands, k in steps of 2^(1/4); each has
//!    [`NODES`] Chebyshev points in k^2 and, at each, waves along, across and half-way between;
//! 2. at s each of them has its C_zz as a curved layer's ([`Cylinder::short_wave`]) and as a flat one's; the difference
//!    is a Chebyshev sum in k^2, and in c^2 = k_x^2/k^2 a polynomial a + b c^2 + d c^4: exact to second order in
//!    1/(k R), since each order brings a factor c^2 at most;
//! 3. the sum over waves is that of the coefficients times sum weight c^(2 i) T_j(k^2), which does not depend on s.
//!
//! Beyond the last band the difference falls like k^-2.
//!
//! With rotation, the curved layers turn, and the flat ones do not: the change has an odd part too, k_x/k times a
//! polynomial a + b c^2, which falls like k^-3 beyond the last band, and its even part has the tread's hoop stress,
//! which falls like k^-1 and is separated from the curvature by a second wavenumber.
//!
//! Error, as a fraction of the wave's C_zz (default tyre, k > 860/m): 1e-7 up to 4.5 kHz, 5e-7 at 6 kHz, at most 2e-5,
//! where a band holds the Rayleigh wave. In a tread of little damping a few points do not resolve that wave; its bands
//! stay flat. Only the surface's answer to normal traction is changed: deeper faces hardly feel short waves.
//!
//! Cost: preparing some 300 waves and evaluating them for each s takes 1.2 s at N = 1024 on two threads, of the 4.2 s
//! that the sums take where no cache has them.

use std::f64::consts::PI;
use std::sync::OnceLock;

use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use super::half_space_bands::is_resolved;
use super::moments::{TailClasses, Weighted};
use super::parts::Parts;
use crate::numeric::lanes::dispatch;
use crate::numeric::{Lanes, MOST_LANES, in_parallel};
use crate::scene::Tyre;
use crate::tyre::layers::compliance::Stack;
use crate::tyre::layers::curved::CurvedStack;
use crate::tyre::layers::cylinder::{Cylinder, CylinderAt, CylinderWave};
use crate::tyre::layers::lane_compliance::LaneStack;

/// Chebyshev points of a band.
const NODES: usize = 10;
/// Number of waves prepared where bands reach seven times the shortest wave, as they do up to 20 kHz.
pub(super) const EXPECTED_WAVES: f64 = (11 * NODES * DIRECTIONS.len()) as f64;
/// Values of c^2, and powers of it.
const DIRECTIONS: [f64; 3] = [0.0, 0.5, 1.0];
/// k times the depth of the tread that is retained under a wave.
const DEEP: f64 = 30.0;
/// Least ratio of the last band's wavenumber to that of the shortest wave prepared.
const LEAST_REACH: f64 = 4.0;
/// Error that a Chebyshev sum of twenty terms has to reach in a band: ten terms then leave a tenth of the change.
const RESOLVED: f64 = 5e-3;
/// Frequencies per decade at which that is tested.
const FREQUENCIES: f64 = 12.0;

/// Waves of one tyre at which the change is found.
#[derive(Debug)]
pub(super) struct ShortWaves {
    tyre: Tyre,
    tolerance: f64,
    classes: TailClasses,
    /// The last one has one or two wavenumbers, and holds all beyond.
    bands: Vec<Band>,
}

#[derive(Debug)]
struct Band {
    /// Limits of k^2 \[1/m^2\].
    limits: [f64; 2],
    /// k^2 of the points \[1/m^2\].
    squares: Vec<f64>,
    cylinder: Cylinder,
    flat: Stack,
    /// By point, then direction.
    waves: Vec<OnceLock<Box<CylinderWave>>>,
}

/// Coefficients of the change at one s, or moments of the weights: by band and term of k^2, then by power of c^2.
pub(super) type Terms<T> = Vec<[T; DIRECTIONS.len()]>;

/// Even part of the change, and its odd part where the tyre turns; or moments of the weights for both.
#[derive(Clone, Debug)]
pub(super) struct SumChange<T> {
    pub(super) even: Terms<T>,
    pub(super) odd: Terms<T>,
}

impl ShortWaves {
    /// For waves from `from` \[1/m\] on and |s| up to `largest_s` \[1/s\], whose Rayleigh wave lies below
    /// `series_limit` \[1/m\]; prepared waves are within a relative `tolerance`.
    pub(super) fn new(tyre: &Tyre, from: f64, series_limit: f64, largest_s: f64, tolerance: f64) -> Self {
        let classes = TailClasses::new(from, series_limit.max(LEAST_REACH * from));
        let full = Stack::new(tyre);
        let decades = (largest_s / (2.0 * PI)).max(1.0).log10();
        let frequencies: Vec<f64> =
            (0..=(FREQUENCIES * decades) as i32).map(|i| 2.0 * PI * 10f64.powf(f64::from(i) / FREQUENCIES)).collect();
        let resolved = |limits: [f64; 2]| {
            let there = |w: &f64| is_resolved(full.at(Complex64::new(0.0, *w)).tread(), limits, RESOLVED);
            frequencies.iter().all(there)
        };
        // Bands that hold a sharp resonance at any frequency are left out: waves there stay flat.
        let inner = (0..classes.last()).map(|class| classes.band(class)).filter(|&limits| resolved(limits));
        let top = classes.highest().powi(2);
        let bands = inner.chain([[top, f64::INFINITY]]);
        let stack = CurvedStack::new(tyre).resolved().without_sidewalls();
        let bands = bands.map(|limits| Band::new(tyre, &stack, limits, largest_s, tolerance)).collect();
        Self { tyre: tyre.clone(), tolerance, classes, bands }
    }

    /// The same for s = 0 alone.
    fn at_rest(&self) -> Self {
        let stack = CurvedStack::new(&self.tyre).resolved().without_sidewalls();
        let resting = |band: &Band| Band::new(&self.tyre, &stack, band.limits, 0.0, self.tolerance);
        let bands = self.bands.iter().map(resting).collect();
        Self { tyre: self.tyre.clone(), classes: self.classes.clone(), bands, ..*self }
    }

    /// Wavenumber above which the last band stands for all waves \[1/m\].
    pub(super) fn highest(&self) -> f64 {
        self.classes.highest()
    }

    /// Moments of weights by signed k_x (`longitudinal`) and by k_y^2 (`lateral`).
    pub(super) fn moments(&self, longitudinal: &[(f64, f64)], lateral: &[Weighted]) -> SumChange<f64> {
        let even = self.moments_of(longitudinal, lateral, |_| 1.0, Band::beyond);
        let odd = if self.tyre.turns() {
            let beyond =
                |band: &Band, weight: f64, k_squared: f64| [weight * (band.limits[0] / k_squared).powf(1.5), 0.0];
            self.moments_of(longitudinal, lateral, |cosine| cosine, beyond)
        } else {
            Vec::new()
        };
        SumChange { even, odd }
    }

    /// Moments with the weights times a `factor` of k_x/k; `beyond` distributes those at a k^2 beyond the bands to the
    /// wavenumbers of the last one.
    fn moments_of(
        &self,
        longitudinal: &[(f64, f64)],
        lateral: &[Weighted],
        factor: impl Fn(f64) -> f64,
        beyond: impl Fn(&Band, f64, f64) -> [f64; 2],
    ) -> Terms<f64> {
        let terms: usize = self.bands.iter().map(|band| band.squares.len()).sum();
        let mut moments = vec![[0.0; DIRECTIONS.len()]; terms];
        let (inner, last) = moments.split_at_mut(NODES * (self.bands.len() - 1));
        let first = self.bands[0].limits[0];
        let outer = &self.bands[self.bands.len() - 1];
        let highest = outer.limits[0];
        for &(ky_squared, across) in lateral {
            for &(kx, along) in longitudinal {
                let (k_squared, weight) = (kx * kx + ky_squared, along * across);
                let direction = kx * kx / k_squared;
                let weight = weight * factor(kx / k_squared.sqrt());
                if k_squared >= highest {
                    for (moments, weight) in last.iter_mut().zip(beyond(outer, weight, k_squared)) {
                        add(moments, weight, direction);
                    }
                } else if k_squared >= first {
                    let band = self.bands.partition_point(|band| band.limits[0] <= k_squared) - 1;
                    let [low, high] = self.bands[band].limits;
                    if k_squared < high {
                        let x = (2.0 * k_squared - low - high) / (high - low);
                        let (mut current, mut next) = (weight, weight * x);
                        for moments in &mut inner[band * NODES..(band + 1) * NODES] {
                            add(moments, current, direction);
                            (current, next) = (next, 2.0 * x * next - current);
                        }
                    }
                }
            }
        }
        moments
    }

    /// The change at s \[1/s\].
    pub(super) fn at(&self, s: Complex64) -> SumChange<Complex64> {
        let mut changes = Vec::with_capacity(1);
        dispatch(Changes { bands: &self.bands, turns: self.tyre.turns(), points: &[s], changes: &mut changes });
        changes.pop().unwrap_or_else(|| SumChange { even: Vec::new(), odd: Vec::new() })
    }

    /// The change at s = 0, from waves prepared for it alone.
    pub(super) fn resting(&self) -> SumChange<Complex64> {
        self.at_rest().at(Complex64::ZERO)
    }

    /// The change at each s of a list, on all threads.
    pub(super) fn at_all(&self, points: &[Complex64]) -> Vec<SumChange<Complex64>> {
        // All waves first: groups of s would wait for each other's.
        let waves: Vec<(&Band, usize)> =
            self.bands.iter().flat_map(|band| (0..band.waves.len()).map(move |place| (band, place))).collect();
        in_parallel::each(waves.len(), &|index| {
            let (band, place) = waves[index];
            band.wave(place);
        });
        let group = |points: &&[Complex64]| {
            let mut changes = Vec::with_capacity(points.len());
            dispatch(Changes { bands: &self.bands, turns: self.tyre.turns(), points, changes: &mut changes });
            changes
        };
        let groups: Vec<&[Complex64]> = points.chunks(MOST_LANES).collect();
        in_parallel::map(&groups, group).into_iter().flatten().collect()
    }
}

/// Change of a sum over waves.
pub(super) fn sum(coefficients: &Terms<Complex64>, moments: &Terms<f64>) -> Complex64 {
    let terms = coefficients.as_flattened().iter().zip(moments.as_flattened());
    terms.map(|(&coefficient, &moment)| coefficient * moment).sum()
}

/// Adds weight c^(2 i), `direction` being c^2.
fn add(moments: &mut [f64; DIRECTIONS.len()], mut weight: f64, direction: f64) {
    for moment in moments {
        *moment += weight;
        weight *= direction;
    }
}

/// Angle of a Chebyshev point.
fn angle(node: usize) -> f64 {
    PI * (node as f64 + 0.5) / NODES as f64
}

impl Band {
    /// A band on the tread alone where that is deep, and on no more of it than a wave feels: fewer unknowns.
    fn new(tyre: &Tyre, stack: &CurvedStack, limits: [f64; 2], largest_s: f64, tolerance: f64) -> Self {
        let [low, high] = limits;
        let squares: Vec<f64> = if high.is_finite() {
            (0..NODES).map(|i| 0.5 * (low + high) + 0.5 * (high - low) * angle(i).cos()).collect()
        } else if tyre.turns() {
            vec![low, 4.0 * low]
        } else {
            vec![low]
        };
        let (mut tyre, mut stack) = (tyre.clone(), stack.clone());
        let retained = DEEP / low.sqrt();
        for layers in [&mut tyre.layers, &mut stack.layers] {
            if let Some(mut tread) = layers.pop_if(|tread| retained < tread.thickness) {
                tread.tension = tread.tension.map(|tension| tension * (retained / tread.thickness));
                tread.thickness = retained;
                layers.clear();
                layers.push(tread);
                (stack.pressure, stack.sidewall_mass, stack.cavity) = (0.0, 0.0, None);
            }
        }
        Self {
            limits,
            waves: (0..squares.len() * DIRECTIONS.len()).map(|_| OnceLock::new()).collect(),
            squares,
            cylinder: Cylinder::of(stack, largest_s, tolerance),
            flat: Stack::new(&tyre),
        }
    }

    /// Distributes a weight at a k^2 beyond to the first wavenumber k_0 and 2 k_0: exact for what falls like k^-2, and
    /// with a second wavenumber also for k^-1.
    fn beyond(&self, weight: f64, k_squared: f64) -> [f64; 2] {
        let first = self.limits[0];
        if self.squares.len() < 2 {
            return [weight * first / k_squared, 0.0];
        }
        let u = (first / k_squared).sqrt();
        [weight * (2.0 * u * u - u), weight * 4.0 * (u - u * u)]
    }

    /// k_x and k_y of a wave \[1/m\].
    fn wavenumbers(&self, place: usize) -> [f64; 2] {
        let direction = DIRECTIONS[place % DIRECTIONS.len()];
        let k_squared = self.squares[place / DIRECTIONS.len()];
        [(k_squared * direction).sqrt(), (k_squared * (1.0 - direction)).sqrt()]
    }

    fn wave(&self, place: usize) -> &CylinderWave {
        let [kx, ky] = self.wavenumbers(place);
        self.waves[place].get_or_init(|| Box::new(self.cylinder.short_wave(kx, ky)))
    }

    /// Appends the coefficients of values at the points: by `powers` in c^2, by Chebyshev terms in k^2; in the last
    /// band the values at its wavenumbers.
    fn coefficients(&self, values: &[Values], powers: fn(&Values) -> Values, terms: &mut Terms<Complex64>) {
        let values: Vec<_> = values.iter().map(powers).collect();
        let count = values.len();
        if self.limits[1].is_infinite() {
            terms.extend(values);
            return;
        }
        terms.extend((0..count).map(|j| {
            let scale = if j == 0 { 1.0 } else { 2.0 } / count as f64;
            let mut term = [Complex64::ZERO; DIRECTIONS.len()];
            for (node, values) in values.iter().enumerate() {
                let weight = scale * (j as f64 * angle(node)).cos();
                for (term, value) in term.iter_mut().zip(values) {
                    *term += value * weight;
                }
            }
            term
        }));
    }
}

/// Values at c^2 = 0, 1/2, 1, or coefficients.
type Values = [Complex64; DIRECTIONS.len()];

/// Even values to coefficients of powers of c^2.
fn even_powers(&[across, between, along]: &Values) -> Values {
    let bend = (across + along) * 2.0 - between * 4.0;
    [across, along - across - bend, bend]
}

/// Odd values, which are 0 at c = 0, to coefficients of c times powers of c^2.
fn odd_powers(&[_, between, along]: &Values) -> Values {
    let bend = (along - between * std::f64::consts::SQRT_2) * 2.0;
    [along - bend, bend, Complex64::ZERO]
}

/// The change at several s in lockstep, appended in their order. A type, not a closure: it has to be inlined into the
/// dispatch to be compiled for its instructions.
struct Changes<'a> {
    bands: &'a [Band],
    turns: bool,
    points: &'a [Complex64],
    changes: &'a mut Vec<SumChange<Complex64>>,
}

impl WithSimd for Changes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let terms = self.bands.iter().map(|band| band.squares.len()).sum();
        for group in self.points.chunks(S::F64_LANES) {
            let mut changes: [SumChange<Complex64>; MOST_LANES] = std::array::from_fn(|_| SumChange {
                even: Vec::with_capacity(terms),
                odd: Vec::with_capacity(if self.turns { terms } else { 0 }),
            });
            // Lanes without a member repeat the last one.
            let points: [Complex64; MOST_LANES] = std::array::from_fn(|lane| group[lane.min(group.len() - 1)]);
            // 1. Curved less flat layers, wave by wave.
            for band in self.bands {
                let cylinder = points.map(|s| band.cylinder.at(s));
                let flat = points.map(|s| band.flat.at(s));
                let cylinder = CylinderAt::lanes(simd, cylinder.each_ref());
                let flat = LaneStack::new(simd, flat.each_ref());
                let (mut even, mut odd) = ([const { Vec::new() }; MOST_LANES], [const { Vec::new() }; MOST_LANES]);
                for node in 0..band.squares.len() {
                    let mut change = [[[Complex64::ZERO; DIRECTIONS.len()]; MOST_LANES]; 2];
                    for direction in 0..DIRECTIONS.len() {
                        let place = node * DIRECTIONS.len() + direction;
                        let [kx, ky] = band.wavenumbers(place);
                        let wave = band.wave(place);
                        let mut put = |part: usize, value: Lanes<S>| {
                            for (change, value) in change[part].iter_mut().zip(value.to_array()) {
                                change[direction] = value;
                            }
                        };
                        let curved: Lanes<S> = if self.turns {
                            let both = wave.normal_both_ways(&cylinder).map(|normal| normal.surface);
                            let Parts { even, odd } = Parts::of(both);
                            put(1, odd);
                            even
                        } else {
                            wave.normal_at_rest(&cylinder).surface
                        };
                        put(0, curved - flat.normal(kx, ky).surface);
                    }
                    let [even_change, odd_change] = change;
                    for (values, change) in even.iter_mut().zip(even_change) {
                        values.push(change);
                    }
                    for (values, change) in odd.iter_mut().zip(odd_change).filter(|_| self.turns) {
                        values.push(change);
                    }
                }
                // 2. Coefficients of each band.
                for ((even, odd), changes) in even.iter().zip(&odd).zip(&mut changes) {
                    band.coefficients(even, even_powers, &mut changes.even);
                    band.coefficients(odd, odd_powers, &mut changes.odd);
                }
            }
            self.changes.extend(changes.into_iter().take(group.len()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DEFAULT, Scene};
    use crate::tyre::layers::surface_asymptote::thickness_limit;

    /// Largest errors of the even and of the odd part, relative to C, between the waves that are prepared.
    fn errors(speed: f64, frequency: f64) -> [f64; 2] {
        let mut tyre = Scene::from_str(DEFAULT, "default").unwrap().scene.tyre;
        tyre.angular_velocity = -speed / tyre.radius();
        let largest = 1.3e5;
        let from = thickness_limit(tyre.layers[2].thickness, 1e-7);
        let waves = ShortWaves::new(&tyre, from, 4.0 * from, largest, 1e-7);
        let s = Complex64::new(0.0, 2.0 * PI * frequency);
        let change = waves.at(s);
        let cylinder = Cylinder::of(CurvedStack::new(&tyre), largest, 1e-7);
        let flat = Stack::new(&tyre).at(s);
        let mut errors = [0.0_f64; 2];
        for k in [1.003, 1.3, 2.2, 3.9, 5.0, 7.0].map(|ratio| ratio * from) {
            for angle in [0.0_f64, 0.4, 0.9, 1.2, 1.5] {
                let (kx, ky) = (k * angle.cos(), k * angle.sin());
                let both = cylinder.short_wave(kx, ky).normal_both_ways(&cylinder.at(s)).map(|normal| normal.surface);
                let exact = Parts::of(both);
                let flat = flat.normal(kx, ky).surface;
                let one = |kx: f64| {
                    let moments = waves.moments(&[(kx, 1.0)], &[(ky * ky, 1.0)]);
                    [sum(&change.even, &moments.even), sum(&change.odd, &moments.odd)]
                };
                let ([even, odd], [_, back]) = (one(kx), one(-kx));
                assert!((odd + back).norm() <= 1e-12 * odd.norm());
                let off = [(flat + even - exact.even).norm(), (odd - exact.odd).norm()].map(|off| off / flat.norm());
                println!(
                    "{speed} m/s, {frequency} Hz, k {k:.0}, {angle}: change {:.1e}, odd {:.1e}, errors {off:?}",
                    (exact.even - flat).norm() / flat.norm(),
                    exact.odd.norm() / flat.norm()
                );
                for (error, off) in errors.iter_mut().zip(off) {
                    *error = error.max(off);
                }
            }
        }
        errors
    }

    #[test]
    fn the_change_of_a_tyre_that_turns_is_found_between_its_points() {
        for (frequency, allowed) in [(1e3, 5e-6), (3e3, 1e-5), (1e4, 1e-4)] {
            let [even, odd] = errors(69.4, frequency);
            assert!(even < allowed && odd < allowed, "{frequency} Hz: {even:.1e}, {odd:.1e}");
        }
    }
}

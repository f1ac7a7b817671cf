//! Effect of curvature on the short waves of a curved tyre, which the sums take as a flat layer's.
//!
//! A wave so short that it does not feel the tread's thickness is evaluated on the flat layers, or not at all, as part
//! of the half-space's tail. Curvature still changes its C_zz, by 1/(k R) to first order: 6e-5 of it at low
//! frequencies, 1e-3 at 3 kHz, 3e-2 where Rayleigh's wave of the tread is met. The change is smooth in k and in the
//! wave's direction, so it is found at a few waves for each s, and the sum over all others takes moments:
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
//! Error, as a share of the wave's C_zz (default tyre, k > 860/m): 1e-7 up to 4.5 kHz, 5e-7 at 6 kHz, at most 2e-5,
//! where a band holds Rayleigh's wave. In a tread of little damping few points do not tell that resonance; its bands
//! stay flat. Only the surface's answer to normal traction is changed: deeper faces hardly feel short waves.
//!
//! Cost: some 300 waves to prepare, and their values for each s: 1.2 s of the 4.2 s that cold sums take at N = 1024 on
//! two threads.

use std::f64::consts::PI;
use std::sync::OnceLock;

use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use super::half_space_bands::is_resolved;
use super::moments::{TailClasses, Weighted};
use crate::numeric::lanes::dispatch;
use crate::numeric::{Lanes, MOST_LANES, in_parallel};
use crate::scene::Tyre;
use crate::tyre::layers::compliance::Stack;
use crate::tyre::layers::cylinder::{Cylinder, CylinderAt, CylinderWave};
use crate::tyre::layers::lane_compliance::LaneStack;

/// Chebyshev points of a band.
const NODES: usize = 10;
/// Waves that are prepared where bands reach seven times the shortest wave, as they do up to 20 kHz.
pub(super) const EXPECTED_WAVES: f64 = (11 * NODES * DIRECTIONS.len()) as f64;
/// Values of c^2, and powers of it.
const DIRECTIONS: [f64; 3] = [0.0, 0.5, 1.0];
/// Thickness of the tread, times k, that is kept under a wave.
const DEEP: f64 = 30.0;
/// Least reach of the bands over the shortest wave that is prepared.
const LEAST_REACH: f64 = 4.0;
/// Error that a Chebyshev sum of twenty terms has to reach in a band: ten then leave a tenth of the change.
const RESOLVED: f64 = 5e-3;
/// Frequencies at which that is looked at, for each factor of ten.
const FREQUENCIES: f64 = 12.0;

/// Waves at which the change is found, of one tyre.
#[derive(Debug)]
pub(super) struct ShortWaves {
    tyre: Tyre,
    tolerance: f64,
    classes: TailClasses,
    /// By band; the last one has a single wavenumber, and holds all beyond.
    bands: Vec<Band>,
}

#[derive(Debug)]
struct Band {
    /// k^2 \[1/m^2\].
    limits: [f64; 2],
    /// k^2 of its points.
    squares: Vec<f64>,
    cylinder: Cylinder,
    flat: Stack,
    /// By point, then direction.
    waves: Vec<OnceLock<Box<CylinderWave>>>,
}

/// Coefficients of the change at one s, or moments of the weights: by band, term of k^2 and power of c^2.
pub(super) type Terms<T> = Vec<[T; DIRECTIONS.len()]>;

impl ShortWaves {
    /// For waves from `from` \[1/m\] on and |s| up to `largest_s`, beyond whose Rayleigh wave lies `series_limit`
    /// \[1/m\]; prepared waves within a relative `tolerance`.
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
        let inner = (0..classes.last()).map(|class| classes.band(class)).filter(|&limits| resolved(limits));
        let top = classes.highest().powi(2);
        let bands = inner.chain([[top, f64::INFINITY]]);
        let bands = bands.map(|limits| Band::new(tyre, limits, largest_s, tolerance)).collect();
        Self { tyre: tyre.clone(), tolerance, classes, bands }
    }

    /// The same for s = 0 alone.
    fn at_rest(&self) -> Self {
        let bands = self.bands.iter().map(|band| Band::new(&self.tyre, band.limits, 0.0, self.tolerance)).collect();
        Self { tyre: self.tyre.clone(), classes: self.classes.clone(), bands, ..*self }
    }

    /// Wavenumber from which on the last band's change stands for all \[1/m\].
    pub(super) fn highest(&self) -> f64 {
        self.classes.highest()
    }

    /// Moments of waves with weights by k_x^2 and by k_y^2.
    pub(super) fn moments(&self, longitudinal: &[Weighted], lateral: &[Weighted]) -> Terms<f64> {
        let terms: usize = self.bands.iter().map(|band| band.squares.len()).sum();
        let mut moments = vec![[0.0; DIRECTIONS.len()]; terms];
        let (inner, beyond) = moments.split_at_mut(terms - 1);
        let first = self.bands[0].limits[0];
        let highest = self.bands[self.bands.len() - 1].limits[0];
        for &(ky_squared, across) in lateral {
            for &(kx_squared, along) in longitudinal {
                let (k_squared, weight) = (kx_squared + ky_squared, along * across);
                let direction = kx_squared / k_squared;
                if k_squared >= highest {
                    add(&mut beyond[0], weight * highest / k_squared, direction);
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

    /// The change at s.
    pub(super) fn at(&self, s: Complex64) -> Terms<Complex64> {
        let mut changes = Vec::with_capacity(1);
        dispatch(Changes { bands: &self.bands, points: &[s], changes: &mut changes });
        changes.pop().unwrap_or_default()
    }

    /// The change at s = 0.
    pub(super) fn resting(&self) -> Terms<Complex64> {
        self.at_rest().at(Complex64::ZERO)
    }

    /// The change at each s of a list, on all threads.
    pub(super) fn at_all(&self, points: &[Complex64]) -> Vec<Terms<Complex64>> {
        let waves: Vec<(&Band, usize)> =
            self.bands.iter().flat_map(|band| (0..band.waves.len()).map(move |place| (band, place))).collect();
        in_parallel::each(waves.len(), &|index| {
            let (band, place) = waves[index];
            band.wave(place);
        });
        let group = |points: &&[Complex64]| {
            let mut changes = Vec::with_capacity(points.len());
            dispatch(Changes { bands: &self.bands, points, changes: &mut changes });
            changes
        };
        let groups: Vec<&[Complex64]> = points.chunks(MOST_LANES).collect();
        in_parallel::map(&groups, group).into_iter().flatten().collect()
    }
}

/// The change of a sum over waves.
pub(super) fn sum(coefficients: &Terms<Complex64>, moments: &Terms<f64>) -> Complex64 {
    let terms = coefficients.as_flattened().iter().zip(moments.as_flattened());
    terms.map(|(&coefficient, &moment)| coefficient * moment).sum()
}

/// Adds weight c^(2 i).
fn add(moments: &mut [f64; DIRECTIONS.len()], mut weight: f64, direction: f64) {
    for moment in moments {
        *moment += weight;
        weight *= direction;
    }
}

fn angle(node: usize) -> f64 {
    PI * (node as f64 + 0.5) / NODES as f64
}

impl Band {
    /// Only the tread where it is deep, and no more of it than a wave feels: fewer unknowns.
    fn new(tyre: &Tyre, limits: [f64; 2], largest_s: f64, tolerance: f64) -> Self {
        let [low, high] = limits;
        let squares: Vec<f64> = if high.is_finite() {
            (0..NODES).map(|i| 0.5 * (low + high) + 0.5 * (high - low) * angle(i).cos()).collect()
        } else {
            vec![low]
        };
        let mut tyre = tyre.clone();
        let kept = DEEP / low.sqrt();
        if let Some(mut tread) = tyre.layers.pop() {
            if kept < tread.thickness {
                tread.thickness = kept;
                tyre.layers.clear();
                (tyre.inflation, tyre.cavity) = (None, None);
            }
            tyre.layers.push(tread);
        }
        Self {
            limits,
            waves: (0..squares.len() * DIRECTIONS.len()).map(|_| OnceLock::new()).collect(),
            squares,
            cylinder: Cylinder::new(&tyre, largest_s, tolerance),
            flat: Stack::new(&tyre),
        }
    }

    /// k_x, k_y \[1/m\] of a wave.
    fn wavenumbers(&self, place: usize) -> [f64; 2] {
        let direction = DIRECTIONS[place % DIRECTIONS.len()];
        let k_squared = self.squares[place / DIRECTIONS.len()];
        [(k_squared * direction).sqrt(), (k_squared * (1.0 - direction)).sqrt()]
    }

    fn wave(&self, place: usize) -> &CylinderWave {
        let [kx, ky] = self.wavenumbers(place);
        self.waves[place].get_or_init(|| Box::new(self.cylinder.short_wave(kx, ky)))
    }

    /// Values by point and direction into coefficients.
    fn coefficients(&self, values: &[[Complex64; DIRECTIONS.len()]], terms: &mut Terms<Complex64>) {
        // c^2 = 0, 1/2, 1 into powers of c^2.
        let powers = |&[across, between, along]: &[Complex64; DIRECTIONS.len()]| {
            let bend = (across + along) * 2.0 - between * 4.0;
            [across, along - across - bend, bend]
        };
        let values: Vec<_> = values.iter().map(powers).collect();
        let count = values.len();
        terms.extend((0..count).map(|j| {
            let scale = if j == 0 { 1.0 } else { 2.0 } / count as f64;
            let mut term = [Complex64::ZERO; DIRECTIONS.len()];
            for (node, values) in values.iter().enumerate() {
                let weight = if count == 1 { 1.0 } else { scale * (j as f64 * angle(node)).cos() };
                for (term, value) in term.iter_mut().zip(values) {
                    *term += value * weight;
                }
            }
            term
        }));
    }
}

/// The change at several s in lockstep, appended in their order. A type, not a closure, since it has to be inlined into
/// the dispatch to be compiled for its instructions.
struct Changes<'a> {
    bands: &'a [Band],
    points: &'a [Complex64],
    changes: &'a mut Vec<Terms<Complex64>>,
}

impl WithSimd for Changes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let terms = self.bands.iter().map(|band| band.squares.len()).sum();
        for group in self.points.chunks(S::F64_LANES) {
            let mut changes: [Terms<Complex64>; MOST_LANES] = std::array::from_fn(|_| Vec::with_capacity(terms));
            // Lanes without a member repeat the last one.
            let points: [Complex64; MOST_LANES] = std::array::from_fn(|lane| group[lane.min(group.len() - 1)]);
            for band in self.bands {
                let cylinder = points.map(|s| band.cylinder.at(s));
                let flat = points.map(|s| band.flat.at(s));
                let cylinder = CylinderAt::lanes(simd, cylinder.each_ref());
                let flat = LaneStack::new(simd, flat.each_ref());
                let mut values = [const { Vec::new() }; MOST_LANES];
                for node in 0..band.squares.len() {
                    let mut change = [[Complex64::ZERO; DIRECTIONS.len()]; MOST_LANES];
                    for direction in 0..DIRECTIONS.len() {
                        let place = node * DIRECTIONS.len() + direction;
                        let [kx, ky] = band.wavenumbers(place);
                        let curved: Lanes<S> = band.wave(place).normal(&cylinder).surface;
                        let difference = (curved - flat.normal(kx, ky).surface).to_array();
                        for (change, difference) in change.iter_mut().zip(difference) {
                            change[direction] = difference;
                        }
                    }
                    for (values, change) in values.iter_mut().zip(change) {
                        values.push(change);
                    }
                }
                for (values, changes) in values.iter().zip(&mut changes) {
                    band.coefficients(values, changes);
                }
            }
            self.changes.extend(changes.into_iter().take(group.len()));
        }
    }
}

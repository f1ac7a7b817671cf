//! The meridian of a sidewall in steady state: its shape and tension under pressure and rotation.
//!
//! z runs along the arc from bead to belt, a is its angle, R its radius, y its distance from the chord, N its tension:
//!
//! ```text
//! R' = cos a,  y' = -sin a,  a' = ka = (p + m Om^2 R sin a)/N,  (R N)' = -m Om^2 R^2 cos a,
//! R(0) = R_b - 2 r sin phi,  R(L) = R_b,  y(0) = y(L) = 0:
//! ```
//!
//! the ends and the length are those of a circular arc of the radius r and the angle 2 phi. N(0) and a(0) are found by
//! Newton's method, from p r and -phi; where that fails, by continuation from larger edges and slower rotations. The
//! cords do not stretch.

use std::f64::consts::PI;

use super::arc::Arc;

/// Least number of steps of the fourth-order Runge-Kutta method along the whole arc: errors of some 1e-10.
const STEPS: usize = 256;
/// Most steps of Newton's method.
const ITERATIONS: usize = 30;
/// Distance of the arc's end from the edge that counts as none, over the length.
const TOLERANCE: f64 = 1e-13;
/// A distance at which the iteration counts as converged where rounding keeps it from falling further: this, or so
/// many units in the last place of the radius.
const ROUNDED: f64 = 1e-11;
const LAST_PLACES: f64 = 64.0;
/// Steps of the continuation.
const STAGES: usize = 16;

/// R, y, a, R N along the arc.
type State = [f64; 4];

/// State of the meridian at one z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MeridianPoint {
    /// Radius R \[m\].
    pub(super) radius: f64,
    /// sin a, cos a.
    pub(super) sine: f64,
    pub(super) cosine: f64,
    /// Curvature ka \[1/m\].
    pub(super) curvature: f64,
    /// Tension N \[N/m\].
    pub(super) tension: f64,
    /// p/N \[1/m\].
    pub(super) pressed: f64,
}

/// Tension and angle of the meridian at its ends, which act on bead and belt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeStatics {
    /// Angle a_0 of the arc at the bead \[rad\].
    pub bead_angle: f64,
    /// Tension at the bead \[N/m\].
    pub bead_tension: f64,
    /// Angle a_b at the belt \[rad\].
    pub angle: f64,
    /// Tension N_b at the belt \[N/m\].
    pub tension: f64,
}

impl EdgeStatics {
    /// Force per length by which the sidewall pulls the belt's edge inwards, N_b cos a_b \[N/m\].
    pub fn pull(&self) -> f64 {
        self.tension * self.angle.cos()
    }
}

/// The meridian of an arc in steady state.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Meridian {
    load: Load,
    length: f64,
    begin: State,
    edge: EdgeStatics,
}

/// Pressure \[Pa\] and m Om^2 \[N/m^3\].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Load {
    pressure: f64,
    spin: f64,
}

impl Load {
    fn derivative(&self, &[radius, _, angle, pulled]: &State) -> State {
        let (sine, cosine) = angle.sin_cos();
        [cosine, -sine, self.curvature(radius, sine, pulled / radius), -self.spin * radius * radius * cosine]
    }

    fn curvature(&self, radius: f64, sine: f64, tension: f64) -> f64 {
        (self.pressure + self.spin * radius * sine) / tension
    }

    /// State after a further length of the arc, by fourth-order Runge-Kutta steps.
    fn advanced(&self, mut state: State, length: f64, steps: usize) -> State {
        let h = length / steps as f64;
        let moved = |state: &State, by: f64, slope: &State| -> State {
            std::array::from_fn(|place| state[place] + by * slope[place])
        };
        for _ in 0..steps {
            let first = self.derivative(&state);
            let second = self.derivative(&moved(&state, 0.5 * h, &first));
            let third = self.derivative(&moved(&state, 0.5 * h, &second));
            let fourth = self.derivative(&moved(&state, h, &third));
            let slope = std::array::from_fn(|k| (first[k] + 2.0 * (second[k] + third[k]) + fourth[k]) / 6.0);
            state = moved(&state, h, &slope);
        }
        state
    }

    /// N(0) and a(0) of the arc that ends at the belt's edge; `None` where Newton's method does not find them.
    fn found(&self, arc: &Arc, start: [f64; 2]) -> Option<[f64; 2]> {
        let (bead, length) = (arc.bead_radius(), arc.length());
        let rounded = ROUNDED.max(LAST_PLACES * f64::EPSILON * arc.edge_radius / length);
        let miss = |[tension, angle]: [f64; 2]| {
            let [radius, across, ..] = self.advanced([bead, 0.0, angle, bead * tension], length, STEPS);
            [radius - arc.edge_radius, across]
        };
        let mut at = start;
        let mut missed = miss(at);
        for _ in 0..ITERATIONS {
            let size = missed[0].hypot(missed[1]) / length;
            if size <= TOLERANCE {
                return Some(at);
            }
            // Central differences: the last steps converge as fast as rounding lets them.
            let (dn, da) = (1e-5 * at[0], 1e-5);
            let slope = |by: [f64; 2], over: f64| {
                let [more, less] = [1.0, -1.0].map(|sign| miss([at[0] + sign * by[0], at[1] + sign * by[1]]));
                [(more[0] - less[0]) / over, (more[1] - less[1]) / over]
            };
            let ([a, c], [b, d]) = (slope([dn, 0.0], 2.0 * dn), slope([0.0, da], 2.0 * da));
            let determinant = a * d - b * c;
            let step = [(d * missed[0] - b * missed[1]) / determinant, (a * missed[1] - c * missed[0]) / determinant];
            let next = [at[0] - step[0], at[1] - step[1]];
            let then = miss(next);
            if !(then[0].is_finite() && then[1].is_finite() && next[0] > 0.0) {
                return None;
            }
            // No further decrease within rounding: converged.
            if then[0].hypot(then[1]) / length >= size && size <= rounded {
                return Some(at);
            }
            (at, missed) = (next, then);
        }
        None
    }
}

impl Meridian {
    /// `None` without a steady state: dimensions for which no arc joins bead and belt, or a rotation under which the
    /// cords would bear no tension.
    pub(crate) fn new(arc: &Arc) -> Option<Self> {
        let start = [arc.pressure * arc.radius, -arc.angle];
        let spin = arc.mass * arc.angular_velocity * arc.angular_velocity;
        let under = |share: f64| Load { pressure: arc.pressure, spin: share * spin };
        let load = under(1.0);
        let begin = match load.found(arc, start) {
            Some(begin) => begin,
            None => {
                // Continuation: from an almost straight sidewall to its radius of the edge, then from rest to its
                // speed.
                let share = |stage: usize| stage as f64 / STAGES as f64;
                let bent = |at: [f64; 2], stage: usize| {
                    under(0.0).found(&Arc { edge_radius: arc.edge_radius / share(stage), ..arc.clone() }, at)
                };
                let resting = (1..=STAGES).try_fold(start, bent)?;
                (1..=STAGES).try_fold(resting, |at, stage| under(share(stage)).found(arc, at))?
            }
        };
        let [bead_tension, bead_angle] = begin;
        let length = arc.length();
        let state = [arc.bead_radius(), 0.0, bead_angle, arc.bead_radius() * bead_tension];
        let [radius, _, angle, pulled] = load.advanced(state, length, STEPS);
        let edge = EdgeStatics { bead_angle, bead_tension, angle, tension: pulled / radius };
        let meridian = Self { load, length, begin: state, edge };
        let is_tense = meridian.points(8).iter().flatten().all(|point| point.tension > 0.0 && point.radius > 0.0);
        // Newton's method also finds curves that wind round.
        let is_arc = [bead_angle, angle].iter().all(|angle| angle.abs() < PI);
        (is_tense && is_arc && edge.tension > 0.0).then_some(meridian)
    }

    pub(crate) fn edge(&self) -> EdgeStatics {
        self.edge
    }

    pub(super) fn length(&self) -> f64 {
        self.length
    }

    /// Gauss points, three in each of so many equal steps.
    pub(super) fn points(&self, steps: usize) -> Vec<[MeridianPoint; 3]> {
        let step = self.length / steps as f64;
        let offset = 0.1 * 15.0_f64.sqrt() * step;
        let mut along = self.along();
        let mut at = |z: f64| along(z).1;
        let middles = (0..steps).map(|index| (index as f64 + 0.5) * step);
        middles.map(|middle| [middle - offset, middle, middle + offset].map(&mut at)).collect()
    }

    /// Angle a \[rad\] and state at each z \[m\]; successive z must rise.
    pub(super) fn along(&self) -> impl FnMut(f64) -> (f64, MeridianPoint) {
        let mut state = self.begin;
        let mut from = 0.0;
        move |z: f64| {
            let way = z - from;
            state = self.load.advanced(state, way, (STEPS as f64 * way / self.length).ceil().max(1.0) as usize);
            from = z;
            let [radius, _, angle, pulled] = state;
            let ((sine, cosine), tension) = (angle.sin_cos(), pulled / radius);
            let curvature = self.load.curvature(radius, sine, tension);
            (angle, MeridianPoint { radius, sine, cosine, curvature, tension, pressed: self.load.pressure / tension })
        }
    }
}

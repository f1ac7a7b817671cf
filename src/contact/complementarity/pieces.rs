//! Where in its curve a slice is: most slices are still on the same piece of it when they are visited again, and the
//! numbers that the search needs of a piece lie side by side.

use crate::road::slices::StiffnessCurve;

/// Slopes up to this are those of no contact: the stiffness of a slice is a sum of parts of 1, known to rounding.
const NO_SLOPE: f64 = f64::EPSILON;

/// A slice of compliance c on a point of compliance G0_ii, without others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalSlice {
    /// 1/c \[N/m\].
    stiffness: f64,
    /// G0_ii/c - 1.
    excess: f64,
}

impl LocalSlice {
    /// Slice for G0_ii and c \[m/N\].
    pub(crate) fn new(influence: f64, compliance: f64) -> Self {
        Self { stiffness: compliance.recip(), excess: influence / compliance - 1.0 }
    }
}

/// A linear piece of a slice's curve: S(v) = `slope` v + `intercept` for `from` <= v < `to`.
///
/// Which piece is found does not depend on the one that was held before.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeldPiece {
    /// The normalised stiffness s.
    pub slope: f64,
    /// The line's value at v = 0 \[m\].
    pub intercept: f64,
    /// First v \[m\].
    pub from: f64,
    /// End, not included \[m\].
    pub to: f64,
    /// w + (G0_ii/c - 1) S(w) at both ends \[m\].
    series: [f64; 2],
    /// Force in series with the point alone: `rate` y + `offset`.
    rate: f64,
    offset: f64,
    /// Its number in the curve.
    number: usize,
}

impl Default for HeldPiece {
    /// A piece that holds no v.
    fn default() -> Self {
        let nowhere = f64::INFINITY;
        Self {
            slope: 0.0,
            intercept: 0.0,
            from: nowhere,
            to: nowhere,
            series: [nowhere; 2],
            rate: 0.0,
            offset: 0.0,
            number: 0,
        }
    }
}

impl HeldPiece {
    fn of(curve: &StiffnessCurve, number: usize, law: LocalSlice) -> Self {
        let piece = curve.piece(number);
        let series = |k: usize| curve.penetration[k] + law.excess * curve.displacement[k];
        // c F = S(w) = s w + o with w + e S(w) = y gives F = (s y + o)/(c (1 + e s)).
        let share = law.stiffness / (1.0 + law.excess * piece.slope);
        Self {
            slope: piece.slope,
            intercept: piece.intercept,
            from: piece.from,
            to: piece.to,
            series: [
                number.checked_sub(1).map_or(0.0, series),
                if number < curve.penetration.len() { series(number) } else { f64::INFINITY },
            ],
            rate: share * piece.slope,
            offset: share * piece.intercept,
            number,
        }
    }

    #[inline(always)]
    pub(crate) fn holds(&self, v: f64) -> bool {
        self.from <= v && v < self.to
    }

    /// S(v) \[m\].
    #[inline(always)]
    pub(crate) fn displacement(&self, v: f64) -> f64 {
        self.slope * v + self.intercept
    }

    /// Moves to the piece that holds v > 0; returns whether it carries force. Without a curve there is none.
    #[inline(always)]
    pub(crate) fn go_to<'a>(
        &mut self,
        v: f64,
        law: LocalSlice,
        curve: impl FnOnce() -> Option<&'a StiffnessCurve>,
    ) -> bool {
        if !self.holds(v) {
            let Some(curve) = curve() else { return false };
            *self = Self::of(curve, curve.segment_index_near(v, self.number), law);
        }
        self.slope > NO_SLOPE
    }

    /// Force \[N\] at the penetration y that the others leave: S(w)/c with w + (G0_ii/c - 1) S(w) = y; moves to the
    /// piece that holds w.
    #[inline(always)]
    pub(crate) fn force<'a>(
        &mut self,
        y: f64,
        law: LocalSlice,
        curve: impl FnOnce() -> Option<&'a StiffnessCurve>,
    ) -> f64 {
        if y <= 0.0 {
            return 0.0;
        }
        if !(self.series[0] <= y && y < self.series[1]) {
            let Some(curve) = curve() else { return 0.0 };
            *self = Self::of(curve, curve.segment_index_in_series(y, law.excess, self.number), law);
        }
        self.rate * y + self.offset
    }
}

//! Sums for many s at once: as many in lockstep as the processor's vectors hold, both faces from one pass.
//!
//! Neighbours in the list share a group, so a list in the order of |s| wastes least: a group is evaluated up to the
//! largest cut-off of its members, and what lies above the cut-off of a member has weight zero there.

use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use super::folded_sum::{InfluenceSum, SumAt, bounded_rest};
use super::kernel::{Field, LaneKernel};
use super::projection::{Lateral, Projection};
use crate::numeric::lanes::{dispatch, load, store};
use crate::numeric::{Lanes, MOST_LANES, largest_or_zero};

/// Ht_n of the driven and of the innermost face, and its cost; of a tyre that turns, even parts E_n.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FaceValues {
    /// Driven face \[m/N\].
    pub driven: Complex64,
    /// Innermost face \[m/N\].
    pub bottom: Complex64,
    /// Odd parts O_n of the driven and of the innermost face \[m/N\]; 0 at rest.
    pub odd: [Complex64; 2],
    /// Evaluations of the compliance used; one gives both faces.
    pub evaluations: u64,
}

impl InfluenceSum {
    /// True if sums of a driven face are taken in lockstep: where their waves end at a cut-off of s alone, or by
    /// number.
    pub(super) fn in_lockstep(&self, driven: Field) -> bool {
        let ends = self.tail.is_some() || (self.lateral_terms.is_some() && self.aliases.is_some());
        ends && driven != Field::Bottom
    }

    /// Appends Ht_n of both faces for every s of a list to `values`. `driven`: [`Field::Surface`], or
    /// [`Field::UnderTread`].
    pub fn faces<'a>(
        &self,
        n: usize,
        at: impl IntoIterator<Item = &'a SumAt>,
        driven: Field,
        values: &mut Vec<FaceValues>,
    ) {
        let at: Vec<&SumAt> = at.into_iter().collect();
        if self.in_lockstep(driven) {
            dispatch(LaneSum { sum: self, n, at: &at, surface: driven == Field::Surface, values });
            return;
        }
        for at in at {
            let face = self.value(n, at, driven);
            let bottom = self.value(n, at, Field::Bottom);
            let odd = [face.odd, bottom.odd];
            values.push(FaceValues { driven: face.value, bottom: bottom.value, odd, evaluations: face.evaluations });
        }
    }
}

/// The sums of a list. A type, not a closure: it has to be inlined into the dispatch to be compiled for its
/// instructions.
struct LaneSum<'a> {
    sum: &'a InfluenceSum,
    n: usize,
    at: &'a [&'a SumAt],
    /// True if the driven face is the surface; else it is that under the tread.
    surface: bool,
    values: &'a mut Vec<FaceValues>,
}

impl WithSimd for LaneSum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { sum, n, at, surface: on_surface, values } = self;
        let InfluenceSum { projection, tail, lateral_terms, aliases, .. } = sum;
        let fixed = projection.first_lateral(lateral_terms.unwrap_or_default());
        let mut around: Vec<i64> = projection.aliases(n).take(2 * aliases.unwrap_or_default() + 1).collect();
        // 1. Kernels of as many s as there are lanes, each with its cut-off.
        for group in at.chunks(S::F64_LANES) {
            // Lanes without a member repeat the last one.
            let members: [_; MOST_LANES] = std::array::from_fn(|lane| group[lane.min(group.len() - 1)]);
            let kernel = LaneKernel::new(simd, members.map(|at| &at.kernel));
            let mut cut_offs = [f64::INFINITY; MOST_LANES];
            if let Some(tail) = tail {
                let cut_off = |at: &SumAt| at.tail.as_ref().map_or(0.0, |at| tail.cut_off(at, on_surface));
                cut_offs = members.map(cut_off);
                around.clear();
                around.extend(projection.aliases_below(n, largest_or_zero(&cut_offs)));
            }
            let below = Below {
                projection,
                around: &around,
                lateral: tail.as_ref().map_or(&fixed, |tail| &tail.lateral),
                cut_offs: &cut_offs,
            };
            // 2. The waves below the largest cut-off, weight zero where they are above a lane's.
            let zero = Lanes::zero(simd);
            let (mut driven, mut bottom, mut last) = (zero, zero, zero);
            let mut odd = [zero; 2];
            let (weights, evaluations) = if sum.turns() {
                below.visit(
                    simd,
                    #[inline(always)]
                    |alias, m, inside, weight| {
                        let [surface, belt] = kernel.driven_parts(alias.abs(), m, on_surface);
                        driven = driven.plus_weighted(weight, surface.even);
                        bottom = bottom.plus_weighted(weight, belt.even);
                        last = Lanes::blend(inside, surface.even, last);
                        let signed = simd.mul_f64s(weight, simd.splat_f64s(sum.sign_of_odd(n, alias)));
                        odd[0] = odd[0].plus_weighted(signed, surface.odd);
                        odd[1] = odd[1].plus_weighted(signed, belt.odd);
                    },
                )
            } else {
                below.visit(
                    simd,
                    #[inline(always)]
                    |alias, m, inside, weight| {
                        let compliance = kernel.driven(alias, m, on_surface);
                        driven = driven.plus_weighted(weight, compliance.surface);
                        bottom = bottom.plus_weighted(weight, compliance.bottom);
                        last = Lanes::blend(inside, compliance.surface, last);
                    },
                )
            };
            // 3. What lies above each cut-off: the tail, or half of the bound.
            let [odd_driven, odd_bottom] = odd.map(Lanes::to_array);
            let [driven, bottom, last] = [driven, bottom, last].map(Lanes::to_array);
            let weights = store(simd, weights);
            for (lane, at) in group.iter().enumerate() {
                let mut odd = [odd_driven[lane], odd_bottom[lane]];
                let driven = match (tail, &at.tail) {
                    (Some(tail), Some(tail_at)) if on_surface && tail_at.converges => {
                        odd[0] += sum.odd_by_curvature(n, at);
                        driven[lane] + tail.rest(n, tail_at) + sum.by_curvature(n, at)
                    }
                    (Some(_), _) => driven[lane] + bounded_rest(last[lane], projection, weights[lane]),
                    (None, _) => driven[lane],
                };
                values.push(FaceValues { driven, bottom: bottom[lane], odd, evaluations: evaluations[lane] });
            }
        }
    }
}

/// Waves below cut-offs \[1/m\], lane by lane.
pub(in crate::tyre) struct Below<'a> {
    pub(in crate::tyre) projection: &'a Projection,
    /// Wavenumbers n round the tyre.
    pub(in crate::tyre) around: &'a [i64],
    /// Lateral numbers, the lowest first.
    pub(in crate::tyre) lateral: &'a [Lateral],
    pub(in crate::tyre) cut_offs: &'a [f64; MOST_LANES],
}

impl Below<'_> {
    /// Calls `wave` for each wave with its number round the tyre and its lateral number, the mask of the lanes whose
    /// cut-off it is below, and its weights, zero in the other lanes. Returns the sums of the weights and the number
    /// of waves, lane by lane. To be called within a `pulp` dispatch.
    #[inline(always)]
    pub(in crate::tyre) fn visit<S: Simd>(
        self,
        simd: S,
        mut wave: impl FnMut(i64, usize, S::m64s, S::f64s),
    ) -> (S::f64s, [u64; MOST_LANES]) {
        let Self { projection, around, lateral, cut_offs } = self;
        let squares = cut_offs.map(|cut_off| cut_off * cut_off);
        let largest = largest_or_zero(&squares);
        let (limits, zero) = (load(simd, &squares), simd.splat_f64s(0.0));
        let (mut weights, mut numbers) = (zero, [0; MOST_LANES]);
        for &alias in around {
            let kx = projection.waves.kx(alias);
            let longitudinal = projection.longitudinal_weight(alias);
            for lateral in lateral {
                let k_squared = kx * kx + lateral.ky * lateral.ky;
                if k_squared >= largest {
                    break;
                }
                let inside = simd.greater_than_f64s(limits, simd.splat_f64s(k_squared));
                let weight = simd.select_f64s(inside, simd.splat_f64s(lateral.weight * longitudinal), zero);
                wave(alias, lateral.m, inside, weight);
                weights = simd.add_f64s(weights, weight);
                for (number, square) in numbers.iter_mut().zip(&squares) {
                    *number += u64::from(k_squared < *square);
                }
            }
        }
        (weights, numbers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Cords;
    use crate::test_models::tyre;
    use crate::tyre::influence::{Projection, Truncation};

    #[test]
    fn lanes_that_mix_ways_and_cut_offs_equal_the_scalar_sums() {
        let fixed = Truncation::Fixed { lateral_terms: Some(5), aliases: Some(2) };
        for (loss_factor, truncation, cords) in [
            (0.01, Truncation::Tail, false),
            (0.25, Truncation::Tail, false),
            (0.25, fixed, false),
            (0.25, Truncation::Tail, true),
        ] {
            let mut tyre = tyre(loss_factor);
            if cords {
                tyre.layers[0].cords.push(Cords::new(3e9, 25.0, 0.01));
            }
            let sum = InfluenceSum::with(&tyre, Projection::new(&tyre, 128), truncation, 1e-8, 1.3e5);
            assert!(sum.in_lockstep(Field::Surface) && sum.in_lockstep(Field::UnderTread));
            let mut points = vec![Complex64::ZERO];
            points.extend((0..41).map(|k| Complex64::new(0.0, 10f64.powf(0.7 + k as f64 * 0.108))));
            points.extend((0..11).map(|k| Complex64::new(10f64.powf(k as f64 * 0.5), 0.0)));
            points.extend([Complex64::new(3e4, 9e4), Complex64::new(1e3, 1.0)]);
            // Beyond what the sums were prepared for: the tail's series does not converge.
            points.extend((0..6).map(|k| Complex64::new(2e5 * 10f64.powi(k), 1e5)));
            let at: Vec<_> = points.iter().map(|&s| sum.at(s)).collect();
            for (n, driven) in
                [0, 1, 17, 64].into_iter().flat_map(|n| [Field::Surface, Field::UnderTread].map(|f| (n, f)))
            {
                let mut faces = Vec::new();
                sum.faces(n, &at, driven, &mut faces);
                assert_eq!(faces.len(), at.len());
                for ((at, faces), s) in at.iter().zip(&faces).zip(&points) {
                    let scalar = sum.value(n, at, driven);
                    let error = (faces.driven - scalar.value).norm() / scalar.value.norm();
                    assert!(error < 1e-10, "{driven:?}, loss {loss_factor}, n {n}, s {s}: {error:.1e}");
                    assert_eq!(faces.evaluations, scalar.evaluations);
                    let bottom = sum.value(n, at, Field::Bottom).value;
                    let error = (faces.bottom - bottom).norm() / scalar.value.norm();
                    assert!(error < 1e-6, "belt: {driven:?}, loss {loss_factor}, n {n}, s {s}: {error:.1e}");
                }
            }
        }
    }
}

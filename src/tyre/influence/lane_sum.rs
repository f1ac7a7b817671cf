//! Sums for many s at once: as many in lockstep as the processor's vectors hold, both faces from one pass.
//!
//! Neighbours in the list share a group, so a list in the order of |s| wastes least: a group is evaluated up to the
//! largest cut-off of its members, and what lies above a member's own has weight zero there.

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

use super::folded_sum::{InfluenceSum, SumAt, bounded_rest};
use super::half_space_tail::{HalfSpaceTail, HalfSpaceTailAt};
use super::kernel::{Field, KernelAt, LaneKernel};
use super::projection::{Lateral, Projection};
use crate::numeric::lanes::{load, store};
use crate::numeric::{Lanes, MOST_LANES};

/// Ht_n of the driven and of the innermost face with what it took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FaceValues {
    /// Driven face \[m/N\].
    pub driven: Complex64,
    /// Innermost face \[m/N\].
    pub bottom: Complex64,
    /// Evaluations of the compliance (one gives both faces).
    pub evaluations: u64,
}

impl InfluenceSum {
    /// Ht_n of both faces for every s of a list, appended to `values`. `driven`: [`Field::Surface`], or
    /// [`Field::UnderTread`] (one s after the other).
    pub fn faces<'a>(
        &self,
        n: usize,
        at: impl IntoIterator<Item = &'a SumAt>,
        driven: Field,
        values: &mut Vec<FaceValues>,
    ) {
        let at: Vec<&SumAt> = at.into_iter().collect();
        if let (Field::Surface, Some(tail)) = (driven, &self.tail) {
            let members: Vec<_> = at.iter().filter_map(|at| Some((&at.kernel, at.tail.as_ref()?))).collect();
            let first = values.len();
            Arch::new().dispatch(LaneSum { projection: &self.projection, tail, n, at: &members, values });
            let converging = values[first..].iter_mut().zip(at).zip(members).filter(|(_, (_, tail))| tail.converges);
            for ((value, at), _) in converging {
                value.driven += self.by_curvature(n, at);
            }
            return;
        }
        for at in at {
            let face = self.value(n, at, driven);
            let bottom = self.value(n, at, Field::Bottom).value;
            values.push(FaceValues { driven: face.value, bottom, evaluations: face.evaluations });
        }
    }
}

/// The sums of a list. A type, not a closure, since it has to be inlined into the dispatch to be compiled for its
/// instructions.
struct LaneSum<'a> {
    projection: &'a Projection,
    tail: &'a HalfSpaceTail,
    n: usize,
    at: &'a [(&'a KernelAt, &'a HalfSpaceTailAt)],
    values: &'a mut Vec<FaceValues>,
}

impl WithSimd for LaneSum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for group in self.at.chunks(S::F64_LANES) {
            // Lanes without a member repeat the last one.
            let members: [_; MOST_LANES] = std::array::from_fn(|lane| group[lane.min(group.len() - 1)]);
            let kernel = LaneKernel::new(simd, members.map(|(kernel, _)| kernel));
            let cut_offs = members.map(|(_, tail_at)| self.tail.cut_off(tail_at, true).powi(2));
            let explicit = self.explicit(simd, &kernel, &cut_offs);
            let [surface, bottom, last] = [explicit.surface, explicit.bottom, explicit.last].map(Lanes::to_array);
            let weights = store(simd, explicit.weights);
            for (lane, (_, tail_at)) in group.iter().enumerate() {
                let rest = if tail_at.converges {
                    self.tail.rest(self.n, tail_at)
                } else {
                    bounded_rest(last[lane], self.projection, weights[lane])
                };
                self.values.push(FaceValues {
                    driven: surface[lane] + rest,
                    bottom: bottom[lane],
                    evaluations: explicit.evaluations[lane],
                });
            }
        }
    }
}

impl LaneSum<'_> {
    /// The layered part below the squares of cut-offs.
    #[inline(always)]
    fn explicit<S: Simd>(&self, simd: S, kernel: &LaneKernel<'_, S>, cut_offs: &[f64; MOST_LANES]) -> Explicit<S> {
        let zero = Lanes::zero(simd);
        let (mut surface, mut bottom, mut last) = (zero, zero, zero);
        let waves = Below { projection: self.projection, n: self.n, lateral: &self.tail.lateral, cut_offs };
        let (weights, evaluations) = waves.visit(
            simd,
            #[inline(always)]
            |alias, m, inside, weight| {
                let compliance = kernel.normal(alias, m);
                surface = surface.plus_weighted(weight, compliance.surface);
                bottom = bottom.plus_weighted(weight, compliance.bottom);
                last = Lanes::blend(inside, compliance.surface, last);
            },
        );
        Explicit { surface, bottom, last, weights, evaluations }
    }
}

/// The waves that fold into n, below squares of cut-offs, lane by lane.
pub(in crate::tyre) struct Below<'a> {
    pub(in crate::tyre) projection: &'a Projection,
    pub(in crate::tyre) n: usize,
    /// Lateral numbers, the lowest first.
    pub(in crate::tyre) lateral: &'a [Lateral],
    pub(in crate::tyre) cut_offs: &'a [f64; MOST_LANES],
}

impl Below<'_> {
    /// Visits each by its number round the tyre and its lateral number, with the lanes whose cut-off it is below and
    /// its weights, zero in the others; returns the sums of the weights and the number of waves. To be called within
    /// a `pulp` dispatch.
    #[inline(always)]
    pub(in crate::tyre) fn visit<S: Simd>(
        self,
        simd: S,
        mut wave: impl FnMut(i64, usize, S::m64s, S::f64s),
    ) -> (S::f64s, [u64; MOST_LANES]) {
        let Self { projection, n, lateral, cut_offs } = self;
        let largest = cut_offs.iter().fold(0.0_f64, |a, &b| a.max(b));
        let (limits, zero) = (load(simd, cut_offs), simd.splat_f64s(0.0));
        let (mut weights, mut numbers) = (zero, [0; MOST_LANES]);
        for alias in projection.aliases_below(n, largest.sqrt()) {
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
                for (number, cut_off) in numbers.iter_mut().zip(cut_offs) {
                    *number += u64::from(k_squared < *cut_off);
                }
            }
        }
        (weights, numbers)
    }
}

/// The layered part of sums, lane by lane.
struct Explicit<S: Simd> {
    surface: Lanes<S>,
    bottom: Lanes<S>,
    /// C_zz of the last wave.
    last: Lanes<S>,
    /// Sum of the weights of all waves.
    weights: S::f64s,
    evaluations: [u64; MOST_LANES],
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::tyre;
    use crate::tyre::influence::{Projection, Truncation};

    #[test]
    fn lanes_equal_the_scalar_sums_wherever_groups_mix_ways_and_cut_offs() {
        for loss_factor in [0.01, 0.25] {
            let tyre = tyre(loss_factor);
            let sum = InfluenceSum::with(&tyre, Projection::new(&tyre, 128), Truncation::Tail, 1e-8, 1.3e5);
            let mut points = vec![Complex64::ZERO];
            points.extend((0..41).map(|k| Complex64::new(0.0, 10f64.powf(0.7 + k as f64 * 0.108))));
            points.extend((0..11).map(|k| Complex64::new(10f64.powf(k as f64 * 0.5), 0.0)));
            points.extend([Complex64::new(3e4, 9e4), Complex64::new(1e3, 1.0)]);
            // Beyond what the sums were prepared for: the tail's series does not converge.
            points.extend((0..6).map(|k| Complex64::new(2e5 * 10f64.powi(k), 1e5)));
            let at: Vec<_> = points.iter().map(|&s| sum.at(s)).collect();
            for n in [0, 1, 17, 64] {
                let mut faces = Vec::new();
                sum.faces(n, &at, Field::Surface, &mut faces);
                assert_eq!(faces.len(), at.len());
                for ((at, faces), s) in at.iter().zip(&faces).zip(&points) {
                    let scalar = sum.value(n, at, Field::Surface);
                    let error = (faces.driven - scalar.value).norm() / scalar.value.norm();
                    assert!(error < 1e-10, "loss {loss_factor}, n {n}, s {s}: {error:.1e}");
                    assert_eq!(faces.evaluations, scalar.evaluations);
                    let bottom = sum.value(n, at, Field::Bottom).value;
                    let error = (faces.bottom - bottom).norm() / scalar.value.norm();
                    assert!(error < 1e-6, "belt: loss {loss_factor}, n {n}, s {s}: {error:.1e}");
                }
            }
        }
    }
}

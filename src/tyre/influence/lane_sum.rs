//! Sums for many s at once: as many in lockstep as the processor's vectors hold, both faces from one pass.
//!
//! Neighbours in the list share a group, so a list in the order of |s| wastes least: a group is evaluated up to the
//! largest cut-off of its members, and what lies above a member's own has weight zero there.

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

use super::folded_sum::{InfluenceSum, SumAt};
use super::half_space_tail::{HalfSpaceTail, HalfSpaceTailAt};
use super::kernel::{Field, KernelAt, LaneKernel};
use super::projection::Projection;
use crate::numeric::lanes::load;
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
            let converging =
                at.iter().map(|at| at.tail.as_ref().filter(|tail| tail.converges).map(|tail| (&at.kernel, tail)));
            if let Some(converging) = converging.collect::<Option<Vec<_>>>() {
                let first = values.len();
                Arch::new().dispatch(LaneSum { projection: &self.projection, tail, n, at: &converging, values });
                for (value, at) in values[first..].iter_mut().zip(at) {
                    value.driven += self.by_curvature(n, at);
                }
                return;
            }
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
            let (surface, bottom, evaluations) = self.explicit(simd, &kernel, &cut_offs);
            let (surface, bottom) = (surface.to_array(), bottom.to_array());
            for (lane, (_, tail_at)) in group.iter().enumerate() {
                self.values.push(FaceValues {
                    driven: surface[lane] + self.tail.rest(self.n, tail_at),
                    bottom: bottom[lane],
                    evaluations: evaluations[lane],
                });
            }
        }
    }
}

impl LaneSum<'_> {
    /// The layered part below the squares of cut-offs: surface, bottom, evaluations.
    #[inline(always)]
    fn explicit<S: Simd>(
        &self,
        simd: S,
        kernel: &LaneKernel<'_, S>,
        cut_offs: &[f64; MOST_LANES],
    ) -> (Lanes<S>, Lanes<S>, [u64; MOST_LANES]) {
        let largest = cut_offs.iter().fold(0.0_f64, |a, &b| a.max(b));
        let limits = load(simd, cut_offs);
        let (mut surface, mut bottom) = (Lanes::zero(simd), Lanes::zero(simd));
        let mut evaluations = [0; MOST_LANES];
        for alias in self.projection.aliases_below(self.n, largest.sqrt()) {
            let kx = self.projection.waves.kx(alias);
            let longitudinal = self.projection.longitudinal_weight(alias);
            for lateral in &self.tail.lateral {
                let k_squared = kx * kx + lateral.ky * lateral.ky;
                if k_squared >= largest {
                    break;
                }
                let compliance = kernel.normal(alias, lateral.m);
                let inside = simd.greater_than_f64s(limits, simd.splat_f64s(k_squared));
                let weight = simd.splat_f64s(lateral.weight * longitudinal);
                let weight = simd.select_f64s(inside, weight, simd.splat_f64s(0.0));
                surface = surface.plus_weighted(weight, compliance.surface);
                bottom = bottom.plus_weighted(weight, compliance.bottom);
                for (count, cut_off) in evaluations.iter_mut().zip(cut_offs) {
                    *count += u64::from(k_squared < *cut_off);
                }
            }
        }
        (surface, bottom, evaluations)
    }
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

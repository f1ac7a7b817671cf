//! From the columns of the contact window to the forces' components.
//!
//! With columns that lie evenly about the window's middle, theta_c = +-h 2 pi/N from it,
//!
//! ```text
//! sum_c F_c exp(-i n theta_c) = sum_(h > 0) (F_h + F_-h) cos(n theta_h) - i (F_h - F_-h) sin(n theta_h)
//! ```
//!
//! is two products with real matrices for half of the columns and for n >= 0; -n has the opposite sine. A fast
//! transform would take all N elements, of which the window is a twentieth. Forces that are resolved across have as
//! many components of each wavenumber.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use num_complex::{Complex32, Complex64};

use super::model::PressureModel;
use crate::numeric::single;
use crate::response::vibration::SegmentLayout;

/// Buffers for the work on a bin.
pub(super) struct Folded {
    /// Sums and differences of opposite columns: the real parts by block, column by column, then the imaginary ones.
    sides: [Vec<f32>; 2],
    /// Their products with the shapes, n = 0..=most, in the same order.
    products: [Vec<f32>; 2],
}

/// Columns of a window, and the waves of which its components are made.
pub(super) struct Window {
    /// Largest |n|.
    most: usize,
    columns: usize,
    /// Components of a force across.
    components: usize,
    /// Half of the columns, a middle one included.
    half: usize,
    /// exp(-i n 2 pi x/L) of the middle's place x, substep by substep, n = 0..=most.
    places: Vec<Complex64>,
    /// cos(n theta) and sin(n theta), n = 0..=most by n for each column of the half.
    shapes: [Vec<f32>; 2],
    /// By stage, the weight of its force and the time from the step's end at which it acts \[s\].
    actions: Vec<[f64; 2]>,
}

impl Window {
    /// Window of a layout, for components up to the largest |n| `most`.
    pub(super) fn new(layout: &SegmentLayout, most: usize) -> Self {
        let (columns, half) = (layout.columns, layout.columns.div_ceil(2));
        let from_middle = 0.5 * (columns as f64 - 1.0);
        let unit = std::f64::consts::TAU / layout.elements as f64;
        let angles = (0..half).map(|index| unit * ((columns / 2 + index) as f64 - from_middle));
        let middle = layout.first_position + from_middle * layout.circumference / layout.elements as f64;
        let steps = layout.advance.steps(layout.elements) as f64;
        let place = |substep: usize| middle / layout.circumference - substep as f64 / steps;
        let turns = (0..layout.substeps()).flat_map(|substep| (0..=most).map(move |n| n as f64 * place(substep)));
        let places = turns.map(|turns| Complex64::from_polar(1.0, -std::f64::consts::TAU * turns)).collect();
        let table = |shape: fn(f64) -> f64| {
            angles.clone().flat_map(|angle| (0..=most).map(move |n| shape(n as f64 * angle) as f32)).collect()
        };
        let (components, actions) = (layout.components(), layout.actions());
        Self { most, columns, components, half, places, shapes: [table(f64::cos), table(f64::sin)], actions }
    }

    /// Number of wavenumbers -most..=most times components across.
    pub(super) fn waves(&self) -> usize {
        (2 * self.most + 1) * self.components
    }

    pub(super) fn buffers(&self, blocks: usize) -> Folded {
        let width = 2 * blocks;
        Folded {
            sides: [(); 2].map(|()| vec![0.0; self.half * width]),
            products: [(); 2].map(|()| vec![0.0; (self.most + 1) * width]),
        }
    }

    /// Components of the forces of some blocks at a bin: by block, n by n, component by component across, the real
    /// parts of all blocks, then the imaginary ones.
    pub(super) fn components<'a>(
        &self,
        model: &PressureModel,
        bin: usize,
        blocks: impl ExactSizeIterator<Item = &'a [Complex32]> + Clone,
        Folded { sides, products }: &mut Folded,
        out: &mut [f32],
    ) {
        let (most, half, waves, components) = (self.most, self.half, self.waves(), self.components);
        let width = 2 * blocks.len();
        let (real, imaginary) = out.split_at_mut(waves * blocks.len());
        real.fill(0.0);
        imaginary.fill(0.0);
        let substeps = model.layout.substeps();
        let channels = 0..self.actions.len() * components;
        for (channel, substep) in channels.flat_map(|a| (0..substeps).map(move |b| (a, b))) {
            let (stage, component) = (channel / components, channel % components);
            for (block, forces) in blocks.clone().enumerate() {
                // 1. Sums and differences of opposite columns.
                self.fold(|column| forces[(channel * self.columns + column) * substeps + substep], block, sides);
            }
            // 2. Products with cosines and sines, n >= 0.
            for ((side, shape), product) in sides.iter().zip(&self.shapes).zip(&mut *products) {
                let product = MatMut::from_column_major_slice_mut(product, most + 1, width);
                let shape = MatRef::from_column_major_slice(shape, most + 1, half);
                let side = MatRef::from_column_major_slice(side, half, width);
                matmul(product, Accum::Replace, shape, side, 1.0_f32, Par::Seq);
            }
            // 3. Both signs of n, moved to the window's place and the stage's time.
            let factors: Vec<Complex32> =
                (-(most as i64)..=most as i64).map(|n| self.act(model, bin, n, stage, substep)).collect();
            let [even, odd] = products.each_ref().map(|product| product.split_at(product.len() / 2));
            let outs = real.chunks_exact_mut(waves).zip(imaginary.chunks_exact_mut(waves));
            for (block, (real, imaginary)) in outs.enumerate() {
                let [c_re, c_im, s_re, s_im] =
                    [even.0, even.1, odd.0, odd.1].map(|part| &part[block * (most + 1)..][..most + 1]);
                for (index, factor) in factors.iter().enumerate() {
                    let n = index.abs_diff(most);
                    let sign = if index < most { -1.0 } else { 1.0 };
                    let sum = factor * Complex32::new(c_re[n] + sign * s_im[n], c_im[n] - sign * s_re[n]);
                    real[index * components + component] += sum.re;
                    imaginary[index * components + component] += sum.im;
                }
            }
        }
    }

    /// Sums and differences of opposite columns of a block.
    fn fold(&self, force: impl Fn(usize) -> Complex32, block: usize, [sums, differences]: &mut [Vec<f32>; 2]) {
        let (half, imaginary) = (self.half, sums.len() / 2);
        for index in 0..half {
            let [ahead, behind] = [self.columns / 2 + index, (self.columns - 1) / 2 - index];
            let one = force(ahead);
            // A middle column counts once.
            let other = if ahead == behind { Complex32::ZERO } else { force(behind) };
            let (sum, difference) = (one + other, one - other);
            let place = block * half + index;
            (sums[place], sums[imaginary + place]) = (sum.re, sum.im);
            (differences[place], differences[imaginary + place]) = (difference.re, difference.im);
        }
    }

    /// Contribution of a unit force at the window's middle to the component n at a bin.
    fn act(&self, model: &PressureModel, bin: usize, n: i64, stage: usize, substep: usize) -> Complex32 {
        let [weight, time] = self.actions[stage];
        let ahead = self.places[substep * (self.most + 1) + n.unsigned_abs() as usize];
        let place = if n < 0 { ahead.conj() } else { ahead };
        // A rule's last stage acts at the step's end.
        if time == 0.0 {
            return single(weight * place);
        }
        let material = model.layout.material_bin(bin, n) as f64 * model.layout.resolution();
        single(Complex64::from_polar(weight, -std::f64::consts::TAU * material * time) * place)
    }
}

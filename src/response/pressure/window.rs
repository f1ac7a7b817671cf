//! From the forces' components to the columns of the contact window.
//!
//! With columns that lie evenly about the window's middle, theta_c = +-h 2 pi/N from it,
//!
//! ```text
//! sum_n a_n exp(-i n theta) = a_0 + sum_(n > 0) (a_n + a_-n) cos(n theta) - i (a_n - a_-n) sin(n theta)
//! ```
//!
//! is two products with real matrices for half of the columns. A fast transform would give all N elements, of which the
//! window is a twentieth.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use num_complex::{Complex32, Complex64};

use super::model::PressureModel;
use crate::numeric::single;
use crate::response::vibration::SegmentLayout;

/// Room for the work on a bin.
pub(super) struct Folded {
    late: Vec<Complex32>,
    /// Sums and differences of opposite components.
    sides: [Vec<f32>; 2],
    /// Their products with the shapes.
    products: [Vec<f32>; 2],
}

/// The columns of a window and the components that it is made of.
pub(super) struct Window {
    /// Largest |n|.
    most: usize,
    columns: usize,
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
    /// Of a layout, for components up to a largest |n|.
    pub(super) fn new(layout: &SegmentLayout, most: usize) -> Self {
        let (columns, half) = (layout.columns, layout.columns.div_ceil(2));
        let from_middle = 0.5 * (columns as f64 - 1.0);
        let unit = std::f64::consts::TAU / layout.elements as f64;
        let angles = (0..half).map(|index| unit * ((columns / 2 + index) as f64 - from_middle));
        let middle = layout.first_position + from_middle * layout.circumference / layout.elements as f64;
        let steps = (layout.elements * layout.substeps) as f64;
        let place = |substep: usize| middle / layout.circumference - substep as f64 / steps;
        let turns = (0..layout.substeps).flat_map(|substep| (0..=most).map(move |n| n as f64 * place(substep)));
        let places = turns.map(|turns| Complex64::from_polar(1.0, -std::f64::consts::TAU * turns)).collect();
        let table = |shape: fn(f64) -> f64| {
            angles.clone().flat_map(|angle| (0..=most).map(move |n| shape(n as f64 * angle) as f32)).collect()
        };
        Self { most, columns, half, places, shapes: [table(f64::cos), table(f64::sin)], actions: layout.actions() }
    }

    /// Room for a bin of so many receivers.
    pub(super) fn room(&self, receivers: usize) -> Folded {
        let width = 2 * receivers;
        Folded {
            late: Vec::with_capacity(receivers),
            sides: [(); 2].map(|()| vec![0.0; (self.most + 1) * width]),
            products: [(); 2].map(|()| vec![0.0; self.half * width]),
        }
    }

    /// Pressures at a bin for unit force, place by place, receiver by receiver, from the components n: the real parts
    /// by receiver, then the imaginary ones.
    pub(super) fn transfers<'a>(
        &self,
        model: &PressureModel<'_>,
        bin: usize,
        component: impl Fn(i64) -> &'a [f32],
        room: &mut Folded,
        out: &mut [Complex32],
    ) {
        let Self { most, columns, half, .. } = *self;
        let receivers = model.delays.len();
        let Folded { late, sides, products } = room;
        late.clear();
        late.extend(model.late(bin).map(single));
        for (stage, substep) in (0..self.actions.len()).flat_map(|a| (0..model.layout.substeps).map(move |b| (a, b))) {
            for n in 0..=most {
                let [sums, differences] = sides.each_mut().map(|side| &mut side[n * 2 * receivers..][..2 * receivers]);
                let signed = n as i64;
                let ahead = (self.act(model, bin, signed, stage, substep), component(signed));
                // The component 0 is there once.
                let behind = self.act(model, bin, -signed, stage, substep) * f32::from(n > 0);
                fold(ahead, (behind, component(-signed)), sums, differences);
            }
            for ((side, shape), product) in sides.iter().zip(&self.shapes).zip(&mut *products) {
                let product = MatMut::from_column_major_slice_mut(product, 2 * receivers, half);
                let side = MatRef::from_column_major_slice(side, 2 * receivers, most + 1);
                let shape = MatRef::from_column_major_slice(shape, most + 1, half);
                matmul(product, Accum::Replace, side, shape, 1.0_f32, Par::Seq);
            }
            let [even, odd] = &*products;
            let halves = even.chunks_exact(2 * receivers).zip(odd.chunks_exact(2 * receivers));
            for (index, (even, odd)) in halves.enumerate() {
                for (column, sign) in [(columns / 2 + index, 1.0), ((columns - 1) / 2 - index, -1.0)] {
                    let place = (stage * columns + column) * model.layout.substeps + substep;
                    let values = out[place * receivers..][..receivers].iter_mut().zip(&*late);
                    for (receiver, (value, late)) in values.enumerate() {
                        let re = even[receiver] + sign * odd[receivers + receiver];
                        let im = even[receivers + receiver] - sign * odd[receiver];
                        *value = late * Complex32::new(re, im);
                    }
                }
            }
        }
    }

    /// What a unit force at the window's middle is to the component n at a bin.
    fn act(&self, model: &PressureModel<'_>, bin: usize, n: i64, stage: usize, substep: usize) -> Complex32 {
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

/// Sum and difference of two components, each multiplied by a factor.
fn fold(ahead: (Complex32, &[f32]), behind: (Complex32, &[f32]), sums: &mut [f32], differences: &mut [f32]) {
    let receivers = sums.len() / 2;
    let ((a, (a_re, a_im)), (b, (b_re, b_im))) =
        ((ahead.0, ahead.1.split_at(receivers)), (behind.0, behind.1.split_at(receivers)));
    let (sum_re, sum_im) = sums.split_at_mut(receivers);
    let (difference_re, difference_im) = differences.split_at_mut(receivers);
    let values = a_re.iter().zip(a_im).zip(b_re.iter().zip(b_im));
    let folded = sum_re.iter_mut().zip(sum_im).zip(difference_re.iter_mut().zip(difference_im));
    for (((a_re, a_im), (b_re, b_im)), ((sum_re, sum_im), (difference_re, difference_im))) in values.zip(folded) {
        let [p_re, p_im] = [a.re * a_re - a.im * a_im, a.re * a_im + a.im * a_re];
        let [q_re, q_im] = [b.re * b_re - b.im * b_im, b.re * b_im + b.im * b_re];
        (*sum_re, *sum_im, *difference_re, *difference_im) = (p_re + q_re, p_im + q_im, p_re - q_re, p_im - q_im);
    }
}

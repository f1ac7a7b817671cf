//! L D L^T of small symmetric matrices in memory that is taken once.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::linalg::cholesky::ldlt::{factor, solve};
use faer::{MatMut, MatRef, Par};

/// Numbers to a cache line: columns of factors begin on one.
pub const LINE: usize = 8;

/// A matrix turned out singular.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Singular;

/// Zeros that begin on a cache line; pages that are never written to take no memory.
pub struct Aligned {
    memory: Vec<f64>,
    begin: usize,
}

impl Aligned {
    /// So many.
    pub fn new(length: usize) -> Self {
        let memory = vec![0.0; length + LINE - 1];
        let begin = memory.as_ptr().align_offset(8 * LINE).min(LINE - 1);
        Self { memory, begin }
    }

    /// Some of them.
    pub fn part(&mut self, first: usize, length: usize) -> &mut [f64] {
        &mut self.memory[self.begin + first..self.begin + first + length]
    }
}

/// L and D of L D L^T in place, from the lower triangle.
pub fn factorised(matrix: MatMut<'_, f64>, scratch: &mut MemBuffer) -> Result<(), Singular> {
    let (plain, stack) = (LdltRegularization::default(), MemStack::new(scratch));
    factor::cholesky_in_place(matrix, plain, Par::Seq, stack, Default::default()).map(drop).map_err(|_| Singular)
}

/// Solves in place with such factors.
pub fn solve_with(factor: MatRef<'_, f64>, right: MatMut<'_, f64>, scratch: &mut MemBuffer) {
    solve::solve_in_place(factor, factor.diagonal(), right, Par::Seq, MemStack::new(scratch));
}

/// An error unless all values are finite.
pub fn finite(values: &[f64]) -> Result<(), Singular> {
    if values.iter().all(|value| value.is_finite()) { Ok(()) } else { Err(Singular) }
}

/// Scratch of factorisations and of solutions for up to `columns` right-hand sides, of up to so many points.
pub fn scratch_for(points: usize, columns: usize) -> MemBuffer {
    let of = |points| {
        let solution = solve::solve_in_place_scratch::<f64>(points, columns, Par::Seq);
        factor::cholesky_in_place_scratch::<f64>(points, Par::Seq, Default::default()).or(solution)
    };
    MemBuffer::new((1..=points).map(of).fold(StackReq::EMPTY, StackReq::or))
}

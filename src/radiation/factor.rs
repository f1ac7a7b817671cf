//! LU factors of one block's equations, with an estimate of their condition.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::lu::partial_pivoting::solve::{
    solve_in_place_scratch, solve_in_place_with_conj, solve_transpose_in_place_scratch,
    solve_transpose_in_place_with_conj,
};
use faer::perm::PermRef;
use faer::prelude::ReborrowMut;
use faer::{Conj, Mat, MatMut, Par};
use num_complex::Complex64;

#[derive(Debug)]
pub(crate) struct Factor {
    factors: Mat<Complex64>,
    rows: Vec<usize>,
    rows_inverse: Vec<usize>,
    norm: f64,
}

impl Factor {
    /// Factorises sequentially; 8/3 n^3 real operations.
    pub(crate) fn of(mut matrix: Mat<Complex64>) -> Self {
        let size = matrix.nrows();
        let norm = (0..size).map(|j| matrix.col(j).iter().map(|entry| entry.norm()).sum()).fold(0.0, f64::max);
        let (mut rows, mut rows_inverse) = (vec![0_usize; size], vec![0_usize; size]);
        let scratch = lu_in_place_scratch::<usize, Complex64>(size, size, Par::Seq, Default::default());
        let mut buffer = MemBuffer::new(scratch);
        lu_in_place(
            matrix.as_mut(),
            &mut rows,
            &mut rows_inverse,
            Par::Seq,
            MemStack::new(&mut buffer),
            Default::default(),
        );
        Self { factors: matrix, rows, rows_inverse, norm }
    }

    pub(crate) fn solve(&self, mut right: MatMut<'_, Complex64>) {
        let size = self.factors.nrows();
        let scratch = solve_in_place_scratch::<usize, Complex64>(size, right.ncols(), Par::Seq);
        self.with_scratch(scratch, |rows, stack| {
            solve_in_place_with_conj(
                self.factors.as_ref(),
                self.factors.as_ref(),
                rows,
                Conj::No,
                right.rb_mut(),
                Par::Seq,
                stack,
            );
        });
    }

    fn solve_adjoint(&self, mut right: MatMut<'_, Complex64>) {
        let size = self.factors.nrows();
        let scratch = solve_transpose_in_place_scratch::<usize, Complex64>(size, right.ncols(), Par::Seq);
        self.with_scratch(scratch, |rows, stack| {
            solve_transpose_in_place_with_conj(
                self.factors.as_ref(),
                self.factors.as_ref(),
                rows,
                Conj::Yes,
                right.rb_mut(),
                Par::Seq,
                stack,
            );
        });
    }

    fn with_scratch(&self, scratch: StackReq, work: impl FnOnce(PermRef<'_, usize>, &mut MemStack)) {
        let size = self.factors.nrows();
        let mut buffer = MemBuffer::new(scratch);
        work(PermRef::new_checked(&self.rows, &self.rows_inverse, size), MemStack::new(&mut buffer));
    }

    /// Estimate of 1/(|A| |A^-1|) in the 1-norm (W. W. Hager, SIAM J. Sci. Stat. Comput. 5 (1984) 311-316; N. J.
    /// Higham's form): at most a few solutions.
    pub(crate) fn reciprocal_condition(&self) -> f64 {
        let size = self.factors.nrows();
        let mut x = Mat::<Complex64>::full(size, 1, Complex64::new(1.0 / size as f64, 0.0));
        let mut estimate: f64 = 0.0;
        let mut before = usize::MAX;
        for _ in 0..MOST_STEPS {
            // 1. |A^-1 x| bounds |A^-1| from below.
            self.solve(x.as_mut());
            let found: f64 = x.col(0).iter().map(|entry| entry.norm()).sum();
            if found <= estimate {
                break;
            }
            estimate = found;
            // 2. Its gradient over x, by the adjoint of the signs.
            for entry in x.col_mut(0).iter_mut() {
                let size = entry.norm();
                *entry = if size > 0.0 { *entry / size } else { Complex64::ONE };
            }
            self.solve_adjoint(x.as_mut());
            let mut largest = (0, 0.0);
            for (index, entry) in x.col(0).iter().enumerate() {
                if entry.norm() > largest.1 {
                    largest = (index, entry.norm());
                }
            }
            // 3. The unit vector of the steepest ascent is next.
            if largest.0 == before {
                break;
            }
            before = largest.0;
            x = Mat::zeros(size, 1);
            x[(largest.0, 0)] = Complex64::ONE;
        }
        1.0 / (self.norm * estimate)
    }
}

/// Most steps of the condition's estimate.
const MOST_STEPS: usize = 5;

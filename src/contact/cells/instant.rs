//! What forces on the cells displace at the same instant: free field and the images of the tyre's sides,
//!
//! G(ij, i'j') = T\[|i-i'|\]\[|j-j'|\] + H\[|i-i'|\]\[j+j'\].

/// G of the cells of a window.
pub struct InstantCells {
    /// Cells along.
    columns: usize,
    /// Cells across.
    across: usize,
    /// T, columns x across.
    toeplitz: Vec<f64>,
    /// H, columns x (2 across - 1).
    hankel: Vec<f64>,
    /// G(a, a).
    diagonal: Vec<f64>,
}

impl InstantCells {
    /// Of a window of `columns` x `across` cells; `toeplitz` is T, columns x across, and `hankel` is H,
    /// columns x (2 across - 1), both row-major.
    pub fn new(columns: usize, across: usize, toeplitz: Vec<f64>, hankel: Vec<f64>) -> Self {
        let diagonal = (0..columns * across).map(|cell| toeplitz[0] + hankel[2 * (cell % across)]).collect();
        Self { columns, across, toeplitz, hankel, diagonal }
    }

    /// Cells along.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Cells across.
    pub fn across(&self) -> usize {
        self.across
    }

    /// Cells of the window.
    pub fn cells(&self) -> usize {
        self.columns * self.across
    }

    /// G between two cells.
    pub fn entry(&self, a: usize, b: usize) -> f64 {
        let along = (a / self.across).abs_diff(b / self.across);
        let (ja, jb) = (a % self.across, b % self.across);
        self.toeplitz[along * self.across + ja.abs_diff(jb)] + self.hankel[along * (2 * self.across - 1) + ja + jb]
    }

    /// G of each cell with itself.
    pub fn diagonal(&self) -> &[f64] {
        &self.diagonal
    }

    /// Adds u = G F to what is there.
    pub fn add_displacement(&mut self, forces: &[f64], out: &mut [f64]) {
        for (b, &force) in forces.iter().enumerate().filter(|(_, force)| **force != 0.0) {
            for (a, out) in out.iter_mut().enumerate() {
                *out = self.entry(a, b).mul_add(force, *out);
            }
        }
    }
}

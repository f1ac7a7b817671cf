//! Gap equation by finite volumes on a grid of rectangles.
//!
//! ```text
//! div(h F_v grad p) + k^2 h (gamma - (gamma - 1) F_t) p = q
//! ```
//!
//! q = -i w rho s of a volume source s per area. Cells of no height are closed. Between two cells h F_v is the harmonic
//! mean over both halves of the distance: through a step of height flow and pressure are continuous. On an edge
//! alpha p + (beta + b h) p_n = r, p_n the derivative outwards. The matrix is symmetric, so that source and receiver
//! may be exchanged.

use num_complex::Complex64;

use super::banded::Banded;
use super::medium::GapAir;
use crate::radiation::error::RadiationError;

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sheet {
    /// Ends of the cells along, rising \[m\].
    pub x: Vec<f64>,
    /// Ends of the cells across, rising \[m\].
    pub y: Vec<f64>,
    /// Heights of the cells, cell by cell across; 0 where the gap is closed \[m\].
    pub heights: Vec<f64>,
}

/// Condition on an edge: `pressure` p + (`slope` + `slope_by_height` h) p_n = r.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Edge {
    /// Factor of the pressure \[1\] or \[1/m\].
    pub pressure: Complex64,
    /// Factor of the outward derivative \[m\] or \[1\].
    pub slope: Complex64,
    /// Part of that factor that is proportional to the cell's height.
    pub slope_by_height: f64,
}

impl Edge {
    /// Wall: no flow.
    #[cfg(test)]
    pub(crate) const CLOSED: Self = Self { pressure: Complex64::ZERO, slope: Complex64::ONE, slope_by_height: 0.0 };
    /// Given pressure.
    pub(crate) const OPEN: Self = Self { pressure: Complex64::ONE, slope: Complex64::ZERO, slope_by_height: 0.0 };
}

/// Edges of a sheet in the order of [`SheetDrive::edges`]: x low, x high, y low, y high.
pub(crate) type Edges = [Edge; 4];

#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SheetDrive {
    /// Right sides r of the edges' conditions, by cell along the edge; an empty list is zeros.
    pub edges: [Vec<Complex64>; 4],
    /// Right sides q of the equation, by cell; an empty list is zeros \[Pa/m\].
    pub sources: Vec<Complex64>,
}

/// Sheet at a frequency, its equations factorised.
#[derive(Clone, Debug)]
pub(crate) struct FactoredSheet {
    factors: Banded,
    /// By cell, its number among the open ones.
    numbers: Vec<Option<usize>>,
    open: usize,
    /// Per edge, by cell along it: the number of the open cell, and its flow h F_v dp/dn dl for r = 1, without the part
    /// that follows the cell's pressure.
    driven: [Vec<(usize, Complex64)>; 4],
    areas: Vec<f64>,
}

impl Sheet {
    /// Number of cells along and across.
    pub(crate) fn cells(&self) -> [usize; 2] {
        [self.x.len() - 1, self.y.len() - 1]
    }

    /// Length and width of a cell \[m\].
    fn size(&self, i: usize, j: usize) -> [f64; 2] {
        [self.x[i + 1] - self.x[i], self.y[j + 1] - self.y[j]]
    }

    /// h F_v of all cells.
    fn conductances(&self, air: &GapAir, angular: f64) -> Vec<Complex64> {
        self.heights.iter().map(|&height| height * air.flow(height, angular)).collect()
    }

    /// k^2 h (gamma - (gamma - 1) F_t) dx dy of a cell \[m\].
    pub(super) fn storage(&self, air: &GapAir, angular: f64, i: usize, j: usize) -> Complex64 {
        let ([dx, dy], height) = (self.size(i, j), self.heights[i * self.cells()[1] + j]);
        let wavenumber = angular / air.sound_speed;
        air.compression(height, angular) * (wavenumber * wavenumber * height * dx * dy)
    }

    /// Faces between open cells: both cells, and the flow h F_v dp/dn dl by their difference of pressure.
    pub(super) fn faces(&self, air: &GapAir, angular: f64) -> Vec<(usize, usize, Complex64)> {
        let ([along, across], flows) = (self.cells(), self.conductances(air, angular));
        let mut faces = Vec::new();
        let mut face = |[one, other]: [usize; 2], length: f64, ways: [f64; 2]| {
            if self.heights[one] > 0.0 && self.heights[other] > 0.0 {
                let resistance = 0.5 * (ways[0] / flows[one] + ways[1] / flows[other]);
                faces.push((one, other, length / resistance));
            }
        };
        for i in 0..along {
            for j in 0..across {
                let (cell, [dx, dy]) = (i * across + j, self.size(i, j));
                if j + 1 < across {
                    face([cell, cell + 1], dx, [dy, self.size(i, j + 1)[1]]);
                }
                if i + 1 < along {
                    face([cell, cell + across], dy, [dx, self.size(i + 1, j)[0]]);
                }
            }
        }
        faces
    }

    /// Open cells on an edge: place along the edge, cell, and two factors: the flow is r times the first less the
    /// cell's p times the second.
    pub(super) fn on_edge(
        &self,
        air: &GapAir,
        angular: f64,
        edge: usize,
        condition: &Edge,
    ) -> Vec<(usize, usize, [Complex64; 2])> {
        let [along, across] = self.cells();
        let count = if edge < 2 { across } else { along };
        let one = |place: usize| {
            let (i, j) = match edge {
                0 => (0, place),
                1 => (along - 1, place),
                2 => (place, 0),
                _ => (place, across - 1),
            };
            let (cell, [dx, dy]) = (i * across + j, self.size(i, j));
            let height = self.heights[cell];
            let (way, length) = if edge < 2 { (dx, dy) } else { (dy, dx) };
            // The pressure p_e on the edge: pressure p_e + slope (p_e - p) 2/way = r.
            let slope = condition.slope + condition.slope_by_height * height;
            let flow = height * air.flow(height, angular) * (2.0 * length) / (condition.pressure * way + 2.0 * slope);
            (height > 0.0).then_some((place, cell, [flow, flow * condition.pressure]))
        };
        (0..count).filter_map(one).collect()
    }

    /// Number of unknowns, and band of the equations.
    pub(crate) fn unknowns(&self) -> [usize; 2] {
        let across = self.cells()[1];
        let numbers = self.numbers();
        let band = numbers.iter().zip(numbers.iter().skip(across)).filter_map(|(one, next)| Some((*next)? - (*one)?));
        [numbers.iter().flatten().count(), band.max().unwrap_or(0).max(1)]
    }

    /// Number of complex multiply-adds for the factors and for so many right sides.
    pub(crate) fn multiply_adds(&self, rights: usize) -> f64 {
        let [open, band] = self.unknowns();
        Banded::multiply_adds(open, band, rights)
    }

    /// Memory of the factors \[bytes\].
    pub(crate) fn bytes(&self) -> usize {
        let [open, band] = self.unknowns();
        Banded::bytes(open, band)
    }

    fn numbers(&self) -> Vec<Option<usize>> {
        let mut open = 0..;
        self.heights.iter().map(|&height| if height > 0.0 { open.next() } else { None }).collect()
    }

    /// Factorises the equations at an angular frequency \[rad/s\]; [`RadiationError::Singular`].
    pub(crate) fn factorise(&self, air: &GapAir, angular: f64, edges: &Edges) -> Result<FactoredSheet, RadiationError> {
        let [along, across] = self.cells();
        let (numbers, [open, band]) = (self.numbers(), self.unknowns());
        let mut factors = Banded::zeros(open, band);
        // 1. Flows between cells.
        for (one, other, flow) in self.faces(air, angular) {
            let (Some(one), Some(other)) = (numbers[one], numbers[other]) else { continue };
            factors.add(one, one, -flow);
            factors.add(other, other, -flow);
            factors.add(one, other, flow);
            factors.add(other, one, flow);
        }
        // 2. Compression of each cell.
        let mut areas = Vec::with_capacity(along * across);
        for i in 0..along {
            for j in 0..across {
                let [dx, dy] = self.size(i, j);
                areas.push(dx * dy);
                if let Some(number) = numbers[i * across + j] {
                    factors.add(number, number, self.storage(air, angular, i, j));
                }
            }
        }
        // 3. Edges.
        let mut driven: [Vec<(usize, Complex64)>; 4] = Default::default();
        for (edge, (condition, driven)) in edges.iter().zip(&mut driven).enumerate() {
            let count = if edge < 2 { across } else { along };
            *driven = vec![(0, Complex64::ZERO); count];
            for (place, cell, [drive, feedback]) in self.on_edge(air, angular, edge, condition) {
                let Some(number) = numbers[cell] else { continue };
                factors.add(number, number, -feedback);
                driven[place] = (number, drive);
            }
        }
        if open > 0 && !factors.factorise() {
            return Err(RadiationError::Singular { wavenumber: angular / air.sound_speed, unknowns: open });
        }
        Ok(FactoredSheet { factors, numbers, open, driven, areas })
    }
}

/// Drives that are solved for together: few enough for the rows of a band to stay in the fastest cache.
const TOGETHER: usize = 32;

impl FactoredSheet {
    pub(crate) fn area(&self, cell: usize) -> f64 {
        self.areas[cell]
    }

    /// Pressures of some drives: by drive, by cell; 0 where the gap is closed.
    pub(crate) fn solve(&self, drives: &[SheetDrive]) -> Vec<Vec<Complex64>> {
        drives.chunks(TOGETHER).flat_map(|some| self.solve_together(some)).collect()
    }

    fn solve_together(&self, drives: &[SheetDrive]) -> Vec<Vec<Complex64>> {
        let count = drives.len();
        let mut rights = vec![Complex64::ZERO; self.open * count];
        for (column, drive) in drives.iter().enumerate() {
            for (driven, values) in self.driven.iter().zip(&drive.edges) {
                for ((number, flow), value) in driven.iter().zip(values) {
                    if *flow != Complex64::ZERO {
                        rights[number * count + column] -= flow * value;
                    }
                }
            }
            for ((number, area), source) in self.numbers.iter().zip(&self.areas).zip(&drive.sources) {
                if let Some(number) = number {
                    rights[number * count + column] += source * area;
                }
            }
        }
        if self.open > 0 {
            self.factors.solve(&mut rights, count);
        }
        let of = |column: usize| {
            let value = |number: &Option<usize>| number.map_or(Complex64::ZERO, |open| rights[open * count + column]);
            self.numbers.iter().map(value).collect()
        };
        (0..count).map(of).collect()
    }
}

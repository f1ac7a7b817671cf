//! Waves that carry the history of contact cells: geometry only.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use serde::Serialize;

use super::cell_grid::CellGrid;

/// Where the sums over waves end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellTruncation {
    /// Largest m of the history and, if given, of the instant.
    pub lateral_terms: Option<usize>,
    /// Largest alias |p| of the history and, if given, of the instant.
    pub aliases: Option<usize>,
}

/// One wave on cells: those waves of the tyre that are the same on cells, together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CellWave {
    /// n, m and weight \[1/m^2\] of each of the tyre's waves.
    pub terms: Vec<(i64, usize, f64)>,
    /// True if it is its mirror image, the number 0 or N/2 of the ring: the odd part of its function is 0.
    #[serde(skip)]
    pub is_mirror: bool,
    /// Number of lateral numbers after which waves are the same on cells; `None`: lateral numbers are not folded.
    #[serde(skip)]
    pub lateral_period: Option<usize>,
}

/// Waves of one lateral number, n rising.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CellRow {
    /// Lateral number m; of folded rows the lowest.
    pub m: usize,
    /// True if lateral numbers are folded: weights then include the cells' mean over each wave; else the cells' shapes
    /// do.
    pub folded: bool,
    /// Number of the first wave on the ring, n in periods round it.
    pub first: usize,
    pub waves: Vec<CellWave>,
}

/// Waves in a range of wavenumbers, on a ring. The longer ones need all of the tyre; the shorter ones are damped out
/// within a part of it, and a ring of any number of cells that holds that part has fewer waves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaveBand {
    /// Cells of the ring; `None`: those of the tyre.
    pub ring: Option<usize>,
    /// Between these wavenumbers waves fade in \[1/m\]; `None`: from 0 on.
    pub fades_in: Option<[f64; 2]>,
    /// Between these wavenumbers waves fade out \[1/m\]; `None`: as far as the sums go.
    pub fades_out: Option<[f64; 2]>,
    /// True if lateral numbers that are the same on cells are folded; only on a tyre whose sides are whole cells away
    /// from the strip ([`CellGrid::width_in_cells`]).
    pub folded: bool,
}

impl CellWave {
    /// True if a lateral number m looks on cells like one that runs the other way across: of its sines and cosines one
    /// kind changes its sign.
    pub(super) fn is_reflected(&self, m: usize) -> bool {
        self.lateral_period.is_some_and(|period| 2 * (m % period) > period)
    }
}

impl CellRow {
    /// Waves of one lateral number alone, n = 0..=N/2 with all aliases |p| up to `most`: for the tyre's answer to
    /// forces that are resolved across.
    pub fn whole(grid: &CellGrid, m: usize, most: usize) -> Self {
        let (elements, norm) = (grid.elements() as i64, grid.waves().lateral_norm(m));
        let wave = |n: i64| {
            let first = if 2 * n == elements { -n } else { n };
            let around = (-(most as i64)..=most as i64).map(|p| first + p * elements);
            let terms = around.map(|n| (n, m, norm * grid.longitudinal_weight(n))).collect();
            CellWave { terms, is_mirror: n == 0 || 2 * n == elements, lateral_period: None }
        };
        Self { m, folded: false, first: 0, waves: (0..=elements / 2).map(wave).collect() }
    }
}

impl WaveBand {
    /// All waves of the whole tyre.
    pub const WHOLE: Self = Self { ring: None, fades_in: None, fades_out: None, folded: false };

    /// Fraction of a wave that belongs to the band; those of two bands that meet add up to one.
    fn share(&self, k: f64) -> f64 {
        // A step that is smooth in ln k, so that neither part reaches far in space.
        let passed = |[low, high]: [f64; 2]| {
            let place = ((k / low).ln() / (high / low).ln()).clamp(0.0, 1.0);
            (0.5 * PI * place).sin().powi(2)
        };
        self.fades_in.map_or(1.0, passed) * (1.0 - self.fades_out.map_or(0.0, passed))
    }

    /// Waves on the cells of the ring, by lateral number.
    pub fn rows(self, grid: &CellGrid, truncation: CellTruncation) -> Vec<CellRow> {
        let waves = grid.waves();
        let ring = grid.elements();
        let CellTruncation { lateral_terms, aliases } = truncation;
        // The first zero of the cells' mean over a wave.
        let largest = 2.0 * PI / grid.length().min(grid.pitch());
        let last_m = lateral_terms.unwrap_or((largest / waves.ky(1)) as usize);
        let most = aliases.unwrap_or(1) as i64;
        let ends = if aliases.is_some() && lateral_terms.is_some() { f64::INFINITY } else { largest };
        let lateral = |m: usize| if self.folded { grid.lateral_weight(m) } else { waves.lateral_norm(m) };
        let lateral_period = self.folded.then(|| grid.lateral_period());
        // The ring's waves of one lateral number, those without terms at either end left out.
        let row = |(m, numbers): (usize, Vec<usize>)| {
            let wave = |bin: usize| {
                // The ring's n run from -N/2: its N/2 is -N/2.
                let first = if 2 * bin == ring { -(bin as i64) } else { bin as i64 };
                let around = (-most..=most).map(|p| first + p * ring as i64);
                let pairs = around.flat_map(|n| numbers.iter().map(move |&m| (n, m)));
                let terms = pairs.filter_map(|(n, m)| {
                    let k = waves.kx(n).hypot(waves.ky(m));
                    let weight = self.share(k) * grid.carried(n, m) * grid.longitudinal_weight(n) * lateral(m);
                    (weight > 0.0 && k <= ends).then_some((n, m, weight))
                });
                CellWave { terms: terms.collect(), is_mirror: bin == 0 || 2 * bin == ring, lateral_period }
            };
            let mut all: Vec<CellWave> = (0..=ring / 2).map(wave).collect();
            let first = all.iter().position(|wave| !wave.terms.is_empty())?;
            all.truncate(all.iter().rposition(|wave| !wave.terms.is_empty())? + 1);
            Some(CellRow { m, folded: self.folded, first, waves: all.split_off(first) })
        };
        let numbers = grid.lateral_numbers().take_while(|&m| m <= last_m);
        let mut same: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for m in numbers {
            same.entry(if self.folded { grid.same_on_cells(m) } else { m }).or_default().push(m);
        }
        same.into_iter().filter(|(m, _)| grid.is_felt(*m)).filter_map(row).collect()
    }
}

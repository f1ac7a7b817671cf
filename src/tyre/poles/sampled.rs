//! Exact functions of one wavenumber, sampled where a fit wants them, and the errors of a model there.
//!
//! Samples on the *grid* are what fits may use; *fresh* ones, half-way between them, and every other one on the real
//! axis only check.
//!
//! Errors of the driven face are relative to its *local scale*, |H_n(s)| but no less than 0.003 of its largest value
//! over the band, and for the carcass under a bedding no less than the whole tyre's at rest; those of the belt to the
//! largest |D_n|.
//!
//! With rotation, both faces have an even and an odd part, E and O, with H_n = E + i O and H_-n = E - i O. The
//! error of a face is then the worse of both waves', |dE + i dO| or |dE - i dO|, and |H_n| is the mean of both,
//! sqrt(|E|^2 + |O|^2) = sqrt((|H_n|^2 + |H_-n|^2)/2). Squares of the parts' errors add up to the mean square of the
//! waves', so that both parts have the same weight in a fit.

use num_complex::Complex64;

use super::ladder::{Ladder, REAL, RUNGS};
use crate::numeric::rational::partial_fractions::is_pair;
use crate::numeric::rational::vector_fitting::residues;
use crate::numeric::rational::{ComplexParts, PartialFractions, RationalError, Samples};
use crate::tyre::influence::FaceValues;

/// Smallest local scale of the driven face's errors, relative to the largest |H_n|. The contact feels G0, H_n at large
/// s, where H_n is a hundredth of its resonances: with errors relative to those alone, forces are ten times as wrong
/// as the model. Measured on a rough road at N = 1024: 1e-5 with this floor takes as many poles as 1e-6 of the largest
/// value, and the error of the force is a fifth; with 0.01 it is four times, with 0.0003 a fifth of that with this
/// one, for 2 % fewer and 3 % more poles.
const LEAST_SCALE: f64 = 3e-3;
/// Most rungs that join the grid in one round.
const MOST_JOINING: usize = 12;
/// Parts of the faces: E of the driven and of the innermost one, then O of both.
const PARTS: usize = 4;

/// Target of the fit of a wavenumber.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Target {
    /// Wavenumber n.
    pub wavenumber: usize,
    /// Largest error relative to |H_n(s)|, or to 0.003 of its largest value over the band where that is more.
    pub tolerance: f64,
    /// Most poles, conjugates counted.
    pub most_poles: usize,
    /// True if a constant is fitted.
    pub constant: bool,
    /// Largest |D_n| of all wavenumbers, to which the error of the belt is relative. 0: of this wavenumber.
    pub bottom_scale: f64,
    /// Least local scale of the driven face's errors.
    pub least_scale: f64,
    /// Most times that poles may be removed.
    pub removals: usize,
    /// Poles are removed only where the error is below this fraction of the tolerance.
    pub removal_below: f64,
}

/// Evaluates the exact functions on a list of rungs of the [`Ladder`], in their order.
pub(super) type Sample<'s> = dyn FnMut(&[usize], &mut Vec<FaceValues>) + 's;

/// Samples of one wavenumber, and which of them fits may use.
pub(super) struct Sampled<'a> {
    pub ladder: &'a Ladder,
    pub target: &'a Target,
    /// Samples by rung: driven and innermost face.
    values: Vec<Option<[Complex64; 2]>>,
    /// Odd parts by rung; empty as long as all of them are 0.
    odd: Vec<[Complex64; 2]>,
    /// Rungs of the axis that fits may use, rising.
    pub grid: Vec<usize>,
    /// Rungs of the axis that only check, rising.
    pub fresh: Vec<usize>,
    /// Further fresh rungs, where a model has a peak narrower than the distance of the samples.
    probes: Vec<usize>,
    /// Largest |H_n| and |D_n| so far, each the mean of both waves.
    pub scales: [f64; 2],
    pub evaluations: u64,
}

/// A model of one wavenumber: poles, the fractions of both faces over them, and their errors.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub poles: Vec<Complex64>,
    /// E of the driven and of the innermost face; of a wave that differs from its mirror image O of both, too.
    pub models: Vec<PartialFractions>,
    pub errors: Errors,
}

/// Errors of a model, each relative to its scale (see the module).
#[derive(Clone, Copy, Debug)]
pub(super) struct Errors {
    /// Worst of both faces on the grid and the odd real rungs.
    pub fitted: f64,
    /// Worst of both faces on the fresh rungs and the even real rungs.
    pub fresh: f64,
    /// Worst of both faces on the fresh rungs of the axis.
    pub between: f64,
    /// Largest of the driven face on the fresh rungs of the axis.
    pub axis: f64,
    /// Largest of the driven face on the real axis.
    pub real: f64,
    /// Largest of the belt on fresh rungs and the real axis.
    pub bottom: f64,
    /// s where the error on the grid, or on the real axis if that is the worst of all, is largest.
    pub worst: Complex64,
}

impl Errors {
    pub(super) fn largest(&self) -> f64 {
        self.fitted.max(self.fresh)
    }
}

/// The larger of |E + i O|^2 and |E - i O|^2.
fn largest_square(even: Complex64, odd: Complex64) -> f64 {
    even.norm_sqr() + odd.norm_sqr() + 2.0 * (even * odd.conj()).im.abs()
}

/// Magnitude of a pole's residue in a face, the larger of the waves n and -n.
pub(super) fn largest_residue(models: &[PartialFractions], face: usize, index: usize) -> f64 {
    let even = models[face].residues[index];
    match models.get(face + 2) {
        Some(odd) => largest_square(even, odd.residues[index]).sqrt(),
        None => even.norm(),
    }
}

impl<'a> Sampled<'a> {
    /// Samples a grid of rungs, those half-way between, and the real axis.
    pub(super) fn new(ladder: &'a Ladder, target: &'a Target, grid: Vec<usize>, sample: &mut Sample<'_>) -> Self {
        let mut sampled = Self {
            ladder,
            target,
            values: vec![None; REAL.end],
            odd: Vec::new(),
            grid,
            fresh: Vec::new(),
            probes: Vec::new(),
            scales: [0.0; 2],
            evaluations: 0,
        };
        sampled.refresh(sample);
        sampled
    }

    /// Squares of a face's samples on the imaginary axis.
    fn on_axis(&self, face: usize) -> impl Iterator<Item = f64> {
        self.values[..REAL.start].iter().enumerate().filter_map(move |(rung, value)| {
            value.map(|value| value[face].norm_sqr() + self.odd(rung)[face].norm_sqr())
        })
    }

    /// True if the belt moves by more than a fraction of its scale anywhere.
    pub(super) fn bottom_exceeds(&self, share: f64) -> bool {
        self.on_axis(1).any(|square| square > (share * self.scales[1]).powi(2))
    }

    /// True if the odd parts of a face exceed a fraction of its scale anywhere.
    pub(super) fn odd_exceeds(&self, face: usize, share: f64) -> bool {
        let exceeds = |rung: &usize| {
            let scale = if face == 0 { self.local_scale(self.square(*rung)) } else { self.scales[1] };
            self.odd(*rung)[face].norm_sqr() > (share * scale).powi(2)
        };
        !self.odd.is_empty() && (0..REAL.end).filter(|&rung| self.values[rung].is_some()).any(|rung| exceeds(&rung))
    }

    /// Updates `fresh` for the grid, evaluates missing samples, and updates the scales.
    fn refresh(&mut self, sample: &mut Sample<'_>) {
        self.fresh =
            self.grid.windows(2).filter(|pair| pair[1] - pair[0] > 1).map(|pair| (pair[0] + pair[1]) / 2).collect();
        let probes = self.probes.iter().filter(|probe| self.grid.binary_search(probe).is_err());
        self.fresh.extend(probes);
        self.fresh.sort_unstable();
        self.fresh.dedup();
        let rungs = self.grid.iter().chain(&self.fresh).copied().chain(REAL);
        let mut wanted: Vec<usize> = rungs.filter(|&rung| self.values[rung].is_none()).collect();
        // Neighbouring rungs side by side: see `lane_sum`.
        wanted.sort_unstable();
        let mut values = Vec::with_capacity(wanted.len());
        sample(&wanted, &mut values);
        for (rung, faces) in wanted.into_iter().zip(values) {
            self.evaluations += faces.evaluations;
            self.values[rung] = Some([faces.driven, faces.bottom]);
            if faces.odd != [Complex64::ZERO; 2] {
                self.odd.resize(REAL.end, [Complex64::ZERO; 2]);
                self.odd[rung] = faces.odd;
            }
        }
        let largest = |face: usize| self.on_axis(face).fold(0.0_f64, f64::max).sqrt();
        let given = self.target.bottom_scale;
        self.scales = [largest(0), if given > 0.0 { given } else { largest(1) }];
    }

    pub(super) fn value(&self, rung: usize) -> [Complex64; 2] {
        self.values[rung].unwrap_or_default()
    }

    /// Odd parts of both faces.
    fn odd(&self, rung: usize) -> [Complex64; 2] {
        self.odd.get(rung).copied().unwrap_or_default()
    }

    /// Mean of |H_n|^2 and |H_-n|^2 of the driven face.
    fn square(&self, rung: usize) -> f64 {
        self.value(rung)[0].norm_sqr() + self.odd(rung)[0].norm_sqr()
    }

    /// Number of parts: two of a wave like its mirror image, else four.
    fn parts(&self) -> usize {
        if self.odd.is_empty() { PARTS / 2 } else { PARTS }
    }

    /// Samples that fits may use, of all parts.
    pub(super) fn samples(&self) -> Samples {
        self.samples_of(|_| true)
    }

    /// As [`Self::samples`], of chosen parts, the driven face's E among them: the belt and the odd parts take part in
    /// moving poles only where they are not negligible.
    pub(super) fn samples_of(&self, chosen: impl Fn(usize) -> bool) -> Samples {
        // Fits may use the odd rungs of the real axis.
        let rungs: Vec<usize> = self.grid.iter().copied().chain(REAL.skip(1).step_by(2)).collect();
        let value = |part: usize, rung: usize| if part < 2 { self.value(rung)[part] } else { self.odd(rung)[part - 2] };
        let parts: Vec<usize> = (0..self.parts()).filter(|&part| chosen(part)).collect();
        let response = |&part: &usize| rungs.iter().map(|&rung| value(part, rung)).collect();
        Samples {
            weights: parts.iter().map(|part| self.scales[part % 2].max(f64::MIN_POSITIVE).recip()).collect(),
            point_weights: rungs.iter().map(|&rung| self.point_weight(self.square(rung))).collect(),
            points: rungs.iter().map(|&rung| self.ladder.points[rung]).collect(),
            responses: parts.iter().map(response).collect(),
        }
    }

    /// Best model over given poles; `samples` of all parts.
    pub(super) fn candidate(&self, samples: &Samples, poles: Vec<Complex64>) -> Result<Candidate, RationalError> {
        let mut models = residues(samples, &poles, self.target.constant)?;
        if self.target.constant && models.len() > 2 {
            // Odd parts have no constant.
            let odd = Samples {
                responses: samples.responses[2..].to_vec(),
                weights: samples.weights[2..].to_vec(),
                ..samples.clone()
            };
            models.splice(2.., residues(&odd, &poles, false)?);
        }
        let errors = self.errors(&models);
        Ok(Candidate { poles, models, errors })
    }

    /// Scale of errors of the driven face where the mean of |H_n|^2 and |H_-n|^2 is `square`.
    pub(super) fn local_scale(&self, square: f64) -> f64 {
        let largest = self.scales[0];
        let scale = square.sqrt().max(LEAST_SCALE * largest).min(largest);
        scale.max(self.target.least_scale).max(f64::MIN_POSITIVE)
    }

    /// Weight of an error where the mean of |H_n|^2 and |H_-n|^2 is `square`, relative to where it is largest.
    pub(super) fn point_weight(&self, square: f64) -> f64 {
        self.scales[0].max(f64::MIN_POSITIVE) / self.local_scale(square)
    }

    /// Errors of both faces at rungs, in their order.
    fn errors_at(&self, models: &[PartialFractions], rungs: &[usize]) -> Vec<[f64; 2]> {
        let points = ComplexParts::new(rungs.iter().map(|&rung| self.ladder.points[rung]), 1.0);
        let modelled: Vec<ComplexParts> = models.iter().map(|model| model.evaluate_all(&points)).collect();
        let at = |(k, &rung): (usize, &usize)| {
            let (values, odd) = (self.value(rung), self.odd(rung));
            let scales = [self.local_scale(self.square(rung)), self.scales[1].max(f64::MIN_POSITIVE)];
            std::array::from_fn(|face| {
                let of_even = modelled[face].get(k) - values[face];
                let of_odd = modelled.get(face + 2).map_or(Complex64::ZERO, |odds| odds.get(k) - odd[face]);
                let error = largest_square(of_even, of_odd).sqrt() / scales[face];
                // NaN would lose every comparison and pass for no error.
                if error.is_finite() { error } else { f64::INFINITY }
            })
        };
        rungs.iter().enumerate().map(at).collect()
    }

    pub(super) fn errors(&self, models: &[PartialFractions]) -> Errors {
        let worst = self.ladder.points[0];
        let mut errors = Errors { fitted: 0.0, fresh: 0.0, between: 0.0, axis: 0.0, real: 0.0, bottom: 0.0, worst };
        let rungs: Vec<usize> = self.grid.iter().chain(&self.fresh).copied().chain(REAL).collect();
        let all = self.errors_at(models, &rungs);
        let (on_grid, others) = all.split_at(self.grid.len());
        let (between, real) = others.split_at(self.fresh.len());
        for (&rung, [driven, bottom]) in self.grid.iter().zip(on_grid) {
            let error = driven.max(*bottom);
            if error > errors.fitted {
                (errors.fitted, errors.worst) = (error, self.ladder.points[rung]);
            }
        }
        for both in between {
            errors.axis = errors.axis.max(both[0]);
            errors.bottom = errors.bottom.max(both[1]);
            errors.between = errors.between.max(both[0]).max(both[1]);
        }
        errors.fresh = errors.between;
        for (rung, both) in REAL.zip(real) {
            errors.real = errors.real.max(both[0]);
            errors.bottom = errors.bottom.max(both[1]);
            let error = both[0].max(both[1]);
            if error > errors.fitted.max(errors.fresh) {
                errors.worst = self.ladder.points[rung];
            }
            let kind = if (rung - REAL.start) % 2 == 1 { &mut errors.fitted } else { &mut errors.fresh };
            *kind = kind.max(error);
        }
        errors
    }

    /// Moves fresh rungs with a large error into the grid, the largest first. `false` if there are none.
    pub(super) fn refine(&mut self, models: &[PartialFractions], sample: &mut Sample<'_>) -> bool {
        let limit = 0.5 * self.target.tolerance;
        let errors = self.errors_at(models, &self.fresh).into_iter().map(|[driven, bottom]| driven.max(bottom));
        let mut joining: Vec<(f64, usize)> =
            errors.zip(self.fresh.iter().copied()).filter(|&(error, _)| error > limit).collect();
        joining.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        joining.truncate(MOST_JOINING);
        if joining.is_empty() {
            return false;
        }
        let joining = joining.into_iter().map(|(_, rung)| rung);
        self.grid.extend(joining);
        self.grid.sort_unstable();
        self.refresh(sample);
        true
    }

    /// Samples the exact function where the model has a peak that would fit between two samples: nothing else would
    /// reveal it if it were spurious. Returns whether there was one.
    pub(super) fn probe(&mut self, Candidate { poles, models, .. }: &Candidate, sample: &mut Sample<'_>) -> bool {
        let mut sampled: Vec<usize> = self.grid.iter().chain(&self.fresh).copied().collect();
        sampled.sort_unstable();
        let before = self.probes.len();
        for (index, pole) in poles.iter().enumerate().filter(|(_, pole)| is_pair(**pole)) {
            let s = Complex64::new(0.0, pole.im);
            let at = |part: usize| models.get(part).map_or(0.0, |model| model.evaluate(s).norm_sqr());
            let height = largest_residue(models, 0, index) / (pole.re.abs() * self.local_scale(at(0) + at(2)));
            let rung = self.ladder.points[..REAL.start].partition_point(|s| s.im < pole.im).min(RUNGS);
            let next = sampled.partition_point(|&other| other < rung);
            let at = |index: usize| sampled.get(index).map_or(0.0, |&other| self.ladder.points[other].im);
            let apart = at(next) - at(next.saturating_sub(1));
            let narrow = apart > 0.0 && pole.re.abs() < apart;
            let known = sampled.get(next) == Some(&rung) || self.probes.contains(&rung);
            if narrow && !known && height > 0.3 * self.target.tolerance {
                self.probes.push(rung);
            }
        }
        let found = self.probes.len() > before;
        if found {
            self.refresh(sample);
        }
        found
    }

    /// Moves fresh rungs into the grid until it determines the unknowns with a margin.
    pub(super) fn enough_samples(&mut self, order: usize, sample: &mut Sample<'_>) {
        while self.grid.len() < order + 12 && !self.fresh.is_empty() {
            self.grid.extend(self.fresh.iter().copied());
            self.grid.sort_unstable();
            self.refresh(sample);
        }
    }
}

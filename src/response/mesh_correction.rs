//! Levels of a long run over a coarse mesh, corrected by two short runs on the first piece of its road, over the coarse
//! and over a finer mesh: the coarse run is a control variate of the fine one (Glasserman 2004, Monte Carlo Methods in
//! Financial Engineering, section 4.1).
//!
//! The longer the waves, the more alike are forces over two meshes on the same road: most of their scatter is common.
//! Let E_f and E_c be the mean squares of a band over the fine and the coarse mesh during T seconds, and E_l the mean
//! square of the coarse run over T_l >= T seconds, which begins with these. The corrected mean square E has
//!
//! ```text
//! ln E = ln E_f + b (ln E_l - ln E_c)
//! ```
//!
//! whose expectation is that of the fine mesh for any b. For Gaussian signals (Bendat & Piersol 2010, Random Data,
//! section 8.5) the covariances of the relative mean squares are
//!
//! ```text
//! v_ff = integral S_f^2 df/E_f^2,  v_cc likewise,  v_fc = integral |S_fc|^2 df/(E_f E_c)
//! var ln E_f = v_ff/T,  cov(ln E_f, ln E_l) = v_fc/T_l,  cov(ln E_c, ln E_l) = v_cc/T_l
//! ```
//!
//! so b = v_fc/v_cc is best whatever T_l is, and leaves
//!
//! ```text
//! var ln E = v_ff/T - (1/T - 1/T_l) v_fc^2/v_cc
//! ```
//!
//! Where the meshes have nothing in common, b = 0: the fine run stands alone. |S_fc|^2 = gamma^2 S_f S_c with one
//! coherence for a band, over its bins and the segments of both records, less what n bins of independent signals have:
//! 1/n.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use super::band_gain::BandGain;
use super::spectrum::PowerSpectrum;
use super::third_octave::ThirdOctaveBand;

/// Decibels of a relative change of a mean square.
const DECIBELS: f64 = 10.0 / std::f64::consts::LN_10;

/// Variance to which a longer comparison of the meshes brings a band, relative to that of the longest coarse run.
const ATTAINABLE: f64 = 1.2;

/// Correction of a band.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
struct BandCorrection {
    band: ThirdOctaveBand,
    /// E_f and E_c \[unit^2\].
    mean_squares: [f64; 2],
    /// v_ff, v_cc and v_fc \[s\].
    covariances: [f64; 3],
}

/// Correction of the levels of a signal.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct MeshCorrection {
    /// T \[s\].
    seconds: f64,
    bands: Vec<BandCorrection>,
}

impl MeshCorrection {
    /// Correction by spectra of the fine and the coarse mesh over the same time, whose records have kept their
    /// transforms; without bands if they have not.
    pub(crate) fn between(fine: &PowerSpectrum, coarse: &PowerSpectrum, lowest: f64) -> Self {
        let seconds = coarse.averaged_over.map_or(0.0, |[seconds, _]| seconds);
        let bands = ThirdOctaveBand::within(lowest..coarse.nyquist * (1.0 + 1e-12));
        let bands = bands.into_iter().filter(|band| band.width() >= 2.0 * coarse.resolution);
        Self { seconds, bands: bands.filter_map(|band| BandCorrection::of(band, fine, coarse)).collect() }
    }

    /// Gains of the bands of a long record over the coarse mesh.
    pub(crate) fn gains(&self, long: &PowerSpectrum) -> Vec<BandGain> {
        let Some([seconds, _]) = long.averaged_over else { return Vec::new() };
        let gain = |correction: &BandCorrection| {
            let BandCorrection { band, mean_squares: [fine, coarse], covariances: [_, v_cc, v_fc] } = *correction;
            let found = long.power_within(band.lower_edge()..band.upper_edge());
            let corrected = fine * (found / coarse).powf(v_fc / v_cc);
            let variance = correction.variance(self.seconds, seconds);
            (found > 0.0).then(|| BandGain { band, gain: corrected / found, variance })
        };
        self.bands.iter().filter_map(gain).collect()
    }

    /// Bands whose middle lies between two frequencies \[Hz\].
    fn within(&self, [lowest, highest]: [f64; 2]) -> impl Iterator<Item = &BandCorrection> {
        let is_above = move |of: &BandCorrection| of.band.upper_edge() > lowest;
        self.bands.iter().filter(move |of| is_above(of) && of.band.is_valid_up_to(highest))
    }

    /// Band within a range of frequencies \[Hz\] that has the largest standard error after a run of `long` seconds, and
    /// that error \[dB\].
    pub(crate) fn largest_error(&self, range: [f64; 2], long: f64) -> Option<(ThirdOctaveBand, f64)> {
        let error = |of: &BandCorrection| (of.band, DECIBELS * of.variance(self.seconds, long).sqrt());
        self.within(range).map(error).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Time T \[s\], at least the present one and at most `longest`, for which a run of `longest` seconds brings the
    /// standard error of the bands within a range \[Hz\] to `error` \[dB\], or to little more than it has for any T.
    pub(crate) fn needed_comparison(&self, error: f64, range: [f64; 2], longest: f64) -> f64 {
        let variance = (error / DECIBELS).powi(2);
        let needed = |of: &BandCorrection| {
            let ([v_ff, _, _], least) = (of.covariances, of.common() / longest);
            (v_ff - of.common()) / (variance.max(ATTAINABLE * least) - least)
        };
        self.within(range).map(needed).fold(self.seconds, f64::max).min(longest)
    }

    /// Time T_l \[s\], at most `longest`, for which the standard error of the bands within a range \[Hz\] is `error`
    /// \[dB\].
    pub(crate) fn needed_run(&self, error: f64, range: [f64; 2], longest: f64) -> f64 {
        let variance = (error / DECIBELS).powi(2);
        let needed = |of: &BandCorrection| {
            let [v_ff, _, _] = of.covariances;
            let beyond = v_ff / self.seconds - variance;
            let long = (1.0 / self.seconds - beyond / of.common()).recip();
            // Not positive where no T_l is long enough.
            if beyond > 0.0 && long <= 0.0 { longest } else { long.max(self.seconds) }
        };
        self.within(range).map(needed).fold(self.seconds, f64::max).min(longest)
    }
}

impl BandCorrection {
    fn of(band: ThirdOctaveBand, fine: &PowerSpectrum, coarse: &PowerSpectrum) -> Option<Self> {
        let (edges, df) = (band.lower_edge()..band.upper_edge(), coarse.resolution);
        let [_, overlap] = coarse.averaged_over?;
        let bins = || fine.bins_within(edges.clone()).zip(coarse.bins_within(edges.clone()));
        let [mut e_f, mut e_c, mut ff, mut cc, mut fc] = [0.0; 5];
        for ((f, whole_f), (c, whole_c)) in bins() {
            (e_f, e_c) = (e_f + f, e_c + c);
            (ff, cc, fc) = (ff + f * whole_f, cc + c * whole_c, fc + f * whole_c);
        }
        let coherence = coherence(&edges, fine, coarse, e_f * e_c / fc);
        let covariances = [ff / e_f.powi(2), cc / e_c.powi(2), coherence * fc / (e_f * e_c)];
        let covariances = covariances.map(|sum| sum / (df * overlap));
        (e_f > 0.0 && e_c > 0.0).then_some(Self { band, mean_squares: [e_f, e_c], covariances })
    }

    /// v_fc^2/v_cc \[s\].
    fn common(&self) -> f64 {
        let [_, v_cc, v_fc] = self.covariances;
        v_fc * v_fc / v_cc
    }

    /// Variance of ln E for times T and T_l \[s\].
    fn variance(&self, short: f64, long: f64) -> f64 {
        let [v_ff, _, _] = self.covariances;
        v_ff / short - (1.0 / short - 1.0 / long).max(0.0) * self.common()
    }
}

/// Coherence gamma^2 of two records over some frequencies \[Hz\], whose transforms have equal resolutions, by segment;
/// 0 where they do not match. `independent` is the number n of bins that independent signals would have.
fn coherence(edges: &std::ops::Range<f64>, fine: &PowerSpectrum, coarse: &PowerSpectrum, independent: f64) -> f64 {
    let first = (edges.start / coarse.resolution).ceil() as usize;
    let end = (edges.end / coarse.resolution).ceil() as usize;
    if fine.transforms.len() != coarse.transforms.len() || (fine.resolution / coarse.resolution - 1.0).abs() > 1e-9 {
        return 0.0;
    }
    let (mut common, mut all) = (0.0, 0.0);
    for (fine, coarse) in fine.transforms.iter().zip(&coarse.transforms) {
        let [Some(fine), Some(coarse)] = [fine, coarse].map(|bins| bins.get(first..end)) else { return 0.0 };
        let product: Complex64 = fine.iter().zip(coarse).map(|(f, c)| f * c.conj()).sum();
        let power = |bins: &[Complex64]| bins.iter().map(Complex64::norm_sqr).sum::<f64>();
        common += product.norm_sqr();
        all += power(fine) * power(coarse);
    }
    let biased = if all > 0.0 { common / all } else { 0.0 };
    if independent > 1.0 { ((independent * biased - 1.0) / (independent - 1.0)).clamp(0.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::response::SpectrumAccumulator;

    const RATE: f64 = 2000.0;

    /// Noise, and a signal of half that rate whose part below some 250 Hz is the same to 1 part in 5, twice as strong,
    /// and above it has nothing to do with it.
    fn pair(seed: u64, seconds: f64) -> [Vec<f64>; 2] {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut noise = |count: usize| -> Vec<f64> {
            (0..count).map(|_| (0..4).map(|_| random.random_range(-1.0..1.0)).sum()).collect()
        };
        let count = (seconds * RATE) as usize;
        let [common, fine, coarse] = [2 * count, 2 * count, count].map(&mut noise);
        let mut low = [0.0_f64; 2];
        let mut smooth = Vec::new();
        for value in common {
            low[0] += 0.5 * (value - low[0]);
            low[1] += 0.5 * (low[0] - low[1]);
            smooth.push(low[1]);
        }
        let mean = |n: usize| 0.5 * (smooth[2 * n] + smooth[2 * n + 1]);
        let coarse = (0..count).map(|n| 2.0 * (mean(n) + 0.06 * coarse[n])).collect();
        [smooth.iter().zip(fine).map(|(smooth, fine)| smooth + 0.04 * fine).collect(), coarse]
    }

    fn spectrum(signal: &[f64], rate: f64, kept: usize) -> PowerSpectrum {
        let accumulator = SpectrumAccumulator::new(signal.len(), 1.0 / rate, Some(0.5)).unwrap();
        let mut accumulator = accumulator.keeping(Some(kept));
        signal.iter().for_each(|&value| accumulator.push(value));
        accumulator.finish().unwrap()
    }

    /// Corrected levels scatter from seed to seed by their standard errors, about the level over the fine mesh.
    #[test]
    fn corrected_levels_scatter_by_their_standard_errors_about_the_fine_one() {
        const SEEDS: u64 = 60;
        let (short, long) = (0.6, 6.0);
        let found: Vec<(PowerSpectrum, PowerSpectrum)> = (0..SEEDS)
            .map(|seed| {
                let [fine, coarse] = pair(seed, long);
                let cut = (short * RATE) as usize;
                let pieces = [spectrum(&fine[..2 * cut], 2.0 * RATE, 2), spectrum(&coarse[..cut], RATE, 1)];
                let correction = MeshCorrection::between(&pieces[0], &pieces[1], 40.0);
                let mut whole = spectrum(&coarse, RATE, 1);
                whole.correct(&correction.gains(&whole));
                (whole, PowerSpectrum::of(&fine, 0.5 / RATE, Some(0.5)).unwrap())
            })
            .collect();
        for (number, gained) in [(-10, 2.0), (-7, 2.0), (-4, 1.0), (-2, 1.0)] {
            let band = ThirdOctaveBand(number);
            let level =
                |spectrum: &PowerSpectrum| 10.0 * spectrum.power_within(band.lower_edge()..band.upper_edge()).log10();
            let mean = |levels: &dyn Fn(&(PowerSpectrum, PowerSpectrum)) -> f64| {
                found.iter().map(levels).sum::<f64>() / SEEDS as f64
            };
            let [exact, corrected] = [mean(&|(_, fine)| level(fine)), mean(&|(corrected, _)| level(corrected))];
            let error = |spectrum: &PowerSpectrum| spectrum.standard_error([band]).unwrap();
            let chi: f64 = found.iter().map(|(of, _)| ((level(of) - corrected) / error(of)).powi(2)).sum();
            let typical = mean(&|(corrected, _)| error(corrected));
            println!("{band:?}: {corrected:.2} for {exact:.2} dB +- {typical:.2} dB, chi^2 = {chi:.0}");
            assert!((28.0..101.0).contains(&chi), "{band:?}: chi^2 = {chi}");
            assert!((corrected - exact).abs() < 4.0 * typical / (SEEDS as f64).sqrt(), "{band:?}: {corrected} {exact}");
            // The fine record alone over its 0.6 s.
            let alone = 10.0 / std::f64::consts::LN_10 / (band.width() * short).sqrt();
            assert!(typical < alone / gained * 1.15, "{band:?}: {typical} dB of {alone}");
        }
    }

    #[test]
    fn needed_times_give_the_error_asked_for() {
        let [fine, coarse] = pair(7, 4.0);
        let of = |seconds: f64| {
            let cut = (seconds * RATE) as usize;
            let pieces = [spectrum(&fine[..2 * cut], 2.0 * RATE, 2), spectrum(&coarse[..cut], RATE, 1)];
            MeshCorrection::between(&pieces[0], &pieces[1], 40.0)
        };
        let correction = MeshCorrection { seconds: 0.1, ..of(4.0) };
        let largest = |seconds: f64, long: f64| {
            let compared = MeshCorrection { seconds, ..correction.clone() };
            compared.largest_error([100.0, 700.0], long).unwrap().1
        };
        for error in [0.2, 0.5, 1.0] {
            let short = correction.needed_comparison(error, [100.0, 700.0], 60.0);
            let compared = MeshCorrection { seconds: short, ..correction.clone() };
            let long = compared.needed_run(error, [100.0, 700.0], 60.0);
            assert!(short <= long && largest(short, long) <= error * 1.001, "{error} dB: {short} {long}");
            assert!(long <= short || largest(short, 0.9 * long) > 0.99 * error, "{error} dB: {short} {long}");
        }
        let short = correction.needed_comparison(1e-3, [100.0, 250.0], 60.0);
        assert!(short < 20.0, "common scatter needs no long comparison: {short} s");
        assert!(correction.needed_run(1e-3, [100.0, 250.0], 60.0) >= 60.0);
    }
}

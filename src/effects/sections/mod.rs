//! Sections of the road: levels of the force, texture levels and mean profile depth of each, with their standard
//! errors; the [sound](super::sound) adds its levels. Memory: that of a section.
//!
//! A section's rows go to the table when all observers have completed it, see
//! [`EffectObserver::section_rows`](super::observer::EffectObserver::section_rows).

pub(crate) mod cut;

use std::collections::VecDeque;

use super::effect::{Effect, RunStart};
use super::error::RunError;
use super::observer::{EffectObserver, End, Found, Observer, Step};
use super::section::{PageSection, ReportError, pictures};
use super::stored::Stored;
use crate::counters::{Job, Meter, Stage};
use crate::numeric::RunningMoments;
use crate::plan::{Amounts, Plan, SEGMENT};
use crate::response::{PowerSpectrum, SpectrumAccumulator, ThirdOctaveBand};
use crate::results::files::ResultFiles;
use crate::results::sections::{
    MEAN_FORCE, SECTION_DEPTH, SECTION_FORCE, SECTION_MACROTEXTURE, SECTION_MEGATEXTURE, SECTION_TEXTURE,
    SECTIONS_FILE, SECTIONS_PICTURE, SectionValue, strip_chart,
};
use crate::results::spectra::LOWEST_FREQUENCY;
use crate::road::RoadProfiles;
use crate::road::texture::{OverallLevel, ProfileDepth, ProfileSpectrum, TextureLevel, nearest_band};
use crate::scene::TimeRule;
use crate::storage::state::{StateError, StateStream};
use cut::{SectionCut, SectionSpectra};

/// Longest wavelength of a section's texture levels, in lengths of the section: fewer periods give no reliable level.
const LONGEST: f64 = 0.25;
/// Band of wavenumber 1/m, as a band of the frequency 1/s: -30 - n is the texture's band n.
const BAND_OF_A_METRE: i32 = -30;
/// Memory of the profiles of a section over that of their heights: copies with a window, and their transforms.
const PROFILE_COPIES: f64 = 4.0;

pub(crate) struct SectionsEffect;

impl Effect for SectionsEffect {
    fn name(&self) -> &'static str {
        "sections"
    }

    fn add_amounts(&self, plan: &Plan, amounts: &mut Amounts) {
        let Some(length) = plan.scene.outputs.sections else { return };
        amounts.hold("spectrum of a section", SpectrumAccumulator::bytes(plan.time_step, SEGMENT));
        let profiles = RoadProfiles::MOST as f64 * length / plan.scene.road.cell();
        amounts.hold("profiles of a section", 8.0 * PROFILE_COPIES * profiles);
    }

    fn sections(&self, stored: &Stored, _: &[Stored]) -> Result<Vec<PageSection>, ReportError> {
        let caption = "Sections of the road: overall levels over the valid bands, depth and texture. Shaded: one \
                       standard error to either side.";
        let blocks = pictures(stored, &[[SECTIONS_PICTURE, caption]])?;
        Ok(vec![PageSection { heading: "Sections of the road", blocks }])
    }

    fn begin(&self, begin: &mut RunStart<'_>, _: &mut Job<'_>) -> Result<Option<Box<dyn EffectObserver>>, RunError> {
        let Some(cut) = SectionCut::of(begin.plan, begin.contact.geometry.start) else { return Ok(None) };
        let plan = begin.plan;
        let accumulator = |samples: usize, time_step: f64| SpectrumAccumulator::new(samples, time_step, Some(SEGMENT));
        Ok(Some(Box::new(SectionsObserver {
            cut,
            spectra: SectionSpectra::new(cut, 0, plan.time_step, accumulator),
            force: RunningMoments::default(),
            profiles: begin.profiles.take(),
            recording: (plan.scene.numerics.time_rule, plan.time_step),
            valid_to: begin.contact.force_valid_to(),
            rows: VecDeque::new(),
        })))
    }
}

struct SectionsObserver {
    cut: SectionCut,
    spectra: SectionSpectra,
    /// Total force of the section so far \[N\].
    force: RunningMoments,
    /// Profiles of the road; `None` for the plane.
    profiles: Option<RoadProfiles>,
    /// Time rule whose mean force over a step is recorded, and the time step \[s\].
    recording: (TimeRule, f64),
    valid_to: f64,
    /// Rows of complete sections that are still to be written.
    rows: VecDeque<String>,
}

impl Observer for SectionsObserver {
    fn observe(&mut self, step: &Step<'_>, meter: &mut Meter) -> Result<(), RunError> {
        if !step.counts {
            return Ok(());
        }
        self.force.push(step.total_force);
        let Some((section, spectrum)) = self.spectra.push(step.total_force) else { return Ok(()) };
        let open = meter.open();
        self.complete(section, spectrum)?;
        meter.close(open, Stage::Response);
        Ok(())
    }
}

impl EffectObserver for SectionsObserver {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.spectra, &mut self.force])?;
        state.value(&mut self.rows)
    }

    fn section_rows(&mut self) -> Option<&mut VecDeque<String>> {
        Some(&mut self.rows)
    }

    fn write(&self, end: &End<'_>, files: &dyn ResultFiles, _: &mut Found, _: &mut Meter) -> Result<(), RunError> {
        let title = || format!("Sections of the road: {}", end.loaded.title());
        let table = files.read_text(SECTIONS_FILE).filter(|_| end.loaded.scene.outputs.plots);
        if let Some(picture) = table.and_then(|table| strip_chart(&table, &title())) {
            files.write_text(SECTIONS_PICTURE, &picture)?;
        }
        Ok(())
    }
}

impl SectionsObserver {
    /// Adds the rows of a section.
    fn complete(&mut self, number: u64, spectrum: Option<PowerSpectrum>) -> Result<(), RunError> {
        let section = self.cut.section(number);
        let mean = std::mem::take(&mut self.force).mean();
        let mut values: Vec<_> = mean.map(|mean| SectionValue::overall(MEAN_FORCE, mean, None)).into_iter().collect();
        if let Some(spectrum) = spectrum {
            let (rule, time_step) = self.recording;
            values.extend(force_values(&spectrum.without_mean_of_steps(rule, time_step).valid_to(self.valid_to)));
        }
        if let Some(profiles) = &mut self.profiles {
            let [begin, end] = section.ends;
            values.extend(texture_values(&profiles.between(begin, end)?, profiles.spacing()));
        }
        self.rows.push_back(section.rows(values));
        Ok(())
    }
}

/// Overall level of the force, the sum of the valid bands, and its third octaves.
fn force_values(spectrum: &PowerSpectrum) -> impl Iterator<Item = SectionValue<'static>> {
    let levels = spectrum.third_octaves(LOWEST_FREQUENCY, 1.0);
    let valid = || levels.iter().filter(|level| level.valid);
    let sum: f64 = valid().map(|level| level.mean_square).sum();
    let error = spectrum.standard_error(valid().map(|level| level.band));
    let overall = (sum > 0.0).then(|| SectionValue::overall(SECTION_FORCE, 10.0 * sum.log10(), error));
    let bands: Vec<_> = levels
        .iter()
        .map(|level| SectionValue {
            place: [Some(level.band.nominal_frequency()), None],
            valid: level.valid,
            ..SectionValue::overall(SECTION_FORCE, level.level, spectrum.standard_error([level.band]))
        })
        .collect();
    overall.into_iter().chain(bands)
}

/// Mean profile depth and texture levels of equally long profiles with heights `spacing` \[m\] apart. The standard
/// error of a level is that of one profile, since neighbours have long waves in common.
fn texture_values(profiles: &[Vec<f64>], spacing: f64) -> Vec<SectionValue<'static>> {
    let Some(middle) = profiles.get(profiles.len() / 2) else { return Vec::new() };
    let depth = ProfileDepth::of(profiles.iter().map(|profile| (&profile[..], &[][..])), spacing);
    let mut values: Vec<_> = depth
        .mean
        .map(|mean| SectionValue {
            valid: !depth.too_coarse,
            ..SectionValue::overall(SECTION_DEPTH, 1e3 * mean, depth.standard_error.map(|error| 1e3 * error))
        })
        .into_iter()
        .collect();
    let mut spectrum = ProfileSpectrum::new(middle.len(), spacing);
    profiles.iter().for_each(|profile| spectrum.add(profile));
    let levels = spectrum.levels(LONGEST * middle.len() as f64 * spacing, 2.0 * spacing);
    // Wavenumbers in cycles per metre are to the profile what frequencies are to a signal.
    let waves = PowerSpectrum::of(middle, spacing, None).ok();
    let band = |level: &TextureLevel| nearest_band(level.wavelength);
    let error = |bands: &[i32]| {
        waves.as_ref()?.standard_error(bands.iter().map(|band| ThirdOctaveBand(BAND_OF_A_METRE - band)))
    };
    let overall = [
        (SECTION_MACROTEXTURE, OverallLevel::macrotexture(&levels)),
        (SECTION_MEGATEXTURE, OverallLevel::megatexture(&levels)),
    ];
    for (quantity, found) in overall.into_iter().filter_map(|(quantity, found)| Some((quantity, found?))) {
        let bands = nearest_band(found.shortest)..=nearest_band(found.longest);
        let error = error(&bands.collect::<Vec<_>>());
        values.push(SectionValue::overall(quantity, found.level, error));
    }
    values.extend(levels.iter().map(|level| SectionValue {
        // Third octaves of wavelengths in millimetres have the nominal numbers of those of frequencies in hertz.
        place: [None, Some(ThirdOctaveBand(band(level)).nominal_frequency())],
        valid: level.valid,
        ..SectionValue::overall(SECTION_TEXTURE, level.level, error(&[band(level)]))
    }));
    values
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn texture_levels_scatter_by_their_standard_errors() {
        const SECTIONS: usize = 60;
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let (mut state, mut found) = (0.0, Vec::new());
        for _ in 0..SECTIONS {
            let profile: Vec<f64> = (0..10_000)
                .map(|_| {
                    state = 0.95 * state + 1e-4 * random.random_range(-1.0..1.0);
                    state
                })
                .collect();
            found.push(texture_values(&[profile], 1e-3));
        }
        for wavelength in [250.0, 50.0, 10.0] {
            let is_band = |value: &&SectionValue<'_>| value.place[1] == Some(wavelength);
            let values: Vec<_> = found.iter().filter_map(|values| values.iter().find(is_band)).collect();
            let mean = values.iter().map(|value| value.value).sum::<f64>() / values.len() as f64;
            let chi: f64 = values.iter().map(|of| ((of.value - mean) / of.error.unwrap()).powi(2)).sum();
            println!("{wavelength} mm: {mean:.1} dB, +- {:.2} dB, chi^2 {chi:.0}", values[0].error.unwrap());
            // The Hann window of the levels counts half of a profile, and so does the scatter at its begin and end.
            assert!((40.0..180.0).contains(&chi) && values.len() == SECTIONS, "{wavelength} mm: chi^2 = {chi}");
        }
        let [depth, macrotexture] = [SECTION_DEPTH, SECTION_MACROTEXTURE]
            .map(|quantity| found[0].iter().find(|value| value.quantity == quantity).unwrap());
        assert!(depth.valid && depth.error.unwrap() > 0.0 && macrotexture.error.unwrap() < 0.5, "{macrotexture:?}");
        assert!(texture_values(&[], 1e-3).is_empty());
    }
}

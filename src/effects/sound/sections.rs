//! Sound by section of the road: A-weighted levels of the receivers that move with the tyre.
//!
//! A section's sound is that of the forces of its steps: pressures are early by their delay. The first and the last
//! section have none where the sound of the run, which needs steps before and behind, does not cover them.

use std::collections::VecDeque;

use rayon::prelude::*;

use super::summed::Summed;
use super::valid_levels::{over_valid_bands, standard_error_a};
use crate::effects::sections::cut::{SectionCut, SectionSpectra};
use crate::plan::sound::{SOUND_FADE, SOUND_SEGMENT, Sound};
use crate::response::{PowerSpectrum, SpectrumAccumulator};
use crate::results::sections::{SECTION_SOUND, SectionValue};
use crate::storage::state::{Evolving, StateError, StateStream};

/// Pressures of a streamed point.
struct PointSections {
    /// Index among the streamed points.
    streamed: usize,
    spectra: SectionSpectra,
    /// Spectra of sections that other points have not completed yet; none between two passes of the sound.
    complete: VecDeque<(u64, Option<PowerSpectrum>)>,
}

/// Levels of the receivers by section.
pub(super) struct SoundSections {
    cut: SectionCut,
    /// Receivers that move with the tyre, by name, each with the number of its streamed points.
    receivers: Vec<(String, usize)>,
    /// Their points, receiver by receiver, place by place.
    points: Vec<PointSections>,
    /// Highest frequency up to which levels are valid \[Hz\].
    valid_to: f64,
    /// Rows of complete sections that are still to be written.
    pub rows: VecDeque<String>,
}

impl SoundSections {
    /// Sections of a sound whose first sample is at a step after the warm-up; `None` if all receivers are passed.
    pub(super) fn new(cut: SectionCut, sound: &Sound, first: u64, valid_to: f64) -> Option<Self> {
        let time_step = sound.path.layout.time_step;
        let accumulator =
            |samples: usize, time_step: f64| SpectrumAccumulator::faded(samples, time_step, SOUND_SEGMENT, SOUND_FADE);
        let spectra = || SectionSpectra::new(cut, first, time_step, accumulator);
        let of_points = |points: std::ops::Range<usize>| {
            let place = |streamed: &usize| sound.path.spectrum_of(*streamed).map(|place| place % sound.path.points());
            (0..sound.path.streamed()).filter(move |streamed| place(streamed).is_some_and(|at| points.contains(&at)))
        };
        let (mut receivers, mut points) = (Vec::new(), Vec::new());
        for receiver in sound.receivers.iter().filter(|receiver| !receiver.is_passed()) {
            let before = points.len();
            points.extend(of_points(receiver.points.clone()).map(|streamed| PointSections {
                streamed,
                spectra: spectra(),
                complete: VecDeque::new(),
            }));
            receivers.push((receiver.name.clone(), points.len() - before));
        }
        // Sections without sound have no rows, and their place.
        let rows = vec![String::new(); spectra().next_section() as usize].into();
        (!points.is_empty()).then_some(Self { cut, receivers, points, valid_to, rows })
    }

    /// Takes the pressures of a batch of streamed points, whose first has an index.
    pub(super) fn take(&mut self, first: usize, end: usize, pressures: &Summed<'_>) {
        let of_batch = self.points.par_iter_mut().filter(|point| (first..end).contains(&point.streamed));
        of_batch.for_each(|PointSections { streamed, spectra, complete }| {
            pressures.of(*streamed - first, |block| {
                complete.extend(block.iter().filter_map(|&pressure| spectra.push(pressure)));
            });
        });
    }

    /// Adds the rows of the sections that all points have completed.
    pub(super) fn complete(&mut self) {
        while self.points.iter().all(|point| !point.complete.is_empty()) {
            let next = self.points.iter_mut().filter_map(|point| point.complete.pop_front());
            let (sections, spectra): (Vec<u64>, Vec<_>) = next.unzip();
            let Some(&section) = sections.first() else { return };
            let (mut spectra, mut values) = (spectra.into_iter(), Vec::new());
            for (receiver, points) in &self.receivers {
                let of_receiver: Vec<PowerSpectrum> = spectra.by_ref().take(*points).flatten().collect();
                let Some(mean) = PowerSpectrum::mean_of(of_receiver.iter()) else { continue };
                let mean = mean.valid_to(self.valid_to);
                let levels = over_valid_bands(&mean);
                let error = standard_error_a(&mean, &levels);
                let value = SectionValue::overall(SECTION_SOUND, levels.overall_a, error);
                let valid = levels.covered().is_some();
                values.push(SectionValue { receiver, valid, ..value });
            }
            self.rows.push_back(self.cut.section(section).rows(values));
        }
    }
}

impl Evolving for SoundSections {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.value(&mut self.rows)?;
        self.points.iter_mut().try_for_each(|point| point.spectra.state(state))
    }
}

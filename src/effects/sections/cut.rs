//! Where a run's sections begin and end, and spectra of its signals section by section.

use crate::plan::Plan;
use crate::response::{PowerSpectrum, SpectrumAccumulator, SpectrumError};
use crate::results::sections::Section;
use crate::storage::state::{Evolving, StateError, StateStream};

/// Share of a step that a last section may lack, by the rounding of the run's length to steps.
const ROUNDING: f64 = 0.499;

/// Sections of the road that a run rolls after its warm-up, of equal length. Steps count from the end of the warm-up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SectionCut {
    /// Length of a section \[m\].
    length: f64,
    /// Steps in which the tyre rolls it; not whole.
    steps: f64,
    /// Number of complete sections.
    pub count: u64,
    /// Road coordinate under the axle at the begin of the first \[m\].
    begin: f64,
    speed_kmh: f64,
}

impl SectionCut {
    /// Sections of a plan's run that starts at a road coordinate \[m\]; `None` if the scene asks for none.
    pub(crate) fn of(plan: &Plan, start: f64) -> Option<Self> {
        let (length, step) = (plan.scene.outputs.sections?, plan.speed * plan.time_step);
        let steps = length / step;
        let count = (((plan.steps - plan.warm_up_steps) as f64 + ROUNDING) / steps) as u64;
        let begin = start + step * plan.warm_up_steps as f64;
        Some(Self { length, steps, count, begin, speed_kmh: plan.scene.rolling.speed_kmh })
    }

    /// First step of a section, counted from 0.
    fn first_step(&self, section: u64) -> u64 {
        (section as f64 * self.steps).round() as u64
    }

    /// A section, counted from 0, as the table has it.
    pub(crate) fn section(&self, number: u64) -> Section {
        let end = |number: u64| self.begin + number as f64 * self.length;
        Section { number: number + 1, ends: [number, number + 1].map(end), speed_kmh: self.speed_kmh }
    }
}

/// Accumulator of a record of so many samples, a time \[s\] apart.
pub(crate) type NewAccumulator = fn(usize, f64) -> Result<SpectrumAccumulator, SpectrumError>;

/// Spectra of a signal, one for each section. Memory: that of one section.
pub(crate) struct SectionSpectra {
    cut: SectionCut,
    time_step: f64,
    begin: NewAccumulator,
    /// Step of the next sample.
    next: u64,
    /// Section that is open or comes next.
    section: u64,
    open: Option<SpectrumAccumulator>,
}

impl SectionSpectra {
    /// For a signal whose first sample is at a step; sections that begin before it have no spectrum.
    pub(crate) fn new(cut: SectionCut, first: u64, time_step: f64, begin: NewAccumulator) -> Self {
        let section = (0..cut.count).find(|&section| cut.first_step(section) >= first).unwrap_or(cut.count);
        Self { cut, time_step, begin, next: first, section, open: None }
    }

    /// Number of the section that is open or comes next, from 0.
    pub(crate) fn next_section(&self) -> u64 {
        self.section
    }

    /// Takes the next sample; returns the number of the section that it completes, from 0, with its spectrum, `None`
    /// if that cannot be computed.
    pub(crate) fn push(&mut self, value: f64) -> Option<(u64, Option<PowerSpectrum>)> {
        if self.section >= self.cut.count {
            return None;
        }
        if self.next == self.cut.first_step(self.section) {
            self.open();
        }
        self.next += 1;
        if let Some(open) = &mut self.open {
            open.push(value);
        }
        if self.next < self.cut.first_step(self.section + 1) {
            return None;
        }
        self.section += 1;
        Some((self.section - 1, self.open.take().and_then(|open| open.finish().ok())))
    }

    fn open(&mut self) {
        let [first, end] = [self.section, self.section + 1].map(|section| self.cut.first_step(section));
        self.open = (self.begin)((end - first) as usize, self.time_step).ok();
    }
}

impl Evolving for SectionSpectra {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.next, &mut self.section])?;
        if state.is_restoring() && self.section < self.cut.count && self.next > self.cut.first_step(self.section) {
            self.open();
        }
        self.open.state(state)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::state::SavedState;

    const CUT: SectionCut = SectionCut { length: 1.0, steps: 33.3, count: 4, begin: 0.0, speed_kmh: 80.0 };

    fn begin(samples: usize, time_step: f64) -> Result<SpectrumAccumulator, SpectrumError> {
        SpectrumAccumulator::new(samples, time_step, Some(0.5))
    }

    fn signal(step: u64) -> f64 {
        (0.7 * step as f64).sin() + (0.31 * (step * step % 97) as f64).cos()
    }

    /// Sections completed by the steps up to 150, stopped after some of them and continued by another object.
    fn found(first: u64, stop: u64) -> Vec<(u64, PowerSpectrum)> {
        let new = || SectionSpectra::new(CUT, first, 1e-3, begin);
        let mut spectra = new();
        let mut found = Vec::new();
        for step in first..150 {
            if step == stop {
                let saved = SavedState::of(&mut spectra).unwrap();
                spectra = new();
                saved.restore(&mut spectra).unwrap();
            }
            found.extend(spectra.push(signal(step)).map(|(section, spectrum)| (section, spectrum.unwrap())));
        }
        found
    }

    #[test]
    fn each_section_has_the_spectrum_of_its_steps() {
        let whole = found(0, 0);
        for ((section, spectrum), (number, steps)) in whole.iter().zip((0..).zip([0..33, 33..67, 67..100, 100..133])) {
            let samples: Vec<f64> = steps.map(signal).collect();
            assert_eq!((*section, spectrum), (number, &PowerSpectrum::of(&samples, 1e-3, Some(0.5)).unwrap()));
        }
        assert_eq!(whole.len(), 4);
        for stop in [1, 33, 34, 66, 90, 133, 140] {
            assert_eq!(found(0, stop), whole, "stopped at {stop}");
        }
        assert_eq!(found(33, 60), whole[1..], "a signal that begins with the second section");
        assert_eq!(found(34, 60), whole[2..], "and one that begins within it");
    }

    #[test]
    fn the_state_does_not_grow_with_the_road() {
        let bytes = |sections: u64| {
            let cut = SectionCut { count: sections, ..CUT };
            let mut spectra = SectionSpectra::new(cut, 0, 1e-3, begin);
            (0..cut.first_step(sections - 1) + 10).for_each(|step| drop(spectra.push(signal(step))));
            postcard::to_stdvec(&SavedState::of(&mut spectra).unwrap()).unwrap().len()
        };
        assert!(bytes(1000) < bytes(2) + 20, "{} {}", bytes(1000), bytes(2));
    }
}

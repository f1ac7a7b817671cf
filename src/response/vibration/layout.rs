//! Sizes of a segment, and the bins of both frames.
//!
//! A revolution is exactly N q steps, or N/s with s elements to a step, where q is 1: read N/s for N q then. A segment
//! of r revolutions has K = r N q steps, bins df = 1/(K dt) apart, and the rotation shifts the wavenumber n by n V/L =
//! n r df: a whole number of bins, so both frames have the same bins. The forces are sampled at instants of the
//! material, so the material frequency is the one within the Nyquist interval: w' = w - n Omega, aliased there by
//! whole sampling rates where it lies outside.
//!
//! A Runge-Kutta rule has several instants in a step, each with separate forces. They all belong to the same elements,
//! since the window moves on between steps only: the forces of one stage are a sequence over the steps as those of a
//! multistep rule are, and the time in the step at which they act is a matter of the rule's transfer. So they are
//! further columns, stage after stage. Forces of cells are resolved into the tyre's lateral waves, and those components
//! are further columns, too: the channels of a column are its stages, and of each of them the components.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::products;
use crate::numeric::transform_multiply_adds;
use crate::scene::TimeRule;
use crate::time_rule::Advance;

/// How the forces of a column are resolved across the strip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Across {
    /// One force, even over the width. Mean products of the stages' forces are stored, from which any velocity follows.
    #[default]
    Even,
    /// Lateral components. There would be too many products: the velocities or the power that they cause are stored
    /// instead.
    Resolved {
        /// Number of components of a force.
        components: usize,
        /// Number of values that are stored for each wavenumber at a bin.
        values: usize,
    },
}

/// Sizes of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentLayout {
    /// Elements N round the tyre; even.
    pub elements: usize,
    /// How far the tyre rolls in a step: by a q-th of an element, or by s elements.
    pub advance: Advance,
    /// Revolutions r of a segment.
    pub revolutions: usize,
    /// Columns of the contact window.
    pub columns: usize,
    /// Resolution of a column's forces across the strip.
    pub across: Across,
    /// Time rule of the run that found the forces.
    pub rule: TimeRule,
    /// Time step \[s\].
    pub time_step: f64,
    /// Substep of the segment's first step: how many steps ago the window last moved on by an element.
    pub phase: usize,
    /// Position of the window's first column at substep 0, from the axle \[m\].
    pub first_position: f64,
    /// Circumference L \[m\].
    pub circumference: f64,
}

/// A bin of the non-rotating frame that shares the transforms of a base bin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SharedBin {
    /// Number k of the bin.
    pub bin: usize,
    /// True if it takes the conjugate transforms.
    pub conjugate: bool,
}

impl SegmentLayout {
    /// Revolutions for segments of about `segment` seconds in a record of `steps` steps, `revolution` steps each;
    /// `None` if the record is shorter than a revolution.
    pub fn revolutions_for(segment: f64, revolution: u64, time_step: f64, steps: u64) -> Option<usize> {
        let fitting = steps / revolution;
        let wanted = (segment / (revolution as f64 * time_step)).round().clamp(1.0, 1e6) as u64;
        (fitting > 0).then(|| wanted.min(fitting) as usize)
    }

    /// Steps q per element.
    pub const fn substeps(&self) -> usize {
        self.advance.substeps
    }

    /// Number of steps K of a segment.
    pub fn length(&self) -> usize {
        self.revolutions * self.advance.steps(self.elements)
    }

    /// Number of steps from one segment to the next.
    pub fn hop(&self) -> usize {
        self.length() / 2
    }

    /// Number of steps K/q of a segment in which the window stands at one substep.
    pub fn base_length(&self) -> usize {
        self.length() / self.substeps()
    }

    /// Number of base bins, 0..=K/(2q).
    pub fn base_bins(&self) -> usize {
        self.base_length() / 2 + 1
    }

    /// Number of Fourier transforms per segment: over time for every place, over the columns for every base bin.
    pub fn transforms(&self) -> u64 {
        (self.places() + self.channels() * self.substeps() * self.base_bins()) as u64
    }

    /// Number of multiply-adds per segment: real transforms over time, complex ones over the columns, two for every
    /// mean product, or four for every channel of a velocity or power.
    pub fn multiply_adds(&self) -> f64 {
        let over_time = 0.5 * self.places() as f64 * transform_multiply_adds(self.base_length());
        let over_columns =
            (self.channels() * self.substeps() * self.base_bins()) as f64 * transform_multiply_adds(self.elements);
        let of_number = match self.across {
            Across::Even => 2,
            Across::Resolved { .. } => 4 * self.channels(),
        };
        over_time + over_columns + (of_number * self.bins() * self.row()) as f64
    }

    /// Number of bins of a one-sided spectrum, 0..=K/2.
    pub fn bins(&self) -> usize {
        self.length() / 2 + 1
    }

    /// Number of instants of a step, each with separate forces.
    pub fn stages(&self) -> usize {
        self.rule.nodes().len()
    }

    /// For each instant of a step the weight of its force, and the time relative to the step's end at which it acts
    /// \[s\].
    pub(in crate::response) fn actions(&self) -> Vec<[f64; 2]> {
        let Some(method) = self.rule.runge_kutta() else { return vec![[1.0, 0.0]] };
        let nodes = method.nodes.iter().zip(method.weights());
        nodes.map(|(node, weight)| [weight, (node - 1.0) * self.time_step]).collect()
    }

    /// Number of lateral components of the forces at an instant.
    pub fn components(&self) -> usize {
        match self.across {
            Across::Even => 1,
            Across::Resolved { components, .. } => components,
        }
    }

    /// Number of forces of a column in a step: the components of every stage.
    pub fn channels(&self) -> usize {
        self.stages() * self.components()
    }

    /// Number of forces of a step: the columns of every channel.
    pub fn width(&self) -> usize {
        self.channels() * self.columns
    }

    /// Number of places: pairs of a force of a step and a substep.
    pub fn places(&self) -> usize {
        self.width() * self.substeps()
    }

    /// Number of values that are stored for each bin: for every wavenumber the mean products of the stages' forces, or
    /// the velocities or the power of resolved forces.
    pub fn row(&self) -> usize {
        let values = match self.across {
            Across::Even => products::count(self.stages()),
            Across::Resolved { values, .. } => values,
        };
        values * self.wavenumbers()
    }

    /// Number of wavenumbers -N/2..=N/2. The two ends are the same sequence of elements; each counts half.
    pub fn wavenumbers(&self) -> usize {
        self.elements + 1
    }

    /// Wavenumber n of an index in 0..[`Self::wavenumbers`].
    pub fn wavenumber(&self, index: usize) -> i64 {
        index as i64 - self.elements as i64 / 2
    }

    /// Distance df of neighbouring bins \[Hz\].
    pub fn resolution(&self) -> f64 {
        1.0 / (self.length() as f64 * self.time_step)
    }

    /// Bins k = m K/q +- kappa within 0..=K/2 that share the transforms of the base bin kappa, rising; q of them at
    /// most, or one.
    pub(crate) fn shared_bins(&self, base: usize) -> impl Iterator<Item = SharedBin> + use<> {
        let (period, last) = (self.base_length(), self.length() / 2);
        let twice = base > 0 && 2 * base != period;
        (0..=self.substeps() / 2 + 1).flat_map(move |m| {
            let below = (twice && m > 0).then(|| SharedBin { bin: m * period - base, conjugate: true });
            let above = SharedBin { bin: m * period + base, conjugate: false };
            below.into_iter().chain([above]).filter(move |shared| shared.bin <= last)
        })
    }

    /// Most bins that share a base bin.
    pub fn most_shared(&self) -> usize {
        self.substeps()
    }

    /// Bin k' of the material frame, -K/2 < k' <= K/2, for the bin k and the wavenumber n of the non-rotating one.
    pub fn material_bin(&self, bin: usize, wavenumber: i64) -> i64 {
        let length = self.length() as i64;
        let shifted = (bin as i64 - wavenumber * self.revolutions as i64).rem_euclid(length);
        if 2 * shifted > length { shifted - length } else { shifted }
    }

    /// The same between the bins: frequency in the material frame \[Hz\] of a frequency in the non-rotating one.
    pub fn material_frequency(&self, frequency: f64, wavenumber: i64) -> f64 {
        let shifted = frequency - wavenumber as f64 * self.revolutions as f64 * self.resolution();
        shifted - (shifted * self.time_step).round() / self.time_step
    }

    /// Factor of a bin's power in a one-sided spectrum: 2, but 1 at 0 and at the Nyquist frequency.
    pub fn sides(&self, bin: usize) -> f64 {
        if bin == 0 || 2 * bin == self.length() { 1.0 } else { 2.0 }
    }

    /// Factor of a wavenumber's power: 1, but 1/2 at the two ends, which are the same wave.
    pub fn share(&self, index: usize) -> f64 {
        if index == 0 || index == self.elements { 0.5 } else { 1.0 }
    }

    /// Angular frequency of a bin of the material frame \[rad/s\].
    pub fn angular_frequency(&self, bin: usize) -> f64 {
        2.0 * PI * bin as f64 * self.resolution()
    }

    /// Substep of a step of a segment.
    pub fn phase_of(&self, step: usize) -> usize {
        (self.phase + step) % self.substeps()
    }

    /// Place of a force, counted channel after channel, at a step of a segment.
    pub fn place(&self, step: usize, force: usize) -> usize {
        force * self.substeps() + self.phase_of(step)
    }

    /// First step of a segment at a substep.
    pub fn first_step(&self, phase: usize) -> usize {
        (phase + self.substeps() - self.phase) % self.substeps()
    }

    /// exp(-2 pi i k l_p/K): the transform of a substep p begins with its first step l_p.
    pub(super) fn delay(&self, bin: usize, phase: usize) -> Complex64 {
        let turns = (bin * self.first_step(phase)) as f64 / self.length() as f64;
        Complex64::from_polar(1.0, -2.0 * PI * turns)
    }

    /// Weight of a step of a segment: the sine window, whose square and that of the neighbour segment add up to 1.
    pub fn weight(&self, step: usize) -> f64 {
        (PI * (step as f64 + 0.5) / self.length() as f64).sin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(crate) fn layout(elements: usize, advance: impl Into<Advance>, revolutions: usize) -> SegmentLayout {
        SegmentLayout {
            elements,
            advance: advance.into(),
            revolutions,
            columns: 5,
            across: Across::Even,
            rule: TimeRule::Bdf2,
            time_step: 1e-4,
            phase: 0,
            first_position: 0.0,
            circumference: 2.0,
        }
    }

    #[test]
    fn base_bins_serve_every_bin_once() {
        for (elements, substeps, revolutions) in
            [(16, 1, 1), (16, 1, 3), (16, 2, 1), (18, 2, 3), (16, 3, 2), (20, 4, 1), (18, 5, 1)]
        {
            let layout = layout(elements, substeps, revolutions);
            let mut found: Vec<usize> = Vec::new();
            for base in 0..layout.base_bins() {
                let bins: Vec<SharedBin> = layout.shared_bins(base).collect();
                assert!(bins.len() <= layout.most_shared() && bins.is_sorted_by_key(|shared| shared.bin), "{bins:?}");
                for shared in bins {
                    let period = layout.base_length();
                    let expected = if shared.conjugate { period - base } else { base };
                    assert_eq!(shared.bin % period, expected % period);
                    found.push(shared.bin);
                }
            }
            found.sort_unstable();
            assert!(found.into_iter().eq(0..layout.bins()), "q = {substeps}, r = {revolutions}");
        }
    }

    #[test]
    fn both_frames_have_the_same_bins() {
        let over_four = Advance::over(4);
        assert_eq!(layout(16, over_four, 3).material_bin(0, -5), 3, "15 bins on, of 12");
        let layout = layout(16, 2, 3);
        for bin in 0..layout.bins() {
            for index in 0..layout.wavenumbers() {
                let n = layout.wavenumber(index);
                let material = layout.material_bin(bin, n);
                assert!(2 * material.abs() <= layout.length() as i64);
                // The mirrored wave: a real field has both.
                let mirrored = layout.material_bin((layout.length() - bin) % layout.length(), -n);
                assert!(material == -mirrored || 2 * material.abs() == layout.length() as i64);
            }
        }
        assert_eq!(layout.material_bin(0, -2), 6, "a pattern at rest over the road passes an element at n V/L");
    }

    #[test]
    fn segments_are_whole_revolutions_that_fit() {
        assert_eq!(SegmentLayout::revolutions_for(0.5, 512, 0.0878 / 512.0, 100_000), Some(6));
        assert_eq!(SegmentLayout::revolutions_for(0.01, 512, 0.0878 / 512.0, 100_000), Some(1));
        assert_eq!(SegmentLayout::revolutions_for(0.5, 512, 0.0878 / 512.0, 1500), Some(2));
        assert_eq!(SegmentLayout::revolutions_for(0.5, 512, 0.0878 / 512.0, 511), None);
        let layout = layout(16, 3, 1);
        for step in 0..layout.hop() {
            let squares = layout.weight(step).powi(2) + layout.weight(step + layout.hop()).powi(2);
            assert!((squares - 1.0).abs() < 1e-14);
        }
    }
}

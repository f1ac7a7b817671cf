//! Squeeze of blocks: sound of the volume that they displace into the voids beside them.
//!
//! ```text
//! p = i w rho sum_b i w c_b F_b (mean of G over the voids beside block b - mean of G over block b)
//! ```
//!
//! Blocks are material: i w is the rate that the material sees, d(c_b F_b)/dt of one block that goes by, and the means
//! of G move with it. On the cells of the tread the volumes are a motion like any other, independent of the tyre's
//! response: their waves round the tyre meet G as those of the surface do, with the rate w - n Omega of wave n.

use crate::contact::geometry::Geometry;
use crate::effects::error::RunError;
use crate::numeric::in_parallel;
use crate::plan::Plan;
use crate::plan::decisions::{Decisions, tread_blocks, tread_map};
use crate::plan::sound::{SOUND_FADE, SOUND_SEGMENT, Sound};
use crate::response::pressure::{PressureModel, PressureStream, PressureTransfers};
use crate::response::vibration::{Across, SegmentLayout};
use crate::response::{PowerSpectrum, SpectrumAccumulator, SqueezedVolumes};
use crate::scene::Scene;
use crate::storage::state::evolving;
use crate::tyre::tread_pattern::squeeze::Squeeze;

/// Number of parts of the pressure: due to vibration, and due to squeeze.
pub(super) const PARTS: usize = 2;

/// Blocks of a scene's tread with the voids beside them; `None` where none yields separately.
pub(super) fn found_blocks(scene: &Scene, decisions: &Decisions) -> Option<Squeeze> {
    let map = tread_map(scene, decisions)?.ok()?;
    let blocks = tread_blocks(scene, &map)?;
    Some(Squeeze::new(&blocks, map.across))
}

/// Layout of the volumes, in windows wider than the sound's by `margin` columns at either end.
pub(super) fn layout(sound: &SegmentLayout, squeeze: &Squeeze, margin: usize) -> SegmentLayout {
    let element = sound.circumference / sound.elements as f64;
    SegmentLayout {
        columns: sound.columns + 2 * margin,
        first_position: sound.first_position - margin as f64 * element,
        across: Across::Resolved { components: squeeze.across, values: 0 },
        ..*sound
    }
}

/// From the volumes of a run's blocks to pressures.
pub(super) struct SqueezeStream {
    volumes: SqueezedVolumes,
    /// First step after the warm-up.
    first_step: u64,
    pub(super) stream: PressureStream,
    /// By place and point, spectra of the pressure due to vibration and due to squeeze.
    pub(super) parts: Vec<[SpectrumAccumulator; PARTS]>,
}

impl SqueezeStream {
    /// With the transfers of the forces, and at most `most_waiting` blocks that wait; `None` where nothing is squeezed.
    ///
    /// # Errors
    /// Samples that are too few for a spectrum.
    pub(super) fn new(
        plan: &Plan,
        sound: &Sound,
        forces: &Geometry,
        transfers: &PressureTransfers,
        samples: usize,
        most_waiting: usize,
    ) -> Result<Option<Self>, RunError> {
        if !sound.squeezes {
            return Ok(None);
        }
        let Some(squeeze) = found_blocks(&plan.scene, &plan.decisions) else { return Ok(None) };
        let PressureTransfers { model, greens } = transfers;
        let margin = SqueezedVolumes::margin(&squeeze, forces.columns);
        let (width, across) = (model.contact_width, squeeze.across);
        let model = PressureModel {
            layout: layout(&model.layout, &squeeze, margin),
            tangential: None,
            strips: Some((0..=across).map(|end| width * (end as f64 / across as f64 - 0.5)).collect()),
            ..model.clone()
        };
        let transfers = PressureTransfers { model, greens: greens.clone() };
        let stream = PressureStream::new(transfers, plan.steps - plan.warm_up_steps, most_waiting);
        let spectrum = || SpectrumAccumulator::faded(samples, plan.time_step, SOUND_SEGMENT, SOUND_FADE);
        let parts =
            (0..sound.path.spectra()).map(|_| Ok([spectrum()?, spectrum()?])).collect::<Result<_, RunError>>()?;
        let volumes = SqueezedVolumes::new(squeeze, forces);
        debug_assert_eq!(volumes.window().columns, stream.columns());
        Ok(Some(Self { volumes, first_step: plan.warm_up_steps, stream, parts }))
    }

    /// Takes the forces of a step after the warm-up \[N\], stage by stage and cell by cell.
    pub(super) fn push(&mut self, forces: &[f64]) {
        let step = self.first_step + self.stream.steps();
        self.stream.push(self.volumes.of(step, forces));
    }

    /// The same for a segment of the run that begins `from` steps after the first one; it has no spectra.
    pub(super) fn of_segment(&self, from: u64) -> Self {
        let (volumes, stream) = (self.volumes.clone(), self.stream.of_segment());
        Self { volumes, first_step: self.first_step + from, stream, parts: Vec::new() }
    }

    /// Spectra at all points due to vibration, and due to squeeze, averaged over places.
    pub(super) fn spectra(&self, points: usize, valid_to: f64) -> Result<[Vec<PowerSpectrum>; PARTS], RunError> {
        let of = |part: usize| -> Result<Vec<PowerSpectrum>, RunError> {
            let finished = |parts: &[SpectrumAccumulator; PARTS]| Ok(parts[part].clone().finish()?.valid_to(valid_to));
            in_parallel::map(&self.parts, finished).into_iter().collect()
        };
        Ok([PowerSpectrum::means(of(0)?, points), PowerSpectrum::means(of(1)?, points)])
    }
}

evolving!(SqueezeStream: stream, parts);

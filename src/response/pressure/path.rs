//! Transfer path from the contact to the points of all receivers, as it is known before anything is solved: the body
//! and its flanks, the waves that radiate, the air, and the delays of propagation.

use std::ops::Range;
use std::sync::Arc;

use super::model::PressureModel;
use crate::numeric::SplitRule;
use crate::radiation::gap::patch::GapChannel;
use crate::radiation::transfer::contact_distance;
use crate::radiation::{
    Air, Flank, FrequencyRange, MeshResolution, ParityBlock, RadiatingBody, RadiationCost, SetUpCost, TransferGrid,
    TransferProblem, draft,
};
use crate::response::vibration::{Across, SegmentLayout};
use crate::scene::{Radiation, RadiationQuality, Tyre};
use crate::tyre::influence::{SurfaceWaves, Waves};

/// Cost of a draft's four monopoles in kernels of boundary elements.
const DRAFT_KERNELS: f64 = 30.0;

/// Transfer path of a run's sound.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferPath {
    /// Settings, with a highest frequency that the time step can represent.
    pub radiation: Radiation,
    /// Air of the run.
    pub air: Air,
    /// Positions of the points of all receivers \[m\], in the frame of [`crate::scene::Receiver`].
    pub positions: Vec<[f64; 3]>,
    /// By receiver, its points.
    pub receivers: Vec<Range<usize>>,
    /// Blocks of the forces; columns, phase and first position are set by the run.
    pub layout: SegmentLayout,
    /// Number of lateral waves, from the lowest on: of those that a strip excites, or of all.
    pub lateral: usize,
    /// True if there are tangential forces.
    pub has_tractions: bool,
    /// Radius of the bead \[m\], where the sidewalls radiate.
    pub bead: Option<f64>,
    /// Grooves with air through the patch; empty where it is sealed.
    pub channels: Vec<GapChannel>,
    /// Number of places of the run whose voids between tread and road are open, or 1.
    pub places: usize,
}

impl TransferPath {
    /// Cells round the tyre, and points across half of it, on which G is known.
    pub(crate) const GRID: TransferGrid = TransferGrid { around: 512, across: 4 };

    /// Number of points of all receivers.
    pub(crate) fn points(&self) -> usize {
        self.positions.len()
    }

    /// Number of points whose pressures are computed: those of all receivers, for each place, and one in the middle of
    /// each groove.
    pub(crate) fn streamed(&self) -> usize {
        self.spectra() + self.channels.len()
    }

    /// Number of spectra of pressures: of all points, place by place.
    pub(crate) fn spectra(&self) -> usize {
        self.points() * self.places
    }

    /// Index of the spectrum for the pressures of a streamed point; `None` for one in a groove.
    pub(crate) fn spectrum_of(&self, streamed: usize) -> Option<usize> {
        let others = self.points() + self.channels.len();
        (streamed < self.points()).then_some(streamed).or_else(|| Some(streamed.checked_sub(others)? + self.points()))
    }

    /// Transfers from a body to all points, to be solved for.
    pub(crate) fn problem<'a>(&'a self, body: &'a RadiatingBody, memory_limit: u64) -> TransferProblem<'a> {
        TransferProblem {
            body,
            receivers: &self.positions,
            grid: Self::GRID,
            flank: self.flank(body),
            resolution: MeshResolution::of(self.radiation.nodes_per_wavelength),
            // Forces on cells are not even across.
            blocks: match self.layout.across {
                Across::Even => &ParityBlock::EVEN_ACROSS,
                Across::Resolved { .. } => &ParityBlock::ALL,
            },
            memory_limit,
        }
    }

    /// Propagation delays from a body's contact to all points: the whole time steps, by which their pressures are
    /// early, and the rest \[s\].
    pub(crate) fn delays(&self, body: &RadiatingBody) -> (Vec<u64>, Vec<f64>) {
        let step = self.layout.time_step;
        let late = |&position: &[f64; 3]| contact_distance(body, position) / self.air.sound_speed;
        let split = |late: f64| ((late / step).floor() as u64, late - (late / step).floor() * step);
        self.positions.iter().map(late).map(split).unzip()
    }

    /// Part of a body that radiates in addition to its tread.
    pub(crate) fn flank(&self, body: &RadiatingBody) -> Option<Flank> {
        Flank::new(body, self.bead?)
    }

    /// Number of G's integrals per wavenumber.
    pub(crate) fn integrals(&self) -> usize {
        let rings = if self.bead.is_some() { SplitRule::POINTS } else { 0 };
        let driven = match self.layout.across {
            Across::Even => self.lateral,
            Across::Resolved { components, .. } => components,
        };
        PressureModel::integrals(self.radiation.air, PressureModel::shape_count(self.layout.across, driven, rings))
    }

    /// Lateral numbers of the waves that radiate.
    pub(crate) fn lateral_numbers(&self, tyre: &Tyre) -> Vec<usize> {
        let waves = Waves::new(tyre);
        match self.layout.across {
            Across::Even => waves.lateral_numbers().take(self.lateral).collect(),
            Across::Resolved { .. } => (waves.first_lateral_number()..).take(self.lateral).collect(),
        }
    }

    /// Model of the pressures without delays, for normal forces on the tyre as it is.
    pub(crate) fn model(&self, waves: Arc<SurfaceWaves>, contact_width: f64) -> PressureModel {
        PressureModel {
            layout: self.layout,
            waves,
            tangential: None,
            scale: 1.0,
            contact_width,
            density: self.air.density,
            air: self.radiation.air,
            highest: self.radiation.fmax,
            delays: Vec::new(),
            strips: None,
        }
    }

    pub(crate) fn range(&self) -> FrequencyRange {
        FrequencyRange::up_to(self.radiation.fmax, self.radiation.frequency_tolerance, self.air.sound_speed)
    }

    /// Expected cost of the transfers from a body whose frequencies are not all `stored` \[Hz\]; `None` for positions
    /// that the run will refuse.
    pub(crate) fn expected(&self, body: &RadiatingBody, memory_limit: u64, stored: &[f64]) -> Option<SetUpCost> {
        let (problem, range) = (self.problem(body, memory_limit), self.range());
        if self.radiation.quality == RadiationQuality::Draft {
            let values = (self.points() * problem.values()) as u64;
            let frequencies = draft::frequencies(&range).len() as u64;
            let far_evaluations = DRAFT_KERNELS * (values * frequencies) as f64;
            let cost = RadiationCost { far_evaluations, ..RadiationCost::default() };
            return Some(SetUpCost { frequencies: 0, cost, bytes_stored: 8 * values * frequencies });
        }
        SetUpCost::expected(&problem, &range, stored).ok()
    }
}

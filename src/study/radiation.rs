//! Sound radiation of a scene's tyre: transfer functions from its tread to some receivers, amplification by the horn,
//! directivity, and the cost of computing them.
//!
//! Horn, transfers and directivity are for a small piece of the tread in front of the patch, in the middle of the tyre:
//! by reciprocity the sound of its motion at a receiver equals the pressure at it due to a source at the receiver.
//! Shares of waves and of the circumference are for the whole tread, as a force in the middle of the patch moves it
//! while it rolls.

use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::numeric::{double, in_parallel};
use crate::plan::Plan;
use crate::radiation::{RadiatingBody, RadiationCost, RadiationError, SurfaceTransfer, TransferProblem};
use crate::response::pressure::set_up::WAVES;
use crate::response::pressure::{PressureModel, PressureShares, SurfaceGreen, TransferPath};
use crate::scene::Scene;
use crate::sound::{Side, receivers};
use crate::tyre::influence::SurfaceWaves;
use crate::tyre::influence::mobility::frequencies;

/// Distance of the piece of tread from the patch's edge, ahead of it \[m\].
pub(crate) const AHEAD: f64 = 0.015;
/// Radius and height of the circle of the directivity \[m\].
pub(crate) const CIRCLE: [f64; 2] = [2.0, 0.3];

/// Lowest frequency \[Hz\].
pub(crate) const LOWEST: f64 = 100.0;
/// Frequencies of the directivity \[Hz\].
pub(crate) const DIRECTIVITY: [f64; 3] = [500.0, 1000.0, 2000.0];

/// `points` frequencies from [`LOWEST`] to the highest \[Hz\], and those of the directivity up to it.
pub(crate) fn asked_frequencies(highest: f64, points: u32) -> Vec<f64> {
    let mut asked = frequencies(LOWEST, highest, points);
    asked.extend(DIRECTIVITY.iter().filter(|&&frequency| frequency <= highest));
    asked.sort_by(f64::total_cmp);
    asked.dedup_by(|a, b| (*a - *b).abs() < 1e-9 * *a);
    asked
}

/// Names and positions of the receivers \[m\], for a tyre of the given width \[m\].
pub(crate) fn named_receivers(width: f64) -> [(&'static str, [f64; 3]); 3] {
    let [front, _] = receivers::close_proximity(width, Side::Left);
    let height = receivers::COAST_BY_HEIGHT;
    [
        ("in plane, 7.5 m ahead, 0.3 m high", [7.5, 0.0, 0.3]),
        ("cpx, front", front),
        ("coast-by, beside", [0.0, receivers::COAST_BY_DISTANCE, height]),
    ]
}

/// Findings at a frequency.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AtFrequency {
    /// \[Hz\]
    pub frequency: f64,
    /// |G| from the piece of tread, by receiver \[1/m\].
    pub transfers: Vec<f64>,
    /// |G| over that without the tyre, by receiver \[dB\].
    pub horn: Vec<f64>,
    /// Shares of the pressure by the tread's motion under a unit force in the middle of the patch, by receiver.
    pub shares: Vec<PressureShares>,
    /// |G| around the circle \[1/m\], from straight ahead counted towards the left.
    pub circle: Vec<f64>,
    /// Number of unknowns of a block.
    pub unknowns: usize,
    /// Reciprocal condition number, the worst of the blocks.
    pub reciprocal_condition: f64,
    /// Time of assembly and of factorisation \[s\].
    pub seconds: [f64; 2],
    /// Real operations of the factorisations.
    pub factor_operations: f64,
}

/// A tyre that stands on a road, as a radiating body.
#[derive(Clone, Debug)]
pub(crate) struct Radiator {
    body: RadiatingBody,
    /// Path to the named receivers, then to the circle.
    path: TransferPath,
    /// Width of the strip, and over the shoulders \[m\].
    widths: [f64; 2],
    waves: Arc<SurfaceWaves>,
    memory_limit: u64,
}

impl Radiator {
    /// The tyre of a planned scene with a patch of length `at_rest` \[m\].
    ///
    /// # Errors
    /// A body or air that cannot be.
    pub(crate) fn new(scene: &Scene, plan: &Plan, at_rest: f64) -> Result<Self, RadiationError> {
        let (radiation, tyre) = (&scene.radiation, &plan.decisions.tyre);
        let body = plan.radiating_body(radiation, at_rest)?;
        let [radius, height] = CIRCLE;
        let width = tyre.width + 2.0 * radiation.shoulder;
        let named = named_receivers(width).map(|(_, position)| position);
        let positions: Vec<[f64; 3]> =
            named.into_iter().chain(receivers::circle(radius, height, receivers::CIRCLE_POSITIONS)).collect();
        let all = std::iter::once(0..positions.len()).collect();
        let followed = (plan.sound_layout(), radiation.lateral_waves);
        let path = plan.transfer_path(tyre, radiation.clone(), (positions, all), followed);
        let path = path.ok_or(RadiationError::NotPositive { what: "the speed of sound", value: 0.0 })?;
        let (around, highest) = (TransferPath::GRID.around / 2, 0.5 / path.layout.time_step);
        let flank = path.flank(&body);
        let rule = flank.as_ref().map(|flank| &flank.rule);
        let waves = SurfaceWaves::with_flank(tyre, around, path.lateral_numbers(tyre), [highest, WAVES], rule);
        let (widths, memory_limit) = ([tyre.contact_width, width], scene.numerics.memory_bytes());
        Ok(Self { body, path, widths, waves: Arc::new(waves), memory_limit })
    }

    /// Length of the patch \[m\].
    pub(crate) fn patch_length(&self) -> f64 {
        2.0 * self.body.half_patch()
    }

    /// Width over the shoulders \[m\].
    pub(crate) fn width(&self) -> f64 {
        self.widths[1]
    }

    /// True if shoulders and sides radiate.
    pub(crate) fn hears_sides(&self) -> bool {
        self.path.flank(&self.body).is_some()
    }

    /// Wavelength of sound in air at a frequency \[Hz\], in m.
    pub(crate) fn wavelength(&self, frequency: f64) -> f64 {
        self.path.air.sound_speed / frequency
    }

    /// Expected cost at a frequency \[Hz\].
    ///
    /// # Errors
    /// As [`RadiationCost::expected`].
    pub(crate) fn cost(&self, frequency: f64) -> Result<RadiationCost, RadiationError> {
        let wavenumber = TAU * frequency / self.path.air.sound_speed;
        let TransferProblem { resolution, blocks, .. } = self.path.problem(&self.body, self.memory_limit);
        RadiationCost::expected(&self.body, wavenumber, wavenumber, &resolution, blocks)
    }

    /// Pressure model of the rolling tyre, up to half of its sampling rate.
    fn model(&self) -> PressureModel {
        let model = self.path.model(Arc::clone(&self.waves), self.widths[0]);
        PressureModel { highest: f64::INFINITY, ..model }
    }

    /// Computes everything at each frequency \[Hz\]; `done` is called after each.
    ///
    /// # Errors
    /// As [`TransferProblem::solve`]; [`RadiationError::Interrupted`] once `stop` is set.
    pub(crate) fn at(
        &self,
        frequencies: &[f64],
        stop: &AtomicBool,
        done: &(dyn Fn() + Sync),
    ) -> Result<Vec<AtFrequency>, RadiationError> {
        let named = named_receivers(self.width()).len();
        let problem = self.path.problem(&self.body, self.memory_limit);
        problem.check()?;
        let edge = (self.body.half_patch() / self.body.radius()).asin() + AHEAD / self.body.radius();
        let cell = (edge / TAU * problem.grid.around as f64) as usize;
        let strength = |transfer: &SurfaceTransfer| double(transfer.values[transfer.index(0, 0, cell)]).norm();
        let one = |&frequency: &f64| {
            let shares = |transfer: &SurfaceTransfer| {
                let green = SurfaceGreen::of(&self.body, [(frequency, transfer.clone())]);
                PressureShares::at(&self.model(), &green, 0)
            };
            let wavenumber = TAU * frequency / self.path.air.sound_speed;
            let (transfers, report) = problem.solve_unless(wavenumber, &|| stop.load(Ordering::Relaxed))?;
            done();
            Ok(AtFrequency {
                frequency,
                transfers: transfers[..named].iter().map(strength).collect(),
                horn: transfers[..named].iter().map(|found| found.horn(&self.body, 0, 0, cell)).collect(),
                shares: transfers[..named].iter().map(shares).collect(),
                circle: transfers[named..].iter().map(strength).collect(),
                unknowns: report.unknowns,
                reciprocal_condition: report.reciprocal_condition,
                seconds: [report.assembly_seconds, report.factor_seconds],
                factor_operations: report.factor_operations,
            })
        };
        in_parallel::map(frequencies, one).into_iter().collect()
    }
}

//! Corrections of a run's levels to a finer mesh, for all of its signals.

use serde::{Deserialize, Serialize};

use super::front::STATED_FROM;
use crate::response::MeshCorrection;
use crate::results::summary::FinerMesh;

/// Largest part of the longest run over which the meshes are compared: half of what the finer mesh alone would take,
/// if its steps over the same road take five times as long.
const SHARE: f64 = 0.25;
/// Factor within which a standard error counts as reached: it is itself an estimate.
const REACHED: f64 = 1.1;

/// Corrections of the levels of all signals of a run.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct MeshCorrections {
    /// Correction of the total force's levels.
    pub force: MeshCorrection,
    /// Corrections at the receivers, in their order.
    pub receivers: Vec<MeshCorrection>,
    /// Finer mesh, and the time over which both were compared.
    pub mesh: FinerMesh,
}

impl MeshCorrections {
    /// Time over which the meshes have to be compared \[s\] for the standard error wanted up to a frequency \[Hz\], by
    /// a run of at most `longest`.
    pub(crate) fn needed_comparison(&self, highest: f64, longest: f64) -> f64 {
        let each =
            self.signals().map(|of| of.needed_comparison(self.mesh.standard_error, [STATED_FROM, highest], longest));
        each.fold(self.mesh.seconds, f64::max).min((SHARE * longest).max(self.mesh.seconds))
    }

    /// Time of the run \[s\] for that error, at most `longest`.
    pub(crate) fn needed_run(&self, highest: f64, longest: f64) -> f64 {
        let each = self.signals().map(|of| of.needed_run(self.mesh.standard_error, [STATED_FROM, highest], longest));
        each.fold(0.0, f64::max)
    }

    fn signals(&self) -> impl Iterator<Item = &MeshCorrection> {
        std::iter::once(&self.force).chain(&self.receivers)
    }

    /// Warning if a run of so many seconds misses the standard error wanted up to a frequency \[Hz\].
    pub(crate) fn missed(&self, highest: f64, seconds: f64) -> Option<String> {
        let each = self.signals().filter_map(|of| of.largest_error([STATED_FROM, highest], seconds));
        let (band, error) = each.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (error > REACHED * self.mesh.standard_error).then(|| {
            format!(
                "outputs.levels.standard_error = {} dB is missed at {} Hz: {error:.2} dB; a longer rolling.duration \
                 lowers it",
                self.mesh.standard_error,
                band.nominal_frequency()
            )
        })
    }
}

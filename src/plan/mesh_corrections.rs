//! Corrections of a run's levels to a finer mesh, for all of its signals.

use serde::{Deserialize, Serialize};

use super::front::STATED_FROM;
use crate::response::MeshCorrection;

/// Factor within which a standard error counts as reached: it is itself an estimate.
const REACHED: f64 = 1.1;

/// Corrections of the levels of all signals of a run.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct MeshCorrections {
    /// Correction of the total force's levels.
    pub force: MeshCorrection,
    /// Corrections at the receivers, in their order.
    pub receivers: Vec<MeshCorrection>,
    /// Elements of the run and of the finer mesh.
    pub elements: [usize; 2],
    /// Time over which both were compared \[s\].
    pub seconds: f64,
    /// Standard error wanted \[dB\].
    pub standard_error: f64,
}

impl MeshCorrections {
    /// Time over which the meshes have to be compared, and of the run \[s\], for the standard error wanted up to a
    /// frequency \[Hz\]; at most `longest`.
    pub(crate) fn needed(&self, highest: f64, longest: f64) -> [f64; 2] {
        let all = std::iter::once(&self.force).chain(&self.receivers);
        let each = all.map(|signal| signal.needed(self.standard_error, [STATED_FROM, highest], longest));
        each.fold([0.0; 2], |[short, long], [of_short, of_long]| [short.max(of_short), long.max(of_long)])
    }

    /// Warning if a run of so many seconds misses the standard error wanted up to a frequency \[Hz\].
    pub(crate) fn missed(&self, highest: f64, seconds: f64) -> Option<String> {
        let all = std::iter::once(&self.force).chain(&self.receivers);
        let each = all.filter_map(|signal| signal.largest_error([STATED_FROM, highest], seconds));
        let (band, error) = each.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (error > REACHED * self.standard_error).then(|| {
            format!(
                "outputs.levels.standard_error = {} dB is missed at {} Hz: {error:.2} dB; a longer rolling.duration \
                 lowers it",
                self.standard_error,
                band.nominal_frequency()
            )
        })
    }
}

//! Parts of the library for its benchmarks and for the tests of the folder `tests`, which are separate programs. Not
//! part of the public interface: anything here may change or go without notice.

use clap::CommandFactory as _;
use serde::Serialize;

use crate::cli::CommandLine;
use crate::effects::EFFECTS;
use crate::plan::Plan;
use crate::report::Stored;
use crate::results::ContactQuality;
use crate::road::RoadDescription;
use crate::run::{Simulation, VibrationResults};

pub use crate::contact::ContactError;
pub use crate::contact::axle::{AxleHeight, LoadControl, MovingAxle, SprungMass};
pub use crate::contact::cells::InstantCells;
pub use crate::contact::cells::blocks::BlockTerm;
pub use crate::contact::cells::direct::DirectCellHistory;
pub use crate::contact::cells::history::{FewerPoles, RingParts, WaveHistory, fewer_poles, first_influences};
pub use crate::contact::cells::search::CellSearch;
pub use crate::contact::cells::wave_transform::{WaveNumber, WaveTransform};
pub use crate::contact::cells::zone::CellHistory;
pub use crate::contact::complementarity::active_set::ActiveSet;
pub use crate::contact::complementarity::ldlt::Ldlt;
pub use crate::contact::complementarity::{FactorCache, FactorCounts, LINE, SliceLaw, add_to_diagonal, packed_length};
pub use crate::contact::footprint::TangentialPart;
pub use crate::contact::geometry::Geometry;
pub use crate::contact::history::{DirectHistory, ForceHistory, INSTANTS, LagKernel, ModalHistory, SinglePrecision};
pub use crate::contact::kernel::{ContactKernel, EqualBedding};
pub use crate::contact::local_compliance::formula::tread_modulus;
pub use crate::contact::local_compliance::local_compliance;
pub use crate::contact::march::March;
pub use crate::contact::pressed::flat_tread::line_influence;
pub use crate::contact::pressed::strip::PressedRoad;
pub use crate::contact::stability::unstable_zero;
pub use crate::contact::static_contact::{StaticContact, StaticTyre};
pub use crate::contact::windows::add_windows;
pub use crate::counters::peak::{MachinePeak, instruction_set, multiply_add_rate};
pub use crate::counters::process::cpu_time;
use crate::effects::stored::Spectrum as StoredSpectrum;
pub use crate::effects::vibration::VibrationObserver;
pub use crate::effects::{channel, channels};
pub use crate::half_space::line::{GrowingContact, LineInfluence};
pub use crate::half_space::love::displacement as love_displacement;
pub use crate::half_space::rough::Convolution;
pub use crate::numeric::complex_field::double;
pub use crate::numeric::transform_length::transform_length;
pub use crate::numeric::{Aligned, Ring};
pub use crate::performance::changes::{differences, read_accepted};
pub use crate::performance::measure::{measure as measure_performance, value as performance_value};
pub use crate::performance::record::PerformanceRecord;
pub use crate::performance::workload::Workload;
pub use crate::plan::models::fetch as fetch_model;
pub use crate::plan::resolution::fit_options;
use crate::plan::settle::PlannedSetting;
pub use crate::plan::{Decisions, WorkUnit};
pub use crate::planning::rows as plan_rows;
pub use crate::radiation::cases::evaluate as radiation_cases;
pub use crate::radiation::draft::{DraftErrors, transfers_at as draft_transfers_at};
pub use crate::radiation::solve::{Drive, RadiationProblem};
pub use crate::radiation::{
    BodyShape, MeshResolution, ParityBlock, RadiatingBody, SurfaceTransfer, TransferGrid, TransferProblem, Vector,
};
pub use crate::report::compare::Comparison;
pub use crate::report::export::{MAT_HEAD, PYTHON, UFF_HEAD, VTK_HEAD};
pub use crate::report::page::PAGE_HEAD;
pub use crate::report::validation::{MARKERS as VALIDATION_MARKERS, markdown as validation_markdown};
pub use crate::response::level_errors::LevelErrors;
pub use crate::response::slice_errors::SliceErrors;
pub use crate::response::vibration::accumulator::VibrationAccumulator;
pub use crate::response::vibration::transfer::symbols;
pub use crate::response::vibration::{
    Across, SegmentLayout, SpectraRequest, TransferKind, TyreResponse, VelocityTable, VibrationField, field_spectra,
    point_spectrum,
};
pub use crate::results::checkpoint::read as read_checkpoint;
pub use crate::results::cost::{RunCost, cost_table};
pub use crate::results::npy::{ArrayRow, NpyWriter};
pub use crate::results::plots::{ThirdOctavePlot, four_digits};
pub use crate::results::spectra::read_force_levels;
pub use crate::results::table::StoredTable;
pub use crate::results::tread_pattern::{pitch_spectrum, tread_picture};
pub use crate::results::vibration::vibration_levels_csv;
pub use crate::road::maker::StripCurves;
pub use crate::road::resample::Resampled;
pub use crate::road::sources::height_map::RoadHeightMap;
pub use crate::road::sources::made::RingSpectrum;
pub use crate::road::sources::made::target::TargetSpectrum;
pub use crate::road::strip::RoadStrip;
pub use crate::run::prepare::{Prepared, checked, prepare};
pub use crate::scene::schema::{Section, sections};
pub use crate::sidewall::table::Sidewall;
pub use crate::sidewall::{Arc, EdgeImpedance, Relaxation};
pub use crate::sound::wav::full_scale_of;
pub use crate::storage::cache::Cache;
pub use crate::storage::state::SavedState;
pub use crate::storage::{Cached, Unusable};
pub use crate::study::accuracy::{Study, StudyOptions, StudyPoint, Sweep, front, study};
pub use crate::study::fit_tyre::measured::MeasuredPoint;
pub use crate::study::fit_tyre::{
    BOUND as FIT_TYRE_BOUND, Estimate, FitTyreError, Parameter, TyreFit, Uncertainty, fit as fit_tyre,
    measured as measured_mobility,
};
pub use crate::study::loads::LoadedTyre;
pub use crate::study::validation::{
    Lacks, Measured as ValidationMeasured, Published as ValidationPublished, StandingTyre, rows as validation_rows,
};
pub use crate::test_models::cells::{RoughRoad, instant_cells};
pub use crate::test_models::{
    CHIP_SEAL, CIRCUMFERENCE, COBBLES, CONTACT_WIDTH, add, edit, grid_road, implausible, on_springs, plate_scene,
    plate_tyre, reference, replaced, scene, scene_text, transforms, wide_tyre, with_all_terms, with_road, without,
};
pub use crate::time_rule::{Advance, TimeRule};
pub use crate::tyre::critical_speed::limit as critical_speed_limit;
pub use crate::tyre::influence::cell_sums::CellSums;
pub use crate::tyre::influence::cell_waves::{CellTruncation, WaveBand};
pub use crate::tyre::influence::convolution_quadrature::Weights;
pub use crate::tyre::influence::mobility::driving_point;
pub use crate::tyre::influence::{COMPONENTS, CellGrid, CellInfluence, traction_shape};
pub use crate::tyre::layers::compliance::Matrix3;
pub use crate::tyre::layers::curved::{CurvedStack, FINE_STEP, STEP, air_stiffness, growth};
pub use crate::tyre::layers::cylinder::Cylinder;
pub use crate::tyre::layers::rotation::Rotation;
pub use crate::tyre::layers::{cases, material, operations};
pub use crate::tyre::modes::{Mode, Motion, modes, modes_of, radial_compliance};
pub use crate::tyre::poles::cache::{fetch as fetch_from, key as pole_key};
pub use crate::tyre::poles::cells::{CellFitOptions, fit_cells};
pub use crate::tyre::poles::fit::{FitOptions, fit};
pub use crate::tyre::poles::model::RationalModel;
pub use crate::tyre::poles::pole_model::PoleModel;
pub use crate::tyre::poles::{Direction, FitError, fit_unless_stopped};
pub use crate::tyre::slowest_wave::slowest_wave_below;
pub use crate::tyre::tread_pattern::blocks::{NO_BLOCK, TreadBlock, TreadBlocks};

/// The decisions of a plan.
pub fn decisions(plan: &Plan) -> &Decisions {
    &plan.decisions
}

/// The settings that a plan chose.
pub fn choices(plan: &Plan) -> &[PlannedSetting] {
    &plan.choices
}

/// The errors of slices that a plan states.
pub fn slice_errors(plan: &Plan) -> Option<&SliceErrors> {
    plan.slice_errors.as_ref()
}

/// The errors of slices that a run reports.
pub fn reported_slice_errors(contact: &ContactQuality) -> Option<&SliceErrors> {
    contact.slices.as_ref()
}

/// The contact of a run, from step to step.
pub fn march(run: &Simulation) -> &March {
    &run.prepared.march
}

/// The same, to be changed.
pub fn march_mut(run: &mut Simulation) -> &mut March {
    &mut run.prepared.march
}

/// The heights \[m\] of a described road that are drawn.
pub fn sampled_heights(road: &RoadDescription) -> &[f64] {
    &road.sample.heights
}

/// The spectra of stored results.
pub fn stored_spectra(results: &Stored) -> &[StoredSpectrum] {
    &results.spectra
}

/// The vibration's part of a run's summary.
pub fn vibration_summary(vibration: &VibrationResults) -> &impl Serialize {
    &vibration.summary
}

/// The command line of the program.
pub fn program() -> clap::Command {
    CommandLine::command()
}

/// The number of effects.
pub fn number_of_effects() -> usize {
    EFFECTS.len()
}

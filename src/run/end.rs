//! End of a run: files and findings of its effects, and the summary.

use crate::counters::{Meter, Stage};
use crate::effects::{Found, RunError};
use crate::results::files::ResultFiles;
use crate::results::summary::{ContactQuality, LoadResult, Outcome, RunCost, Summary};
use crate::run::energy::impossible_energy;
use crate::run::simulation::Simulation;
use crate::scene::LoadedScene;

/// Findings of a run's effects, complete or not; those of a complete run also write their files.
///
/// # Errors
/// Errors of the files and pictures.
pub(crate) fn finish(run: &mut Simulation, files: &dyn ResultFiles, is_complete: bool) -> Result<Found, RunError> {
    let mut found = run.findings();
    if is_complete {
        let open = run.meter.open();
        run.write(files, &mut found)?;
        run.meter.close(open, Stage::Response);
    }
    Ok(found)
}

/// Summary of a run that has ended, with its effects' findings.
///
/// # Errors
/// Settings that JSON cannot hold.
pub(crate) fn summary(
    run: &Simulation,
    loaded: &LoadedScene,
    found: Found,
    cost: impl FnOnce(&Meter) -> RunCost,
) -> Result<Summary, RunError> {
    let (prepared, steps) = (&run.prepared, run.next_step());
    let march = &prepared.march;
    let (totals, counts) = (march.totals(), march.search_counts());
    let mut summary = Summary::begun(&loaded.title(), loaded.settings()?, cost(&run.meter));
    (summary.vibration, summary.sound) = (found.vibration, found.sound);
    let load = loaded.scene.rolling.axle.load().zip(found.outcome.mean_force).map(|((wanted, tolerance), mean)| {
        let relative_error = (mean - wanted) / wanted;
        LoadResult { wanted, relative_error, tolerance, met: relative_error.abs() <= tolerance }
    });
    summary.outcome = Outcome {
        steps,
        time_step: run.time_step(),
        simulated_time: steps as f64 * run.time_step(),
        indentation: Some(run.indentation(steps)),
        load,
        ..found.outcome
    };
    let residuals = totals.relative_residuals();
    summary.contact = ContactQuality {
        tension: residuals.tension,
        penetration: residuals.penetration,
        complementarity: residuals.complementarity,
        slice_error: prepared.road.slice_error(),
        local_compliance: prepared.local_compliance,
        slices: prepared.contact.slice_errors.clone(),
        aborted_searches: 0,
        solves_per_step: counts.solves_per_step(),
    };
    summary.notes.clone_from(&prepared.notes);
    summary.warnings.clone_from(&run.warnings);
    summary.warnings.extend(load.filter(|load| !load.met).map(|load| load.to_string()));
    summary.warnings.extend(impossible_energy(&loaded.scene, &summary.outcome));
    summary.warnings.extend((totals.edge_contacts > 0).then(|| {
        if march.is_widened() {
            format!(
                "in {} steps contact reached the end of the window of cells, and was solved again over a wider one: \
                 forces of single cells are written for the first window only, and those beyond it are added to its \
                 outermost columns",
                totals.edge_contacts
            )
        } else {
            format!(
                "in {} steps the outermost element of the window was in contact: \
                 the patch may be longer than the window",
                totals.edge_contacts
            )
        }
    }));
    summary.warnings.extend(found.warnings);
    Ok(summary)
}

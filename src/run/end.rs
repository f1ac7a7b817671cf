//! End of a run: its energies, which are refused if they are impossible, since a search that has satisfied its
//! conditions may still have gone wrong; files and findings of its effects; and the summary.

use crate::counters::{Meter, Stage};
use crate::effects::{Found, RunError};
use crate::results::files::ResultFiles;
use crate::results::summary::{ContactQuality, FrictionSummary, LoadResult, Outcome, RunCost, Summary};
use crate::run::simulation::Simulation;
use crate::scene::{Coefficient, LoadedScene, LongitudinalCreep, Scene};

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
    summary.levels = run.finer_mesh();
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

/// Message on an energy that is impossible; `None` if all are possible.
///
/// - A passive tyre returns no more than it had stored, which is less than its force times its indentation.
/// - A wheel without a given creep is held back by less than its load: the resultant of its forces lies within the
///   patch, which is shorter than the radius. A creep is left out: it drives waves of the tyre by friction.
/// - The power dissipated by friction is not negative, and at most that of the whole friction force at the speed of
///   rolling and of creep; that force includes the pull of adhesion all over the patch.
pub(crate) fn impossible_energy(scene: &Scene, outcome: &Outcome) -> Option<String> {
    let (speed, counted) = (scene.rolling.speed(), scene.rolling.duration);
    let force = outcome.mean_force?.abs();
    // Longitudinal and lateral together.
    let creep = scene.friction.as_ref().map_or(0.0, |friction| {
        let longitudinal = match friction.creep.longitudinal {
            LongitudinalCreep::Given(creep) => creep.abs(),
            LongitudinalCreep::Free => 0.0,
        };
        longitudinal + friction.creep.lateral.abs()
    });
    let rolls_freely = creep <= 0.0;
    if let Some(resistance) = outcome.rolling_resistance.filter(|found| rolls_freely && found.coefficient > 1.0) {
        return Some(format!(
            "rolling resistance by hysteresis is {:.2} times the load, {:.3e} W, and that of a freely rolling wheel is \
             less than its load: this is physically impossible",
            resistance.coefficient, resistance.power
        ));
    }
    if let (Some(resistance), Some(indentation)) = (outcome.rolling_resistance, outcome.indentation) {
        let (power, stored) = (resistance.power, force * indentation.abs());
        if power.is_nan() || power < -stored / counted {
            return Some(format!(
                "the tyre gives back {:.3e} W over {counted} s, and cannot have stored more than {stored:.0} J: this \
                 is physically impossible",
                -power
            ));
        }
    }
    let (FrictionSummary { mean_slip_power: power, .. }, friction) = (outcome.friction?, scene.friction.as_ref()?);
    let mu = match friction.coefficient() {
        Coefficient::Constant(mu) => mu,
        Coefficient::Falling(law) => law.slow.max(law.fast),
    };
    let length = outcome.mean_contact_length.unwrap_or_default();
    let pull = scene.adhesion.as_ref().map_or(0.0, |adhesion| adhesion.stress * scene.tyre.contact_width * length);
    let slip = 1.0 + creep + 0.5 * length * friction.creep.spin.abs();
    let most = mu * (force + pull) * speed * slip;
    // Rounding error of a sum that is 0 if all cells stick.
    let least = -1e-9 * most;
    (!(least..=most).contains(&power)).then(|| {
        format!(
            "friction dissipates {power:.3e} W, and sliding all over takes {most:.3e} W: this is physically impossible"
        )
    })
}

#[cfg(test)]
mod tests {
    use crate::results::summary::RollingResistance;
    use crate::scene::DEFAULT;

    use super::*;

    #[test]
    fn energy_that_no_tyre_has_stored_cannot_come_back() {
        let scene = Scene::from_str(DEFAULT, "default").unwrap().scene;
        let of = |coefficient: f64| {
            let (load, speed) = (3400.0, scene.rolling.speed());
            let force = coefficient * load;
            let outcome = Outcome {
                mean_force: Some(load),
                indentation: Some(0.016),
                rolling_resistance: Some(RollingResistance { coefficient, force, power: force * speed }),
                ..Outcome::default()
            };
            impossible_energy(&scene, &outcome)
        };
        assert_eq!((of(0.012), of(0.0)), (None, None));
        let reported = of(-480.0).unwrap();
        assert!(reported.contains("gives back") && reported.contains("physically impossible"), "{reported}");
        let reported = of(3.64).unwrap();
        assert!(reported.contains("rolling resistance") && reported.contains("3.64 times the load"), "{reported}");
        // The elastic energy released in 18 s is at most 3 W.
        assert!(of(-2e-5).is_none() && of(-1e-3).is_some());
    }

    #[test]
    fn friction_dissipates_no_more_than_sliding_does() {
        let text = format!("{DEFAULT}\n[friction]\nmu = 0.8\n")
            .replace("tread = \"elastic\"", "zone = \"cells\"")
            .replace("slices = \"winkler\"", "")
            .replace("time_rule = \"sdirk2\"", "");
        let scene = Scene::from_str(&text, "friction").unwrap().scene;
        let of = |power: f64| {
            let friction = FrictionSummary {
                mean_longitudinal_force: 0.0,
                mean_lateral_force: 0.0,
                mean_aligning_moment: 0.0,
                mean_slip_power: power,
                slipping_share: 0.1,
                slip_resistance: power / (3400.0 * scene.rolling.speed()),
                mean_creep: 0.0,
                mean_torque: 0.0,
                free: None,
            };
            impossible_energy(
                &scene,
                &Outcome { mean_force: Some(3400.0), friction: Some(friction), ..Outcome::default() },
            )
        };
        assert!(of(120.0).is_none() && of(0.0).is_none());
        let reported = of(3.5e7).unwrap();
        assert!(reported.contains("friction dissipates 3.500e7 W") && of(-1.0).is_some(), "{reported}");
    }
}

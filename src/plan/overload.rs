//! Loads beyond the range of a tyre's model, as a linear tyre carries any, or beyond its load index.

use crate::contact::static_contact::StaticContact;
use crate::scene::{Axle, GRAVITY, LoadedScene, SceneError, Tyre, short};

use super::Plan;

/// Shares of the circumference covered by the patch above which a run is warned of and refused. The model's tread moves
/// along the radius, and the road presses upwards: at half the angle of the patch both differ by 1 - cos(pi share), 5 %
/// and 19 % at its ends.
const LONG_PATCH: [f64; 2] = [0.1, 0.2];
/// Part of the height over the rim's seat that the belt can be pushed in: the flange, 17.5 mm high on a car's rim, and
/// the folded walls fill the rest.
const ROOM: f64 = 0.8;
/// Relative excess over a load index that is no more than rounding of the load.
const ROUNDING: f64 = 1e-3;

/// Judgement of a tyre's contact on a smooth road.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Overload {
    /// To be warned of; the reason in words.
    Unusual(String),
    /// To be refused; the reason in words.
    Beyond(String),
}

/// Judges a tyre's contact on a smooth road; `None` if the model holds.
pub(crate) fn overload(tyre: &Tyre, standing: &StaticContact) -> Option<Overload> {
    let StaticContact { indentation, force, length, .. } = *standing;
    let under = format!("under {force:.0} N");
    let mm = |length: f64| format!("{:.0} mm", 1e3 * length);
    if let Some(height) = tyre.height_over_rim().filter(|height| indentation >= ROOM * height) {
        let wrong =
            format!("{under} the tyre is pushed in by {}, and stands {} over its rim", mm(indentation), mm(height));
        return Some(Overload::Beyond(wrong));
    }
    let share = length / tyre.circumference;
    let [long, most] = LONG_PATCH;
    if share > long {
        let error = 100.0 * (1.0 - (std::f64::consts::PI * share).cos());
        let wrong = format!(
            "{under} the patch is {} long, {:.0} % of the circumference: at its ends the tread moves along the radius, \
             {error:.0} % off the vertical that is meant",
            mm(length),
            100.0 * share
        );
        return Some(if share > most { Overload::Beyond(wrong) } else { Overload::Unusual(wrong) });
    }
    let index = tyre.load_index?;
    let borne = load_of(index);
    (force > GRAVITY * borne * (1.0 + ROUNDING)).then(|| {
        let weight = force / GRAVITY;
        Overload::Unusual(format!(
            "{under}, {weight:.0} kg, the tyre carries more than load index {index} allows, {borne:.0} kg"
        ))
    })
}

impl Plan {
    /// Judges the tyre's contact; a refusal is only a warning if the scene allows implausible values.
    fn overload(&self) -> Option<Overload> {
        let found = overload(&self.decisions.tyre, &self.standing()?)?;
        Some(match found {
            Overload::Beyond(wrong) if self.scene.allow_implausible => Overload::Unusual(wrong),
            other => other,
        })
    }

    /// Warning of a load beyond the accurate range of the model.
    pub(super) fn load_warning(&self) -> Option<String> {
        self.overload().and_then(|found| match found {
            Overload::Unusual(wrong) => Some(wrong),
            Overload::Beyond(_) => None,
        })
    }

    /// Checks that the tyre carries its axle within the range of its model; the error is at the axle's key.
    pub(crate) fn check_standing(&self, loaded: &LoadedScene) -> Result<(), SceneError> {
        let key = match self.scene.rolling.axle {
            Axle::Indentation { .. } => "rolling.axle.indentation",
            Axle::Load { .. } | Axle::Mass { .. } => "rolling.axle.load",
        };
        let wrong = match (self.standing_or_error(), self.overload()) {
            (Err(error), _) => error.to_string(),
            (Ok(_), Some(Overload::Beyond(wrong))) => wrong,
            _ => return Ok(()),
        };
        let right = match self.scene.rolling.axle {
            Axle::Indentation { indentation, .. } => format!("less than {} m", short(indentation)),
            _ => "a smaller load, or a larger or stiffer tyre".to_owned(),
        };
        Err(loaded.complain(key, wrong, right).into())
    }
}

/// First and last index of car tyres.
pub(crate) const OF_CARS: [u16; 2] = [60, 126];
/// Loads of these indices (ISO 4000-1, rounded to a series of preferred numbers) \[kg\].
const LOADS: [u16; 67] = [
    250, 257, 265, 272, 280, 290, 300, 307, 315, 325, 335, 345, 355, 365, 375, 387, 400, 412, 425, 437, 450, 462, 475,
    487, 500, 515, 530, 545, 560, 580, 600, 615, 630, 650, 670, 690, 710, 730, 750, 775, 800, 825, 850, 875, 900, 925,
    950, 975, 1000, 1030, 1060, 1090, 1120, 1150, 1180, 1215, 1250, 1285, 1320, 1360, 1400, 1450, 1500, 1550, 1600,
    1650, 1700,
];

/// Load of a car tyre's index \[kg\]; `None` for other indices.
pub(crate) fn load_of_car(index: u16) -> Option<u16> {
    LOADS.get(usize::from(index.checked_sub(OF_CARS[0])?)).copied()
}

/// Load of any index \[kg\]: beyond those of cars 45 kg, ten times as much every 80, which is within 2 % of the table.
fn load_of(index: u16) -> f64 {
    load_of_car(index).map_or_else(|| 45.0 * 10_f64.powf(f64::from(index) / 80.0), f64::from)
}

#[cfg(test)]
mod tests {
    use crate::scene::{DEFAULT, Scene, Setting};

    use super::*;

    fn plan(settings: &[&str]) -> (LoadedScene, Plan) {
        let settings: Vec<Setting> = settings.iter().map(|text| Setting::parse(text).unwrap()).collect();
        let loaded = Scene::from_str_with(DEFAULT, "default", &settings).unwrap();
        let plan = Plan::of(&loaded).unwrap();
        (loaded, plan)
    }

    #[test]
    fn a_tyre_over_its_rim_is_refused_and_overloads_are_warned_of() {
        // 925 kg are those of the index 105.
        for usual in [&["tyre.load_index=91"][..], &["tyre.load_index=105", "rolling.axle={ load = 9075.0 }"]] {
            let (loaded, usual) = plan(usual);
            assert!(usual.check_standing(&loaded).is_ok() && usual.load_warning().is_none());
        }
        let (loaded, over) = plan(&["tyre.load_index=91", "rolling.axle={ load = 6500.0 }"]);
        let reported = over.load_warning().unwrap();
        assert!(
            reported.contains("load index 91") && reported.contains("kg") && over.check_standing(&loaded).is_ok(),
            "{reported}"
        );
        let (loaded, long) = plan(&["rolling.axle={ load = 12500.0 }"]);
        let reported = long.load_warning().unwrap();
        assert!(reported.contains("of the circumference") && long.check_standing(&loaded).is_ok(), "{reported}");
        let (loaded, rim) = plan(&["rolling.axle={ indentation = 0.097 }"]);
        let error = rim.check_standing(&loaded).unwrap_err().to_string();
        assert!(error.contains("rolling.axle.indentation") && error.contains("over its rim"), "{error}");
    }

    #[test]
    fn indices_stand_for_the_loads_of_the_standard() {
        assert_eq!(usize::from(OF_CARS[1] - OF_CARS[0]) + 1, LOADS.len());
        assert_eq!(
            [59, 60, 91, 105, 126, 127].map(load_of_car),
            [None, Some(250), Some(615), Some(925), Some(1700), None]
        );
        for (index, load) in [(82, 475.0), (91, 615.0), (105, 925.0)] {
            assert!((load_of(index) - load).abs() < 1e-9, "{index}");
        }
        for (index, load) in [(50, 190.0), (154, 3750.0)] {
            assert!((load_of(index) / load - 1.0).abs() < 0.02, "{index}");
        }
    }
}

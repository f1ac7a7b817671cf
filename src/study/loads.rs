//! A tyre under given loads on a smooth road: deflection and patch length, standing and rolling.
//!
//! 1. standing: static influence functions, contact at rest under each load;
//! 2. rolling: a short run at the scene's speed for each load.
//!
//! Both with the elastic tread, whatever the scene's contact law: the results are properties of the tyre. Lengths are
//! whole elements where a step rolls a whole element.

use crate::contact::ContactError;
use crate::contact::static_contact::{StaticContact, StaticTyre};
use crate::counters::Job;
use crate::run::RunError;
use crate::scene::{Axle, Contact, Effects, Road, Scene};
use crate::study::trial::{SETTLING, Trials};
use crate::tyre::influence::{Field, InfluenceSum};

/// Time over which a rolling patch is averaged \[s\]: somewhat more than a revolution at 80 km/h.
const AVERAGED: f64 = 0.1;
/// Largest indentation of a curve over that under the load.
const BEYOND: f64 = 1.2;

/// A tyre that stands on a flat road.
#[derive(Clone, Debug)]
pub struct LoadedTyre {
    /// Static influence at an element j further on \[m/N\].
    row: Vec<f64>,
    circumference: f64,
}

impl LoadedTyre {
    /// The standing tyre of a scene, with its elements; no setting of the scene may be left open.
    pub fn new(scene: &Scene) -> Self {
        let Scene { tyre, rolling, numerics, .. } = scene;
        let element = tyre.circumference / numerics.elements as f64;
        let time_step = numerics.advance().time_step(element, rolling.speed());
        let sum = InfluenceSum::new(tyre, numerics, numerics.time_rule.resolved_symbol() / time_step);
        Self { row: sum.static_row(Field::Surface), circumference: tyre.circumference }
    }

    fn tyre(&self) -> StaticTyre<'_> {
        StaticTyre { influence: &self.row, circumference: self.circumference }
    }

    /// Contact under a load \[N\].
    ///
    /// # Errors
    /// [`ContactError::LoadNotReached`], or of the search.
    pub fn under(&self, load: f64) -> Result<StaticContact, ContactError> {
        self.held_by(&Axle::Load { load, tolerance: Axle::LOAD_TOLERANCE })
    }

    /// Contact under an axle that holds a height or a load.
    ///
    /// # Errors
    /// As [`Self::under`].
    pub(crate) fn held_by(&self, axle: &Axle) -> Result<StaticContact, ContactError> {
        self.tyre().under(axle)
    }

    /// Contacts at `points` evenly spaced indentations, up to [`BEYOND`] times that under a load \[N\].
    ///
    /// # Errors
    /// As [`Self::under`].
    pub fn curve(&self, load: f64, points: usize) -> Result<Vec<StaticContact>, ContactError> {
        let deepest = BEYOND * self.under(load)?.indentation;
        (1..=points).map(|k| self.tyre().at(deepest * k as f64 / points as f64)).collect()
    }
}

/// Mean length of the contact patch under each load \[N\], rolling at the scene's speed on a smooth road \[m\].
///
/// # Errors
/// Errors of any of the runs; [`RunError::Interrupted`].
pub(crate) fn rolling(scene: &Scene, loads: &[f64], job: Job<'_>) -> Result<Vec<f64>, RunError> {
    let mut smooth = scene.clone();
    smooth.numerics.forget_wishes();
    (smooth.road, smooth.contact) = (Road::Smooth, Contact::default());
    smooth.effects = Effects { rotation: scene.effects.rotation, ..Effects::default() };
    (smooth.outputs.vibration, smooth.rolling.start) = (None, None);
    smooth.rolling.warm_up = smooth.rolling.warm_up.max(SETTLING);
    smooth.rolling.duration = AVERAGED;
    let time = loads.len() as f64 * (smooth.rolling.warm_up + AVERAGED);
    let mut trials = Trials::new(time, job);
    let lengths = loads.iter().map(|&load| {
        smooth.rolling.axle = Axle::Load { load, tolerance: Axle::LOAD_TOLERANCE };
        Ok(trials.roll(&smooth)?.contact_length())
    });
    let lengths = lengths.collect::<Result<_, RunError>>()?;
    trials.finish();
    Ok(lengths)
}

//! A complete scene.

use std::path::Path;

use serde::Serialize;

use super::contact::{CONTACT, Contact, Tread, Zone, of_zone};
use super::effects::{EFFECTS, Effects, Switch};
use super::friction::{ADHESION, Adhesion, FRICTION, Friction};
use super::material::Law;
use super::numerics::{NUMERICS, Numerics, OUTPUTS, Outputs};
use super::road::{ROAD, Road};
use super::rolling::{ROLLING, Rolling};
use super::sound::{AIR_PUMPING, AirPumping, PatchAir, RADIATION, RECEIVERS, Radiation, RadiationQuality, Receiver};
use super::tread_pattern::{BlockModel, Groove, TREAD_PATTERN, TreadPattern};
use super::tyre::{Tyre, TyreKind};
use crate::scene::keys::{is_default, keys};
use crate::scene::kind::{Flag, Text};

keys! {
    /// A complete scene: what rolls, on what, how fast, and what is wanted from it.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub Scene {
        /// Free text, shown in results and plots.
        title: String = String::new() => Text,
        /// True to accept implausible numbers, up to a thousand times outside the plausible range.
        #[serde(skip_serializing_if = "is_default")]
        allow_implausible: bool = false => Flag,
        /// The tyre: given in place or, in the file, by the path of a tyre file.
        tyre: Tyre => TyreKind,
        /// Pattern of the tread, also as a table of the tyre's file; without it the tread has no grooves.
        tread_pattern?: TreadPattern => TREAD_PATTERN,
        /// The road.
        road: Road = Road::default() => ROAD,
        /// Speed, duration and axle.
        rolling: Rolling => ROLLING,
        /// Contact law of tread and road slices.
        #[serde(serialize_with = "of_zone")]
        contact: Contact = Contact::default() => CONTACT,
        /// Friction, with `contact.zone = "cells"` only; without it forces are normal.
        friction?: Friction => FRICTION,
        /// Adhesion, with friction only.
        adhesion?: Adhesion => ADHESION,
        /// Effects beside the contact itself.
        effects: Effects = Effects::default() => EFFECTS,
        /// Resolution and tolerances.
        numerics: Numerics = Numerics::default() => NUMERICS,
        /// Outputs.
        outputs: Outputs = Outputs::default() => OUTPUTS,
        /// Receivers of the sound pressure; `[[receiver]]` in the file.
        #[serde(rename = "receiver", skip_serializing_if = "Vec::is_empty")]
        receivers as "receiver": Vec<Receiver> = Vec::new() => RECEIVERS,
        /// Sound radiation.
        #[serde(skip_serializing_if = "is_default")]
        radiation: Radiation = Radiation::default() => RADIATION,
        /// Air under the contact patch; without it the patch is sealed.
        air_pumping?: AirPumping => AIR_PUMPING,
    }
}

impl Scene {
    /// The tread pattern, unless the scene has none or switches it off.
    pub fn pattern(&self) -> Option<&TreadPattern> {
        self.tread_pattern.as_ref().filter(|_| self.effects.tread_pattern != Switch::Off)
    }

    /// Files that are read when the scene is run, with their keys. Those of tyre and microphones are not among them: in
    /// a loaded scene these are tables.
    pub(crate) fn files(&self) -> impl Iterator<Item = (&'static str, &Path)> {
        let pattern = self.pattern().and_then(|pattern| pattern.file.as_deref());
        let all = [("road.file", self.road.file()), ("tread_pattern.file", pattern)];
        all.into_iter().filter_map(|(key, file)| Some((key, file?)))
    }

    /// Grooves of the tread through which air leaves the patch; none if the patch is sealed, or if the effect is
    /// switched off or has nothing to act on.
    pub(crate) fn open_grooves(&self) -> &[Groove] {
        let patch = self.air_pumping.as_ref().map_or(PatchAir::Sealed, |pumping| pumping.patch);
        let pattern = self.pattern().filter(|_| patch != PatchAir::Sealed && self.hears_patch());
        pattern.map_or(&[], |pattern| &pattern.grooves)
    }

    /// True if air under an open patch contributes to the sound at the receivers.
    fn hears_patch(&self) -> bool {
        let sounds = !self.receivers.is_empty() && self.radiation.quality == RadiationQuality::Full;
        sounds && self.effects.air_pumping != Switch::Off && self.contact.tread == Tread::Elastic
    }

    /// True if the air in all voids between tread and road contributes to the sound.
    pub(crate) fn opens_voids(&self) -> bool {
        let is_asked = self.air_pumping.as_ref().is_some_and(|pumping| pumping.patch == PatchAir::Voids);
        is_asked && self.hears_patch() && self.contact.zone == Zone::Cells
    }

    /// True if compressed blocks displace air into the voids beside them, with an effect on the sound: the patch is
    /// open, and nothing that this needs is missing.
    pub(crate) fn squeezes_blocks(&self) -> bool {
        let is_compliant = self.pattern().is_some_and(|pattern| pattern.blocks == BlockModel::Compliant);
        let is_asked = self.air_pumping.as_ref().is_some_and(|pumping| pumping.squeeze);
        let is_open = !self.open_grooves().is_empty() || self.opens_voids();
        is_asked && is_compliant && self.contact.zone == Zone::Cells && is_open
    }

    /// Why cells of this scene cannot have sub-cells, and what would be right; `None` if they can.
    pub(crate) fn refusal_of_sub_cells(&self) -> Option<[&'static str; 2]> {
        let law = self.tyre.layers.last().map(|tread| tread.material.law);
        let has_voids = self.air_pumping.as_ref().is_some_and(|pumping| pumping.patch == PatchAir::Voids);
        let is_truncated = self.numerics.lateral_terms.is_some() || self.numerics.wavenumber_aliases.is_some();
        let refusals = [
            (self.friction.is_some(), "friction acts on cells as a whole", "1, or leave [friction] out"),
            (self.pattern().is_some(), "a tread pattern is one of whole cells", "1, or leave [tread_pattern] out"),
            (has_voids, "voids are those beside whole cells", "1, or air_pumping.patch = \"sealed\""),
            (is_truncated, "sub-cells need the whole sums", "1, or leave lateral_terms and wavenumber_aliases out"),
            (
                !matches!(law, Some(Law::Elastic | Law::PowerLaw)),
                "sub-cells creep as a tread of the law \"power-law\" does, or not at all",
                "1, or an elastic or power-law material of the outermost layer",
            ),
        ];
        refusals.into_iter().find(|(refused, ..)| *refused).map(|(_, wrong, right)| [wrong, right])
    }

    /// True if the contact has tangential forces or adhesion; friction of 0 alone is contact without either.
    pub fn has_tractions(&self) -> bool {
        self.adhesion.is_some() || self.friction.as_ref().is_some_and(|friction| !friction.is_frictionless())
    }
}

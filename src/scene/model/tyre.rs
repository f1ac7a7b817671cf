//! `[tyre]`: shape, layers, foundation or sidewalls, and inflation.

use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Value as Json, json};
use toml::de::DeValue;

use super::cords::{CORDS, Cords, MOST_CORD_LOSSES, ORTHOTROPIC, Orthotropic};
use super::inflation::{CAVITY, Cavity, INFLATION, Inflation, SIDEWALL, Sidewall};
use super::material::{
    FREQUENCY, LOSS, MATERIAL, MODULUS, Material, POISSON, WrittenMaterial, corner_frequency, reference_frequency,
};
use crate::scene::Problem;
use crate::scene::keys::{is_default, keys};
use crate::scene::kind::{Bounds, Exactly, File, Flag, Name, OneOf, Optional, Whole};
use crate::scene::problem::short;
use crate::scene::table::{Each, Keys, Kind, Nested, Table, Value};
use crate::sidewall::{Arc, Meridian, Relaxation};

const CIRCUMFERENCE: Bounds = Bounds::positive("m").plausible(0.02, 30.0);
const LENGTH: Bounds = Bounds::positive("m").plausible(1e-3, 5.0);
const CROWN: Bounds = Bounds::positive("m").plausible(1e-3, 1e4);
const THICKNESS: Bounds = Bounds::positive("m").plausible(2e-4, 1.0);
const TENSION: Bounds = Bounds::not_negative("N/m").plausible(1e-3, 1e7);
const BED: Bounds = Bounds::not_negative("N/m^3").plausible(1.0, 1e12);

keys! {
    /// The tyre: layers round its circumference, flat or curved, between two sides.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub Tyre {
        /// Circumference L = 2 pi R \[m\].
        circumference: f64 => CIRCUMFERENCE,
        /// Width B between the sides \[m\].
        width: f64 => LENGTH,
        /// Width b of the contact strip, centred \[m\].
        contact_width: f64 => LENGTH,
        /// Radius of the tread's crown across \[m\], which spreads the pressure of `zone = "cells"` and of pressed
        /// slices over the strip; level without.
        crown_radius?: f64 => CROWN,
        /// Load index (ETRTO, ISO 4000-1), which states the load capacity: 91 for 615 kg. A larger load gives a
        /// warning.
        load_index?: u16 => Whole::between(0, 279),
        /// Support of the sides.
        #[serde(skip_serializing_if = "is_default")]
        sides: Sides = Sides::default() => OneOf::new(),
        /// True if the layers are a hollow cylinder; a flat plate otherwise.
        #[serde(skip_serializing_if = "is_default")]
        curvature: bool = false => Flag,
        /// The inflation: a pressure above that outside.
        inflation?: Inflation => INFLATION,
        /// The air within, as a resonator.
        cavity?: Cavity => CAVITY,
        /// The sidewalls of a curved tyre as inflated arcs, in place of `foundation`.
        sidewall?: Sidewall => SIDEWALL,
        /// The air cushion and carcass under the innermost layer; there is none beside `sidewall`.
        #[serde(skip_serializing_if = "is_default")]
        foundation: Foundation = Foundation::default() => FOUNDATION,
        /// Layers from the rim outwards; the last one is the tread.
        layers: Vec<Layer> => LAYERS,
    } without key {
        /// Angular velocity of the turning tyre \[rad/s\], 0 at rest. Elements count against the rotation: of a tyre
        /// that rolls forwards it is -V/R.
        #[serde(skip_serializing_if = "is_default")]
        angular_velocity: f64 = 0.0,
    }
}

/// Support of the tyre's sides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sides {
    /// Simply supported: sines of odd number across the width.
    #[default]
    Supported,
    /// Free to rise and to slide along: cosines of even number, the constant one included.
    Guided,
}

keys! {
    /// Elastic foundation under the innermost layer, none by default; its loss follows the same power law as the
    /// materials.
    #[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
    #[serde(deny_unknown_fields)]
    pub Foundation {
        /// Normal stiffness per area at the reference frequency \[N/m^3\].
        normal: f64 => BED,
        /// Tangential stiffness per area at the reference frequency \[N/m^3\].
        tangential: f64 => BED,
        /// Loss factor eta \[1\].
        #[serde(default)]
        loss_factor: f64 = 0.0 => LOSS,
        /// Frequency at which the stiffness is as given \[Hz\].
        #[serde(default = "reference_frequency")]
        reference_frequency: f64 = Material::REFERENCE_FREQUENCY => FREQUENCY,
        /// Frequency below which the power law levels off \[Hz\].
        #[serde(default = "corner_frequency")]
        corner_frequency: f64 = Material::CORNER_FREQUENCY => FREQUENCY,
    }
}

keys! {
    /// One elastic layer: rubber, rubber with cords, or an orthotropic material.
    #[derive(Clone, Debug, PartialEq)]
    pub Layer {
        /// Name of the layer: belt, tread, ...
        name: String => Name,
        /// Thickness h \[m\].
        thickness: f64 => THICKNESS,
        /// Tension per width along x and y \[N/m\]; the prestress is T/h. Compression could buckle the layer, which is
        /// outside of a linear model.
        tension: [f64; 2] = [0.0; 2] => Exactly(TENSION),
        /// Material of the layer; without `modulus` and `poisson` where the layer is orthotropic.
        material: Material => MATERIAL,
        /// Cords in the material; not in the outermost layer, which the road touches.
        cords: Vec<Cords> = Vec::new() => CORDS,
        /// Moduli of a layer that is not isotropic; not of the outermost one.
        orthotropic: Option<Orthotropic> = None => Optional(ORTHOTROPIC),
    }
}

impl Default for Foundation {
    fn default() -> Self {
        Self {
            normal: 0.0,
            tangential: 0.0,
            loss_factor: 0.0,
            reference_frequency: Material::REFERENCE_FREQUENCY,
            corner_frequency: Material::CORNER_FREQUENCY,
        }
    }
}

impl Serialize for Layer {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { name, thickness, tension, material, cords, orthotropic } = self;
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("name", name)?;
        map.serialize_entry("thickness", thickness)?;
        map.serialize_entry("tension", tension)?;
        map.serialize_entry("material", &WrittenMaterial { material, isotropic: orthotropic.is_none() })?;
        if !cords.is_empty() {
            map.serialize_entry("cords", cords)?;
        }
        if let Some(orthotropic) = orthotropic {
            map.serialize_entry("orthotropic", orthotropic)?;
        }
        map.end()
    }
}

impl Layer {
    /// True if the layer is isotropic: no cords, one modulus and Poisson's ratio.
    pub fn is_isotropic(&self) -> bool {
        self.cords.is_empty() && self.orthotropic.is_none()
    }

    /// Stiffness of the layer along the circumference per width, strains across being held at zero, at the reference
    /// frequency: Q_tt h \[N/m\].
    pub fn hoop_stiffness(&self) -> f64 {
        let Material { modulus, poisson, .. } = self.material;
        let layer = match &self.orthotropic {
            Some(orthotropic) => orthotropic.constants().plane[0],
            None => modulus / (1.0 - poisson * poisson),
        };
        let cords: f64 = self.cords.iter().map(|cords| cords.shares_in(self.thickness)[0]).sum();
        (layer + cords) * self.thickness
    }

    /// True if the layer is under tension in any direction.
    pub fn is_tense(&self) -> bool {
        self.tension.iter().any(|tension| tension.abs() > 0.0)
    }
}

impl Tyre {
    /// Rolling radius R = L/(2 pi) \[m\].
    pub fn radius(&self) -> f64 {
        self.circumference / std::f64::consts::TAU
    }

    /// Total thickness of the layers \[m\].
    pub fn thickness(&self) -> f64 {
        self.layers.iter().map(|layer| layer.thickness).sum()
    }

    /// The tyre without its crown: the waves are computed for a level tread.
    #[must_use]
    pub fn levelled(&self) -> Self {
        Self { crown_radius: None, ..self.clone() }
    }

    /// One of its sidewalls as an arc that ends at the inner face, rotating at an angular velocity \[rad/s\]; `None`
    /// without sidewalls or inflation.
    pub(crate) fn sidewall_arc(&self, angular_velocity: f64) -> Option<Arc> {
        let Sidewall { radius, angle, mass, shear, hoop, loss_factor } = *self.sidewall.as_ref()?;
        Some(Arc {
            radius,
            angle,
            pressure: self.inflation.as_ref()?.pressure,
            mass,
            shear,
            hoop: hoop.unwrap_or(Arc::HOOP_OVER_SHEAR * shear),
            edge_radius: self.radius() - self.thickness(),
            angular_velocity,
            relaxation: Relaxation::of_loss_factor(loss_factor),
        })
    }

    /// Height of the sidewalls over the rim, or else the depth of the cavity \[m\]: pushed in by as much, the belt
    /// touches the rim. `None` if neither is given.
    pub(crate) fn height_over_rim(&self) -> Option<f64> {
        let of_arc = self.sidewall_arc(0.0).map(|arc| arc.edge_radius - arc.bead_radius());
        of_arc.or_else(|| self.cavity.map(|cavity| cavity.depth))
    }

    /// Tension along the belt due to the inflation, at rest, less the pull of the sidewalls: T = R_b p B_e/B \[N/m\].
    /// It becomes the tension of the stiffest layer if no layer has a given one.
    pub fn carried_tension(&self) -> Option<f64> {
        let arc = self.sidewall_arc(0.0)?;
        let pull = Meridian::new(&arc)?.edge().pull();
        Some(arc.edge_radius * (arc.pressure - 2.0 * pull / self.width))
    }

    /// Sum of the layers' tensions along the belt \[N/m\].
    pub fn tension_along(&self) -> f64 {
        self.layers.iter().map(|layer| layer.tension[0]).sum()
    }

    /// True if the tension of the layers is the one due to inflation and sidewalls. Compared by value: a scene that was
    /// written out gives the tension that it once left out.
    pub fn tension_is_carried(&self) -> bool {
        self.carried_tension().is_some_and(|carried| carried.to_bits() == self.tension_along().to_bits())
    }

    /// Index of the layer that is stiffest along the circumference.
    pub fn stiffest_layer(&self) -> usize {
        let stiffness = |place: &usize| self.layers[*place].hoop_stiffness();
        (0..self.layers.len()).max_by(|one, other| stiffness(one).total_cmp(&stiffness(other))).unwrap_or(0)
    }

    /// True if it rotates: waves that run forwards then differ from those that run backwards.
    pub fn turns(&self) -> bool {
        self.angular_velocity.abs() > 0.0
    }
}

/// Kind of the tyre: a table. The path of a tyre file has been replaced by the file's table before.
pub(in crate::scene) struct TyreKind;

const TYRE: Nested<Tyre> =
    Nested::new("the tyre", "the table [tyre], or the path of a tyre file in quotes").read_by(tyre);
const FOUNDATION: Nested<Foundation> =
    Nested::new("the foundation", "a table, { normal = ..., tangential = ..., loss_factor = ... }");
const LAYERS: Each<Layer> =
    Each(Nested::new("a layer", "one table [[tyre.layers]] ([[layers]] in a tyre file) for each layer").read_by(layer));

/// Reads a layer and checks that its moduli are given either in its material or in `orthotropic`.
fn layer(table: &mut Table<'_>) -> Option<Layer> {
    let is_orthotropic = table.has("orthotropic");
    let mut sound = Some(());
    let material = table.gives("material");
    for (key, bounds) in [("modulus", &MODULUS as &dyn std::fmt::Display), ("poisson", &POISSON)] {
        let path = ["material.modulus", "material.poisson"][usize::from(key == "poisson")];
        match (is_orthotropic, table.gives(path)) {
            (true, true) => {
                let right = "leave it out: the moduli of `orthotropic` take its place";
                sound = table.complain(path, Problem::does_not_belong("an orthotropic layer", right));
            }
            (false, false) if material => sound = table.complain(path, Problem::missing(&bounds.to_string())),
            _ => {}
        }
    }
    if is_orthotropic && table.has("cords") {
        let right = "leave out one of them: cords belong to a material with modulus and poisson";
        sound = table.complain("cords", Problem::does_not_belong("an orthotropic layer", right));
    }
    let mut layer = Layer::read(table)?;
    sound?;
    let losses = Cords::losses(&layer.cords);
    if losses > MOST_CORD_LOSSES {
        let wrong = format!("the cords have {losses} different loss factors");
        return table.complain("cords", Problem::new(wrong, format!("give at most {MOST_CORD_LOSSES} of them")));
    }
    if let Some(orthotropic) = &layer.orthotropic {
        (layer.material.modulus, layer.material.poisson) = orthotropic.measure();
    }
    Some(layer)
}

impl Kind for TyreKind {
    type Output = Tyre;

    fn wanted(&self) -> String {
        TYRE.wanted()
    }

    fn read(&self, value: &Value<'_>) -> Option<Tyre> {
        // A path is still here only if its file could not be read, which was complained about.
        if matches!(value.value, DeValue::String(_)) { None } else { TYRE.read(value) }
    }

    fn schema(&self) -> Json {
        json!({ "anyOf": [File.schema(), TYRE.schema()] })
    }
}

fn tyre(table: &mut Table<'_>) -> Option<Tyre> {
    let read = Tyre::read(table);
    let held = is_held(table);
    if let (Some(Some(value)), Some(Some(limit))) = (table.peek("contact_width", &LENGTH), table.peek("width", &LENGTH))
        && value > limit
    {
        return table.complain("contact_width", Problem::exceeds(value, limit, "the tyre's width"));
    }
    held?;
    let tyre = read?;
    check(&tyre, table)?;
    inflated(tyre, table)
}

/// Checks that either a foundation or sidewalls support the tyre; `None` after complaints.
fn is_held(table: &Table<'_>) -> Option<()> {
    let mut sound = Some(());
    let mut complain = |key: &str, problem| sound = table.complain(key, problem);
    match [table.has("sidewall"), table.has("foundation")] {
        [true, true] => complain("foundation", Problem::conflict("sidewall")),
        [false, false] => complain("foundation", Problem::missing(&FOUNDATION.wanted())),
        _ => {}
    }
    if table.has("sidewall") && !table.has("inflation") {
        complain("inflation", Problem::missing(&INFLATION.wanted()));
    }
    if table.peek("foundation", &FOUNDATION) == Some(Some(Foundation::default())) {
        complain("foundation", Problem::new("it carries no load", "write stiffnesses above 0 N/m^3"));
    }
    sound
}

/// Checks layers, cavity and sidewalls against the tyre's shape; `None` after complaints.
fn check(tyre: &Tyre, table: &Table<'_>) -> Option<()> {
    let mut sound = Some(());
    let mut complain = |key: &str, problem| sound = table.complain(key, problem);
    let flat = || Problem::does_not_belong("a flat tyre", "write curvature = true, or leave this out");
    if !tyre.curvature && tyre.cavity.is_some() {
        complain("cavity", flat());
    }
    if !tyre.curvature && tyre.sidewall.is_some() {
        complain("sidewall", flat());
    }
    if tyre.sides == Sides::Supported && tyre.cavity.is_some() {
        let wrong = "sides = \"supported\" has no wave that is constant across the width, as the air needs it";
        complain("cavity", Problem::new(wrong, "write sides = \"guided\", or leave this out"));
    }
    let (thickness, radius) = (tyre.thickness(), tyre.radius());
    if tyre.curvature && thickness >= radius {
        let (thickness, radius) = (short(thickness), short(radius));
        let wrong = format!("the layers are {thickness} m thick together, and the tyre's radius is {radius} m");
        complain("layers", Problem::new(wrong, "make the layers thinner, or the circumference longer"));
    }
    if let Some((outermost, layer)) = tyre.layers.iter().enumerate().next_back()
        && !layer.is_isotropic()
    {
        let key = if layer.orthotropic.is_some() { "orthotropic" } else { "cords" };
        let wrong = "the outermost layer is the tread, whose short waves are those of isotropic rubber";
        let right = "leave it out, or add an isotropic layer on top";
        complain(&format!("layers[{outermost}].{key}"), Problem::new(wrong, right));
    }
    if let Some(cavity) = &tyre.cavity
        && cavity.radius >= radius
    {
        complain("cavity.radius", Problem::not_below(cavity.radius, radius, "the tyre's radius"));
    }
    sound
}

/// Gives a tyre the tension due to its inflation if no layer has one; `None` after complaints.
fn inflated(mut tyre: Tyre, table: &Table<'_>) -> Option<Tyre> {
    let (Some(sidewall), Some(arc)) = (&tyre.sidewall, tyre.sidewall_arc(0.0)) else { return Some(tyre) };
    let complain = |key: &str, wrong: String, right: String| table.complain(key, Problem::new(wrong, right));
    let chord = arc.edge_radius - arc.bead_radius();
    if arc.bead_radius() <= 0.0 {
        let inner = short(arc.edge_radius);
        let wrong = format!("the arc is {chord:.4} m high, and the inner face is {inner} m from the axle");
        return complain("sidewall.radius", wrong, "write a shorter radius, or another angle".to_owned());
    }
    if arc.hoop < LEAST_HOOP * arc.shear {
        let wrong = format!("{} N/m is less than a quarter of the shear stiffness", short(arc.hoop));
        let right = "short waves would be unstable: leave it out, for 4 times the shear stiffness, or write more";
        return complain("sidewall.hoop", wrong, right.to_owned());
    }
    let (pressure, angle) = (short(arc.pressure), short(sidewall.angle));
    let Some(tension) = tyre.carried_tension() else {
        let wrong = format!("an arc of this angle, {angle} rad, has no stable shape under {pressure} Pa");
        return complain("sidewall.angle", wrong, "write another angle, from 0.5 to 1.5 rad".to_owned());
    };
    if tyre.layers.iter().enumerate().any(|(place, _)| table.gives(&format!("layers[{place}].tension"))) {
        return Some(tyre);
    }
    if !(tension >= 0.0 && tension.is_finite()) {
        let pull = arc.pressure - tension / arc.edge_radius;
        let wrong = format!(
            "the sidewalls pull the belt inwards by {pull:.3e} Pa, the pressure is {pressure} Pa: a tension of \
             {tension:.3e} N/m would buckle it"
        );
        let right = "write a larger angle, a shorter radius, or a layer's tension".to_owned();
        return complain("sidewall.angle", wrong, right);
    }
    let belt = tyre.stiffest_layer();
    tyre.layers[belt].tension = [tension, 0.0];
    Some(tyre)
}

/// Least hoop over shear stiffness for which short waves round the sidewall are stable.
const LEAST_HOOP: f64 = 0.25;

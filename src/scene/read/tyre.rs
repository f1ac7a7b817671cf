//! `[tyre]`, its layers, materials and foundation.

use toml::de::DeValue;

use super::super::kind::{Bounds, Exactly, Flag, Numbers, OneOf, Text};
use super::super::table::Kind;
use super::super::table::{Each, Nested, Table, Value};
use super::super::{Foundation, Inflation, Law, Layer, Material, Problem, Sides, Tyre};
use super::inflation::{self, CAVITY, INFLATION, LeftOut};

const LENGTH: Bounds = Bounds::positive("m");
const MODULUS: Bounds = Bounds::positive("Pa");
const DENSITY: Bounds = Bounds::positive("kg/m^3");
/// At -1 the shear modulus of an isotropic material is infinite, at 0.5 its compressional one.
const POISSON: Bounds = Bounds::inside(-1.0, 0.5, "");
const LOSS: Bounds = Bounds::not_negative("");
/// The corner may not be 0: the static stiffness of a power law would be 0.
const FREQUENCY: Bounds = Bounds::positive("Hz");
/// Compression could buckle the layer, which is outside of a linear model.
const TENSION: Bounds = Bounds::not_negative("N/m");
const BED: Bounds = Bounds::not_negative("N/m^3");
const RELAXATION_WEIGHT: Bounds = Bounds::positive("");
const RELAXATION_TIME: Bounds = Bounds::positive("s");

/// The tyre: a table; the path of a tyre file was replaced by the table in it before.
pub(super) struct TyreKind;

const TYRE: Nested<Tyre> =
    Nested { title: "the tyre", wanted: "the table [tyre], or the path of a tyre file in quotes", read: tyre };
const FOUNDATION: Nested<Bed> = Nested {
    title: "the foundation",
    wanted: "a table, { normal = ..., tangential = ..., loss_factor = ... }",
    read: foundation,
};
const LAYERS: Each<GivenLayer> = Each(Nested {
    title: "a layer",
    wanted: "one table [[tyre.layers]] ([[layers]] in a tyre file) for each layer",
    read: layer,
});
const MATERIAL: Nested<Material> = Nested {
    title: "a material",
    wanted: "a table, { law = ..., modulus = ..., loss_factor = ..., poisson = ..., density = ... }",
    read: material,
};

impl Kind for TyreKind {
    type Output = Tyre;

    fn wanted(&self) -> String {
        TYRE.wanted()
    }

    fn read(&self, value: &Value<'_>) -> Option<Tyre> {
        // A path is still here only if its file could not be read, which was complained about.
        if matches!(value.get(), DeValue::String(_)) { None } else { TYRE.read(value) }
    }
}

/// A foundation as given: where the sidewalls' arcs are, the stiffness may come from them.
struct Bed {
    normal: Option<f64>,
    tangential: Option<f64>,
    loss_factor: f64,
    reference_frequency: f64,
    corner_frequency: f64,
}

impl Default for Bed {
    fn default() -> Self {
        Self {
            normal: None,
            tangential: None,
            loss_factor: 0.0,
            reference_frequency: Material::REFERENCE_FREQUENCY,
            corner_frequency: Material::CORNER_FREQUENCY,
        }
    }
}

/// A layer, and whether its tension is given.
struct GivenLayer {
    layer: Layer,
    has_tension: bool,
}

fn tyre(table: &mut Table<'_>) -> Option<Tyre> {
    let circumference = table.required("circumference", &LENGTH);
    let width = table.required("width", &LENGTH);
    let contact_width = table.required("contact_width", &LENGTH);
    let sides = table.or("sides", &OneOf::<Sides>::new(), Sides::default());
    let curvature = table.or("curvature", &Flag, false);
    let inflation = table.optional("inflation", &INFLATION);
    let cavity = table.optional("cavity", &CAVITY);
    let bed = table.optional("foundation", &FOUNDATION);
    let layers = table.required("layers", &LAYERS);
    // Sidewalls that are themselves wrong might have given the foundation.
    let bed = match &inflation {
        None | Some(Some(Inflation { sidewalls: Some(_), .. })) => bed.map(Option::unwrap_or_default),
        _ => bed.and_then(|bed| whole(table, bed)),
    };
    if let (Some(value), Some(limit)) = (contact_width, width)
        && value > limit
    {
        return table.complain("contact_width", Problem::exceeds(value, limit, "the tyre's width"));
    }
    let (bed, layers) = (bed?, layers?);
    let left_out =
        LeftOut { tension: !layers[0].has_tension, normal: bed.normal.is_none(), tangential: bed.tangential.is_none() };
    let tyre = Tyre {
        circumference: circumference?,
        width: width?,
        contact_width: contact_width?,
        sides: sides?,
        curvature: curvature?,
        inflation: inflation?,
        cavity: cavity?,
        foundation: Foundation {
            normal: bed.normal.unwrap_or_default(),
            tangential: bed.tangential.unwrap_or_default(),
            loss_factor: bed.loss_factor,
            reference_frequency: bed.reference_frequency,
            corner_frequency: bed.corner_frequency,
        },
        layers: layers.into_iter().map(|given| given.layer).collect(),
    };
    inflation::check(&tyre, table)?;
    inflation::inflated(tyre, left_out, table)
}

/// A foundation with all of its stiffness, which nothing else gives; `None` after complaints.
fn whole(table: &Table<'_>, bed: Option<Bed>) -> Option<Bed> {
    let Some(bed) = bed else { return table.complain("foundation", Problem::missing(&FOUNDATION.wanted())) };
    let parts = [("foundation.normal", bed.normal), ("foundation.tangential", bed.tangential)];
    let missing = |key| table.complain::<()>(key, Problem::missing(&BED.wanted()));
    let found: Vec<Option<()>> = parts.iter().map(|(key, part)| part.map(drop).or_else(|| missing(key))).collect();
    found.into_iter().collect::<Option<()>>().map(|()| bed)
}

fn foundation(table: &mut Table<'_>) -> Option<Bed> {
    let normal = table.optional("normal", &BED);
    let tangential = table.optional("tangential", &BED);
    let default = Bed::default();
    let loss_factor = table.or("loss_factor", &LOSS, default.loss_factor);
    let reference_frequency = table.or("reference_frequency", &FREQUENCY, default.reference_frequency);
    let corner_frequency = table.or("corner_frequency", &FREQUENCY, default.corner_frequency);
    Some(Bed {
        normal: normal?,
        tangential: tangential?,
        loss_factor: loss_factor?,
        reference_frequency: reference_frequency?,
        corner_frequency: corner_frequency?,
    })
}

fn layer(table: &mut Table<'_>) -> Option<GivenLayer> {
    let name = table.required("name", &Text);
    let thickness = table.required("thickness", &LENGTH);
    let has_tension = table.has("tension");
    let tension = table.or("tension", &Exactly::<2>(TENSION), [0.0; 2]);
    let material = table.required("material", &MATERIAL);
    let layer = Layer { name: name?, thickness: thickness?, tension: tension?, material: material? };
    Some(GivenLayer { layer, has_tension })
}

fn material(table: &mut Table<'_>) -> Option<Material> {
    let law = table.or("law", &OneOf::<Law>::new(), Law::default());
    let modulus = table.required("modulus", &MODULUS);
    let poisson = table.required("poisson", &POISSON);
    let density = table.required("density", &DENSITY);
    let mut material = Material {
        law: law.unwrap_or_default(),
        modulus: modulus.unwrap_or_default(),
        poisson: poisson.unwrap_or_default(),
        density: density.unwrap_or_default(),
        loss_factor: 0.0,
        reference_frequency: Material::REFERENCE_FREQUENCY,
        corner_frequency: Material::CORNER_FREQUENCY,
        weights: Vec::new(),
        times: Vec::new(),
    };
    let own_keys = match law {
        None => {
            table.be_lenient();
            None
        }
        Some(Law::Elastic) => {
            let right = "remove it, or choose law = \"power-law\" for a material with losses";
            table.refuse(&["loss_factor"], "law = \"elastic\"", right);
            refuse_frequencies(table, "law = \"elastic\"");
            refuse_relaxation(table, "law = \"elastic\"");
            Some(())
        }
        Some(Law::Hysteretic) => {
            refuse_frequencies(table, "law = \"hysteretic\"");
            refuse_relaxation(table, "law = \"hysteretic\"");
            table.or("loss_factor", &LOSS, 0.0).map(|loss| material.loss_factor = loss)
        }
        Some(Law::PowerLaw) => {
            refuse_relaxation(table, "law = \"power-law\"");
            power_law(table, &mut material)
        }
        Some(Law::Prony) => {
            let right = "remove it: weights and times describe the losses of a prony material";
            table.refuse(&["loss_factor"], "law = \"prony\"", right);
            refuse_frequencies(table, "law = \"prony\"");
            prony(table, &mut material)
        }
    };
    // A stand-in value was put where a key was bad: only a complete material leaves.
    law.and(modulus).and(poisson).and(density).and(own_keys).map(|()| material)
}

fn power_law(table: &mut Table<'_>, material: &mut Material) -> Option<()> {
    let loss_factor = table.or("loss_factor", &LOSS, 0.0);
    let reference_frequency = table.or("reference_frequency", &FREQUENCY, Material::REFERENCE_FREQUENCY);
    let corner_frequency = table.or("corner_frequency", &FREQUENCY, Material::CORNER_FREQUENCY);
    material.loss_factor = loss_factor?;
    material.reference_frequency = reference_frequency?;
    material.corner_frequency = corner_frequency?;
    Some(())
}

fn prony(table: &mut Table<'_>, material: &mut Material) -> Option<()> {
    let weights = table.required("weights", &Numbers(RELAXATION_WEIGHT));
    let times = table.required("times", &Numbers(RELAXATION_TIME));
    let (weights, times) = (weights?, times?);
    if weights.len() != times.len() {
        return table.complain("times", Problem::length_mismatch(times.len(), "weights", weights.len()));
    }
    material.weights = weights;
    material.times = times;
    Some(())
}

fn refuse_frequencies(table: &mut Table<'_>, owner: &str) {
    let right = "remove it, or choose law = \"power-law\"";
    table.refuse(&["reference_frequency", "corner_frequency"], owner, right);
}

fn refuse_relaxation(table: &mut Table<'_>, owner: &str) {
    table.refuse(&["weights", "times"], owner, "remove it, or choose law = \"prony\"");
}

//! Which effects a run simulates, and why.
//!
//! Every later stage asks a [`Decisions`] value what to do; the rows of [`Decisions::rows`] say the same in words.

use serde::Serialize;

use crate::radiation::draft::{DraftError, DraftErrors};
use crate::road::Lattice;
use crate::scene::{
    AirMotion, Axle, Effects, History, Layer, Radiation, RadiationQuality, Road, Scene, SliceCoupling, Slices, Switch,
    Tread, Tyre, Vibration, Zone,
};

/// Share of the belt's tension from which `auto` takes centrifugal tension in: the speed of belt waves then changes by
/// 5 %.
const CENTRIFUGAL_SHARE: f64 = 0.1;
/// Share of the belt's tension from which a run without centrifugal tension says so.
const WORTH_TELLING: f64 = 0.5;

/// Decisions on everything that a run simulates.
#[derive(Clone, Debug, PartialEq)]
pub struct Decisions {
    /// Zone of the contact: slices or cells.
    pub zone: Zone,
    /// The slice law in use; [`Slices::None`] where a slice holds no texture.
    pub slices: Slices,
    /// Cells across the contact width, where that is decided; 1: the road's middle line, level across.
    pub cells_across: Option<usize>,
    /// Cells along an element, where that is decided.
    pub cells_along: Option<usize>,
    /// The tread law.
    pub tread: Tread,
    /// By how much a slice yields more than its element.
    pub slice_coupling: SliceCoupling,
    /// The velocities to follow from the forces, if any.
    pub vibration: Option<Vibration>,
    /// How sound gets to the receivers, if there are any.
    pub radiation: Option<Radiation>,
    /// The tyre as it rolls: with centrifugal tension where that is taken in.
    pub tyre: Tyre,
    /// All effects in words, in the order of the data's way.
    pub rows: Vec<Decision>,
    /// Notes for the user before the run.
    pub notes: Vec<String>,
}

/// One effect.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Decision {
    /// The effect.
    pub effect: &'static str,
    /// True if it is simulated.
    pub on: bool,
    /// How.
    pub form: String,
    /// Why.
    pub reason: String,
}

impl Decisions {
    /// For a scene.
    pub fn new(scene: &Scene) -> Self {
        let mut notes = Vec::new();
        let (tyre, tension) = centrifugal_tension(scene, &mut notes);
        let zone = scene.contact.zone;
        let (texture, slices, cells_across) = texture(scene);
        let (coupling, slice_coupling) = slice_coupling(scene, slices, &mut notes);
        let tread = scene.contact.tread;
        let (effects, vibration) = (&scene.effects, vibration(scene));
        let (radiated, radiation) = radiation(scene);
        let wanted = |field: fn(&Vibration) -> bool| vibration.as_ref().is_some_and(field);
        let rows = vec![
            tension,
            contact_zone(scene),
            texture,
            coupling,
            tread_coupling(tread),
            axle(scene),
            history(scene),
            velocity("tread vibration", effects.tread_vibration, "tread_vibration", wanted(|wanted| wanted.tread)),
            velocity("belt vibration", effects.belt_vibration, "belt_vibration", wanted(|wanted| wanted.belt)),
            velocity(
                "tangential motion",
                effects.tangential_motion,
                "tangential_motion",
                wanted(|wanted| wanted.tangential),
            ),
            radiated,
            later("friction"),
        ];
        let single = matches!(scene.road, Road::Smooth) || zone == Zone::Cells;
        let cells_along = if single { Some(1) } else { scene.contact.cells_along };
        Self { zone, slices, cells_across, cells_along, tread, slice_coupling, vibration, radiation, tyre, rows, notes }
    }
}

fn given(switch: Switch, key: &str) -> Option<String> {
    match switch {
        Switch::On => Some(format!("effects.{key} = \"on\"")),
        Switch::Off => Some(format!("effects.{key} = \"off\"")),
        Switch::Auto => None,
    }
}

fn centrifugal_tension(scene: &Scene, notes: &mut Vec<String>) -> (Tyre, Decision) {
    let (tyre, switch) = (&scene.tyre, scene.effects.centrifugal_tension);
    let speed = scene.rolling.speed();
    // The hoop tension of a thin ring.
    let mass_per_area: f64 = tyre.layers.iter().map(|layer| layer.material.density * layer.thickness).sum();
    let added = mass_per_area * speed * speed;
    let carried: f64 = tyre.layers.iter().map(|layer| layer.tension[0]).sum();
    let share = added / carried;
    let would = if carried > 0.0 {
        format!(
            "m'' V^2 = {:.1} kN/m is {:.1} % of the tension at {} km/h",
            1e-3 * added,
            100.0 * share,
            scene.rolling.speed_kmh
        )
    } else {
        format!("m'' V^2 = {:.1} kN/m at {} km/h", 1e-3 * added, scene.rolling.speed_kmh)
    };
    let limit = 100.0 * CENTRIFUGAL_SHARE;
    let (on, reason) = match switch {
        Switch::On => (true, would.clone()),
        Switch::Off => (false, format!("not asked for; {would}")),
        Switch::Auto if share > CENTRIFUGAL_SHARE => (true, format!("auto: {would}, more than {limit} %")),
        Switch::Auto => (false, format!("auto: {would}, not more than {limit} %")),
    };
    if !on && share > WORTH_TELLING {
        notes.push(format!("{would}: effects.centrifugal_tension = \"auto\" would take it in"));
    }
    let form = if on { "belt tension raised" } else { "" }.to_owned();
    let rolling = if on { spinning(tyre, added, carried) } else { tyre.clone() };
    (rolling, Decision { effect: "centrifugal tension", on, form, reason })
}

/// The tyre with tension added along its circumference \[N/m\]: the layers under tension carry it, each in proportion
/// to its own; where there is none, the layer of the largest stiffness E h does, which holds the others.
fn spinning(tyre: &Tyre, added: f64, carried: f64) -> Tyre {
    let mut tyre = tyre.clone();
    if carried > 0.0 {
        for layer in &mut tyre.layers {
            layer.tension[0] *= 1.0 + added / carried;
        }
    } else {
        let stiffness = |layer: &Layer| layer.material.modulus * layer.thickness;
        if let Some(belt) = tyre.layers.iter_mut().max_by(|a, b| stiffness(a).total_cmp(&stiffness(b))) {
            belt.tension[0] += added;
        }
    }
    tyre
}

fn contact_zone(scene: &Scene) -> Decision {
    let Scene { contact, tyre, .. } = scene;
    let (on, form) = match contact.zone {
        Zone::Slices => (false, "slices, one for each element".to_owned()),
        Zone::Cells => {
            let crown = tyre.crown_radius.map_or("a level tread".to_owned(), |radius| format!("a crown of {radius} m"));
            (true, format!("{} cells across {:.0} mm, {crown}", cells_across(scene), 1e3 * tyre.contact_width))
        }
    };
    let name = if on { "cells" } else { "slices" };
    Decision { effect: "contact in three dimensions", on, form, reason: format!("contact.zone = \"{name}\"") }
}

/// Cells across the strip: as they are given, or about as wide as they are long.
pub fn cells_across(scene: &Scene) -> usize {
    let Scene { contact, tyre, numerics, .. } = scene;
    let size = contact.cell.unwrap_or(tyre.circumference / numerics.elements as f64);
    contact.cells_across.unwrap_or_else(|| Lattice::across(tyre.contact_width, size))
}

fn texture(scene: &Scene) -> (Decision, Slices, Option<usize>) {
    let switch = scene.effects.texture;
    if scene.contact.zone == Zone::Cells {
        let reason = "contact.zone = \"cells\"".to_owned();
        let row =
            Decision { effect: "texture across the width", on: true, form: "heights of cells".to_owned(), reason };
        return (row, Slices::None, Some(cells_across(scene)));
    }
    let varies = scene.road.varies_across();
    // A road that is level across is not flat along an element, unless that is one cell.
    let flat = matches!(scene.road, Road::Smooth) || scene.contact.cells_along == Some(1);
    let law = if flat { Slices::None } else { scene.contact.slices };
    let level = |form: &str, reason: String| {
        let row = Decision { effect: "texture across the width", on: false, form: form.to_owned(), reason };
        (row, law, Some(1))
    };
    if switch == Switch::Off {
        let form = if varies { "middle line of the road, level across" } else { "" };
        return level(form, "effects.texture = \"off\"".to_owned());
    }
    if !varies {
        let road =
            if matches!(scene.road, Road::Smooth) { "the road is smooth" } else { "the road is the same all across" };
        return level("", format!("auto: {road}"));
    }
    if scene.contact.cells_across == Some(1) {
        return level("", "contact.cells_across = 1".to_owned());
    }
    let law = match scene.contact.slices {
        Slices::None => "highest point of each slice",
        Slices::Winkler => "springs all over each slice",
        Slices::HalfSpace => "each line across on an elastic half-space",
    };
    let reason =
        given(switch, "texture").unwrap_or_else(|| "auto: the road varies across the contact width".to_owned());
    let row = Decision { effect: "texture across the width", on: true, form: law.to_owned(), reason };
    (row, scene.contact.slices, scene.contact.cells_across)
}

fn slice_coupling(scene: &Scene, slices: Slices, notes: &mut Vec<String>) -> (Decision, SliceCoupling) {
    let row = |on, form: &str, reason: String| Decision { effect: "slice coupling", on, form: form.to_owned(), reason };
    let explicit = |form: &str, reason: String| (row(false, form, reason), SliceCoupling::Explicit);
    if scene.contact.zone == Zone::Cells {
        return explicit("", "cells have no law of their own".to_owned());
    }
    let coupling = scene.contact.slice_coupling;
    // The factors of the explicit form can be kept.
    if slices == Slices::None {
        return explicit("", "slices that are level are the same by every form".to_owned());
    }
    let given = |name: &str| format!("contact.slice_coupling = \"{name}\"");
    if coupling != SliceCoupling::Local {
        notes.push(
            "the paper's slice coupling takes the element's influence of one time step for the slice's spring: \
             levels have no limit as the time step falls; \
             contact.slice_coupling = \"local\" has one"
                .to_owned(),
        );
    }
    match coupling {
        SliceCoupling::Local => {
            let reason = match scene.contact.local_compliance {
                Some(kappa) => format!("contact.local_compliance = {kappa:e} m/Pa"),
                None => "its compliance from the tread's modulus and the road's texture".to_owned(),
            };
            (row(true, "each slice yields by a compliance of its own", reason), coupling)
        }
        SliceCoupling::Implicit if scene.contact.tread == Tread::Uncoupled => {
            explicit("", "points of an uncoupled tread have no neighbours within a step".to_owned())
        }
        SliceCoupling::Explicit => {
            explicit("curves read without the neighbours' forces of the step", given("explicit"))
        }
        SliceCoupling::Implicit => (row(true, "each slice yields by G0 of its element", given("implicit")), coupling),
    }
}

fn tread_coupling(tread: Tread) -> Decision {
    let (on, form) = match tread {
        Tread::Elastic => (true, "elastic layer"),
        Tread::Uncoupled => (false, "points in contact feel each other from the next step on; elastic in the limit"),
        Tread::Bedding => (false, "independent springs on the carcass"),
    };
    let name = match tread {
        Tread::Elastic => "elastic",
        Tread::Uncoupled => "uncoupled",
        Tread::Bedding => "bedding",
    };
    Decision { effect: "tread coupling", on, form: form.to_owned(), reason: format!("contact.tread = \"{name}\"") }
}

fn axle(scene: &Scene) -> Decision {
    let (on, form, reason) = match scene.rolling.axle {
        Axle::Load { load, .. } => (false, format!("height held, mean force {load} N"), "rolling.axle.load"),
        Axle::Mass { load, mass, .. } => {
            (true, format!("{mass} kg under {load} N move with the contact force"), "rolling.axle.mass")
        }
        Axle::Indentation { indentation, .. } => {
            (false, format!("height held, {} mm into the road", 1e3 * indentation), "rolling.axle.indentation")
        }
    };
    Decision { effect: "axle motion", on, form, reason: reason.to_owned() }
}

fn history(scene: &Scene) -> Decision {
    let (form, reason) = match scene.numerics.history {
        History::Direct => (format!("sum over {} s", scene.numerics.memory), "numerics.history = \"direct\""),
        History::Modal => ("recursion by poles".to_owned(), "numerics.history = \"modal\""),
    };
    Decision { effect: "memory of the tyre", on: true, form, reason: reason.to_owned() }
}

/// Decides the vibration that the outputs ask for; without outputs, the default of the effects that are on.
fn vibration(scene: &Scene) -> Option<Vibration> {
    let Effects { tread_vibration, belt_vibration, tangential_motion, .. } = scene.effects;
    let [tread, belt, tangential] =
        [tread_vibration, belt_vibration, tangential_motion].map(|switch| switch == Switch::On);
    let asked_by_effects =
        || (tread || belt || tangential).then(|| Vibration { tread, belt, tangential, ..Vibration::default() });
    scene.outputs.vibration.clone().or_else(asked_by_effects)
}

fn velocity(effect: &'static str, switch: Switch, key: &str, on: bool) -> Decision {
    let asked = if on { "auto: outputs.vibration asks for it" } else { "auto: no output asks for it" };
    let reason = given(switch, key).unwrap_or_else(|| asked.to_owned());
    let form = if on { "per wavenumber, from the forces" } else { "" }.to_owned();
    Decision { effect, on, form, reason }
}

fn radiation(scene: &Scene) -> (Decision, Option<Radiation>) {
    let row = |on, form: String, reason: String| Decision { effect: "radiation", on, form, reason };
    let given = given(scene.effects.radiation, "radiation");
    if scene.receivers.is_empty() {
        let reason = given.unwrap_or_else(|| "auto: there is no [[receiver]]".to_owned());
        return (row(false, String::new(), reason), None);
    }
    let radiation = scene.radiation.clone();
    let air = match radiation.air {
        AirMotion::Road => "air at rest over the road",
        AirMotion::Axle => "air at rest beside the axle",
        AirMotion::WithTread => "air that turns with the tread",
    };
    let way = match radiation.quality {
        RadiationQuality::Full => "boundary elements".to_owned(),
        RadiationQuality::Draft => {
            let width = scene.tyre.width + 2.0 * radiation.shoulder;
            let errors = DraftErrors::of(scene.tyre.radius(), width).map(|errors| errors.of_standards);
            let told = |error: DraftError| format!("{} dB a third octave and {} dB(A)", error.band, error.level);
            let error = errors.map_or_else(|| "an unknown error".to_owned(), told);
            format!("draft: monopoles with a fitted horn, within {error} at coast-by and cpx, elsewhere by the place,")
        }
    };
    let form = format!("{way} to {} Hz, {air}", radiation.fmax);
    let reason = given.unwrap_or_else(|| match scene.receivers.len() {
        1 => "auto: there is a [[receiver]]".to_owned(),
        several => format!("auto: there are {several} [[receiver]]"),
    });
    (row(true, form, reason), Some(radiation))
}

fn later(effect: &'static str) -> Decision {
    Decision { effect, on: false, form: String::new(), reason: "not there yet".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::PLATE;

    fn of(edit: impl FnOnce(&mut Scene)) -> Decisions {
        let mut scene = Scene::from_str(PLATE, "default").unwrap().scene;
        edit(&mut scene);
        Decisions::new(&scene)
    }

    #[test]
    fn centrifugal_tension_follows_the_speed_and_is_off_unless_asked_for() {
        let base = of(|_| ());
        assert!(!base.rows[0].on && base.rows[0].reason.contains("18.7 %"), "{}", base.rows[0].reason);
        assert_eq!(base.tyre, Scene::from_str(PLATE, "default").unwrap().scene.tyre);
        let at = |speed: f64| {
            of(|scene| {
                scene.effects.centrifugal_tension = Switch::Auto;
                scene.rolling.speed_kmh = speed;
            })
        };
        assert!(at(80.0).rows[0].on && !at(50.0).rows[0].on);
        // m'' = 6 mm x 1300 + 13 mm x 1150 kg/m^3, raised on the belt alone: the tread carries none.
        let (fast, speed) = (at(200.0), 200.0_f64 / 3.6);
        assert!((fast.tyre.layers[0].tension[0] - (6e4 + (7.8 + 14.95) * speed * speed)).abs() < 1e-6);
        assert!(fast.tyre.layers[1].tension[0].abs() < 1e-12 && (fast.tyre.layers[0].tension[1] - 2e4).abs() < 1e-9);
        let told = of(|scene| scene.rolling.speed_kmh = 200.0);
        assert!(told.notes.len() == 1 && told.notes[0].contains("117."), "{:?}", told.notes);
    }

    #[test]
    fn texture_follows_the_road() {
        assert_eq!(of(|_| ()).slices, Slices::Winkler);
        let smooth = of(|scene| scene.road = Road::Smooth);
        assert_eq!((smooth.slices, smooth.cells_across), (Slices::None, Some(1)));
        let off = of(|scene| scene.effects.texture = Switch::Off);
        assert_eq!((off.slices, off.cells_across), (Slices::Winkler, Some(1)));
        let line = of(|scene| (scene.effects.texture, scene.contact.cells_along) = (Switch::Off, Some(1)));
        assert_eq!((line.slices, line.cells_across, line.cells_along), (Slices::None, Some(1), Some(1)));
    }
}

//! Tyres by their size: `init --size 235/45R18` writes one by the rules of docs/tyres.md, by which those in
//! `scenes/tyres` were made.

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

use crate::plan::overload::{OF_CARS, load_of_car};
use crate::scene::GRAVITY;

/// A tyre made by the rules, whose comments say what is published and what is inferred.
const MADE: &str = include_str!("../../scenes/tyres/205_55r16.toml");
/// First text after its head.
const BODY: &str = "# Published: pi times";
/// Part of its index's load that a tyre of the scene carries.
const LOADED: f64 = 0.8;
/// Load \[N\] of the default scene, circumference and contact width of its tyre \[m\].
const DEFAULT_LOAD: f64 = 3400.0;
const DEFAULT_SIZES: [f64; 2] = [1.95, 0.109];
/// Height of a sidewall's arc below which the load is reduced with it \[m\]: the belt would be near its rim.
const LOW: f64 = 0.024;

/// Angle from the middle of a sidewall's arc to its ends \[rad\], as in the default tyre.
const SIDEWALL_ANGLE: f64 = 1.1;
/// Thickness of the default tyre's layers \[m\].
const THICKNESS: f64 = 0.019;
/// Lower end of the arc, measured outwards from the rim's seat \[m\].
const ABOVE_SEAT: f64 = 0.0025;
/// Lower end of the air, measured inwards from the rim's seat \[m\].
const WELL: f64 = 0.012;
/// Depth of the ring of air over the height from well to inner face, and contact width over that of the belt.
const AIR_SHARE: f64 = 0.73;
const CONTACT_SHARE: f64 = 0.8;

/// Nominal size of a car's tyre, possibly with its load index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TyreSize {
    /// Width of the section \[mm\].
    width: u16,
    /// Height of the section over its width \[%\].
    aspect: u16,
    /// Diameter of the rim \[inches\].
    rim: u16,
    index: Option<u16>,
}

/// Dimensions that follow from a size \[m\].
struct Dimensions {
    circumference: f64,
    width: f64,
    contact_width: f64,
    sidewall: f64,
    air_radius: f64,
    air_depth: f64,
}

impl FromStr for TyreSize {
    type Err = String;

    /// Parses a size such as `235/45R18`, `P225/60 R16 97S`, `205/55ZR16 91 V XL` or `245/40 ZR 18 (97Y)`.
    fn from_str(text: &str) -> Result<Self, String> {
        let upper = text.trim().to_uppercase();
        let form = || {
            format!(
                "\"{text}\" is not the size of a car tyre: give width in mm, height in % of it and rim in inches, such \
                 as 235/45R18, if known with load index and speed symbol, 235/45R18 98Y"
            )
        };
        let of_car = upper.strip_prefix('P').unwrap_or(&upper);
        let read = || {
            let (width, rest) = number(of_car)?;
            let (aspect, rest) = number(rest.strip_prefix('/')?.trim_start())?;
            let rest = rest.strip_prefix('Z').unwrap_or(rest).trim_start();
            let (rim, rest) = number(rest.strip_prefix('R')?.trim_start())?;
            Some((width, aspect, rim, rest))
        };
        let (width, aspect, rim, rest) = read().ok_or_else(form)?;
        for (what, found, [least, most], unit) in [
            ("a section", width, [125, 355], "mm wide"),
            ("a section", aspect, [25, 85], "% high"),
            ("a rim", rim, [12, 24], "inches in diameter"),
        ] {
            if !(least..=most).contains(&found) {
                return Err(format!(
                    "\"{text}\": {what} {found} {unit}, and car tyres have {least} to {most}: the rules apply to these \
                     only"
                ));
            }
        }
        let mut index = None;
        for word in rest.split_whitespace().map(|word| word.trim_matches(['(', ')'])) {
            match number(word) {
                Some((found, symbol)) if index.is_none() && symbol.len() <= 1 => index = Some(found),
                None if ["XL", "RF", "RFT", "M+S"].contains(&word) => {}
                // The speed symbol.
                None if index.is_some() && word.len() == 1 => {}
                _ => return Err(form()),
            }
        }
        let size = Self { width, aspect, rim, index: None };
        match index {
            Some(index) => size.with_index(index),
            None => Ok(size),
        }
    }
}

/// Number that a text begins with, and the rest.
fn number(text: &str) -> Option<(u16, &str)> {
    let digits = text.len() - text.trim_start_matches(|sign: char| sign.is_ascii_digit()).len();
    let (number, rest) = text.split_at(digits);
    Some((number.parse().ok()?, rest.trim_start()))
}

impl fmt::Display for TyreSize {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { width, aspect, rim, index } = self;
        write!(formatter, "{width}/{aspect} R{rim}")?;
        index.map_or(Ok(()), |index| write!(formatter, " {index}"))
    }
}

impl TyreSize {
    /// Adds a load index; an error for an index that no car's tyre has, or that differs from the size's.
    pub(crate) fn with_index(self, index: u16) -> Result<Self, String> {
        let [first, last] = OF_CARS;
        if !(first..=last).contains(&index) {
            return Err(format!("load index {index}: car tyres have {first} to {last}"));
        }
        match self.index {
            Some(other) if other != index => {
                Err(format!("load index {index} contradicts {other} in the size: give one of them"))
            }
            _ => Ok(Self { index: Some(index), ..self }),
        }
    }

    /// Load of the index \[kg\].
    pub(crate) fn load(&self) -> Option<u16> {
        load_of_car(self.index?)
    }

    /// Load of the scene \[N\], to 50 N, and where it comes from.
    pub(crate) fn axle_load(&self) -> (f64, String) {
        let (load, reason) = match (self.index, self.load()) {
            (Some(index), Some(load)) => {
                (LOADED * GRAVITY * f64::from(load), format!("{LOADED} of the {load} kg of load index {index}"))
            }
            _ => {
                let Dimensions { circumference, contact_width, sidewall, .. } = self.dimensions();
                let larger = circumference * contact_width / DEFAULT_SIZES.iter().product::<f64>();
                let by_sidewall = (2.0 * sidewall * SIDEWALL_ANGLE.sin() / LOW).min(1.0);
                let reason =
                    "the default tyre's, scaled by circumference and contact width: the size has no load index";
                (DEFAULT_LOAD * larger * by_sidewall, reason.to_owned())
            }
        };
        (50.0 * (load / 50.0).round(), reason)
    }

    fn rim_radius(&self) -> f64 {
        0.0127 * f64::from(self.rim)
    }

    fn diameter(&self) -> f64 {
        2.0 * (self.rim_radius() + 1e-5 * f64::from(self.aspect) * f64::from(self.width))
    }

    fn dimensions(&self) -> Dimensions {
        let inner = 0.5 * self.diameter() - THICKNESS;
        let well = self.rim_radius() - WELL;
        let sidewall = (inner - self.rim_radius() - ABOVE_SEAT) / (2.0 * SIDEWALL_ANGLE.sin());
        let width = 1e-3 * f64::from(self.width) - 2.0 * sidewall * (1.0 - SIDEWALL_ANGLE.cos());
        Dimensions {
            circumference: PI * self.diameter(),
            width,
            contact_width: CONTACT_SHARE * width,
            sidewall,
            air_radius: 0.5 * (well + inner),
            air_depth: AIR_SHARE * (inner - well),
        }
    }

    /// The tyre as a file whose comments say what is published and what is inferred.
    pub(crate) fn file(&self) -> String {
        let (load, key) = match (self.index, self.load()) {
            (Some(index), Some(load)) => (
                format!("; the load of the index {index}, {load} kg [3]"),
                format!("load_index = {index}{:16}# published: {load} kg [3]\n", ""),
            ),
            _ => Default::default(),
        };
        let head = format!(
            "# A tyre of the size {self}, made by its size alone.\n#\n\
             # Published: the size [1, 2]{load}. Inferred: the rest, by\n\
             # rules from dimensions of the default tyre.\n#\n\
             # Nothing was fitted to a sound level, and nothing of this tyre to a measurement: docs/tyres.md has the \
             rules, and what\n# they give for four sizes beside what is published. Sources [1] to [6] are listed \
             there.\n"
        );
        let body = MADE.find(BODY).map_or(MADE, |begin| &MADE[begin..]);
        self.changes().into_iter().fold(head + &key + body, |text, (old, new)| text.replace(old, &new))
    }

    /// Texts of [`MADE`] and their replacements for this size.
    fn changes(&self) -> [(&'static str, String); 8] {
        let Dimensions { circumference, width, contact_width, sidewall, air_radius, air_depth } = self.dimensions();
        [
            ("size, 631.9 mm", format!("size, {:.1} mm", 1e3 * self.diameter())),
            ("55 % of 205 mm", format!("{} % of {} mm", self.aspect, self.width)),
            ("circumference = 1.985", format!("circumference = {circumference:.3}")),
            ("\nwidth = 0.149", format!("\nwidth = {width:.3}")),
            ("contact_width = 0.119", format!("contact_width = {contact_width:.3}")),
            ("rim, 203.2 mm", format!("rim, {:.1} mm", 1e3 * self.rim_radius())),
            ("{ radius = 0.051", format!("{{ radius = {sidewall:.3}")),
            ("{ radius = 0.244, depth = 0.077", format!("{{ radius = {air_radius:.3}, depth = {air_depth:.3}")),
        ]
    }

    /// Published and inferred values, in a few lines.
    pub(crate) fn origins(&self) -> String {
        let Dimensions { circumference, width, contact_width, sidewall, air_depth, .. } = self.dimensions();
        let load = self.load().map_or(String::new(), |load| format!(", load of the index {load} kg"));
        let millimetres = |length: f64| (1e3 * length).round();
        format!(
            "  published  circumference {circumference:.3} m{load}\n  \
             inferred   by rules from the size: width {} mm, of contact {} mm, sidewalls of radius {} mm, air {} mm \
             deep\n  \
             inferred   as in the default tyre: pressure, plies, tread, mass and shear of the sidewalls\n  \
             unknown    everything specific to a make: measure mobilities and fit them (tyrewave fit-tyre)\n",
            millimetres(width),
            millimetres(contact_width),
            millimetres(sidewall),
            millimetres(air_depth)
        )
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;
    use crate::scene::{Scene, Tyre};

    fn size(text: &str) -> TyreSize {
        text.parse().unwrap()
    }

    fn tyre(text: &str) -> Tyre {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tyre.toml");
        fs::write(&path, text).unwrap();
        let loaded = Scene::with_tyre(&path, &[]).unwrap_or_else(|error| panic!("{}", error.render(false)));
        loaded.scene.tyre
    }

    #[test]
    fn the_rules_make_the_tyres_of_the_catalogue_again() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/tyres");
        for (text, file) in [
            ("175/65R14 82", "175_65r14.toml"),
            ("205/55 R16 91V", "205_55r16.toml"),
            ("225/45ZR17 91", "225_45r17.toml"),
            ("P225/60R16 97S", "srtt_225_60r16.toml"),
        ] {
            let mut catalogued = tyre(&fs::read_to_string(folder.join(file)).unwrap());
            let made = tyre(&size(text).file());
            if file.starts_with("175") {
                // The angle of the belt's cords is published.
                catalogued.layers[1].cords.clone_from(&made.layers[1].cords);
            }
            assert!(made == catalogued && made.load_index.is_some(), "{text}: {made:?}");
        }
        // The comments agree, too.
        let body = |text: &str| text[text.find(BODY).unwrap()..].to_owned();
        let catalogued = fs::read_to_string(folder.join("225_45r17.toml")).unwrap();
        assert_eq!(body(&size("225/45R17").file()), body(&catalogued));
        for (old, _) in size("225/45R17").changes() {
            assert_eq!(MADE.matches(old).count(), 1, "{old}");
        }
        assert!(size("225/45R17 91").file().contains("the load of the index 91, 615 kg"));
    }

    #[test]
    fn every_size_of_a_car_makes_a_tyre_that_passes() {
        for (width, aspect, rim) in [(125, 25, 12), (125, 85, 24), (355, 25, 24), (355, 85, 12), (235, 45, 18)] {
            tyre(&size(&format!("{width}/{aspect}R{rim}")).file());
        }
    }

    #[test]
    fn a_load_follows_the_size() {
        for (text, load, words) in [
            ("225/45R17 91 W", 4850, "0.8 of the 615 kg of load index 91"),
            ("225/45 R17", 4500, "no load index"),
            ("245/40 ZR 18 (97Y)", 5750, "load index 97"),
            ("125/80R12 62S", 2100, "load index 62"),
            ("125/25R12", 700, "no load index"),
        ] {
            let (found, reason) = size(text).axle_load();
            assert_eq!(found as i32, load, "{text}");
            assert!(reason.contains(words), "{text}: {reason}");
        }
    }

    #[test]
    fn bad_sizes_are_answered() {
        for (text, words) in [
            ("", "such as 235/45R18"),
            ("235/45", "such as 235/45R18"),
            ("235-45-18", "such as 235/45R18"),
            ("31x10.5R15", "such as 235/45R18"),
            ("235/45R18C", "such as 235/45R18"),
            ("235/45R18 98Y 99Y", "such as 235/45R18"),
            ("235/45R18 heavy", "such as 235/45R18"),
            ("99999999/45R18", "such as 235/45R18"),
            ("23/45R18", "23 mm wide, and car tyres have 125 to 355"),
            ("235/450R18", "450 % high"),
            ("235/45R457", "457 inches in diameter"),
            ("235/45R18 980", "load index 980"),
        ] {
            let reported = text.parse::<TyreSize>().unwrap_err();
            assert!(reported.contains(words), "{text}: {reported}");
        }
        assert!(size("235/45R18 98").with_index(97).unwrap_err().contains("load index 97 contradicts 98 in the size"));
        assert_eq!(size("235/45R18").with_index(98).unwrap().load(), Some(750));
        assert_eq!(
            [60, 91, 126].map(|index| size("235/45R18").with_index(index).unwrap().load().unwrap()),
            [250, 615, 1700]
        );
    }
}

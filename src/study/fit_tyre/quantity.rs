//! Quantity and units of a frequency response in a universal file, and its conversion to a mobility in m/(N s).
//!
//! Numerator and denominator each have a type by number; units follow from dataset 164 (file units per metre, and per
//! newton) or from the label of the axis. The unit exponents of a record count for the type "general" alone, and there
//! they do not distinguish a displacement from a velocity: the label has to.

use std::f64::consts::TAU;

use num_complex::Complex64;

/// File units per metre and per newton, as in dataset 164.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FileUnits {
    pub length: f64,
    pub force: f64,
}

/// An axis of a record: type by number, unit exponents of length and force, label of the units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AxisRecord {
    pub data_type: i64,
    pub exponents: [i64; 2],
    pub label: String,
}

/// Quantity of one side of the ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    /// Order of the time derivative: 0 displacement, 1 velocity, 2 acceleration.
    Motion(i32),
    Force,
}

/// A ratio of motion to force, or its inverse, and its conversion to SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quantity {
    /// Order of the time derivative: 0 receptance, 1 mobility, 2 accelerance.
    order: i32,
    /// True for force over motion.
    inverse: bool,
    to_si: f64,
    /// True if neither dataset 164 nor labels gave the units.
    pub si_assumed: bool,
}

const GRAVITY: f64 = 9.806_65;
const INCH: f64 = 0.0254;
const POUND_FORCE: f64 = 4.448_221_615_260_5;
/// Units of lengths \[m\] and of forces \[N\], by label in lower case.
const LENGTHS: [(&str, f64); 7] =
    [("m", 1.0), ("mm", 1e-3), ("cm", 1e-2), ("um", 1e-6), ("\u{b5}m", 1e-6), ("in", INCH), ("ft", 12.0 * INCH)];
const FORCES: [(&str, f64); 5] = [("n", 1.0), ("kn", 1e3), ("lbf", POUND_FORCE), ("lb", POUND_FORCE), ("kgf", GRAVITY)];
/// Units are the same if their ratio is 1 within this.
const SAME_UNIT: f64 = 1e-3;

impl Side {
    fn of_type(data_type: i64) -> Option<Self> {
        match data_type {
            8 => Some(Self::Motion(0)),
            11 => Some(Self::Motion(1)),
            12 => Some(Self::Motion(2)),
            9 | 13 => Some(Self::Force),
            _ => None,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Motion(0) => "displacement",
            Self::Motion(1) => "velocity",
            Self::Motion(_) => "acceleration",
            Self::Force => "force",
        }
    }

    /// Quantity that a label of units names, and its unit in SI; `None` for an unknown label.
    fn of_label(label: &str) -> Option<(Self, f64)> {
        let text: String = label.to_lowercase().chars().filter(|sign| !" ^*()[]".contains(*sign)).collect();
        if text == "g" || text == "gn" {
            return Some((Self::Motion(2), GRAVITY));
        }
        let unit = |list: &[(&str, f64)], text: &str| list.iter().find(|(name, _)| *name == text).map(|pair| pair.1);
        if let Some(newtons) = unit(&FORCES, &text) {
            return Some((Self::Force, newtons));
        }
        let (length, order) = [("/s2", 2), ("/s\u{b2}", 2), ("/s/s", 2), ("/sec2", 2), ("/s", 1), ("/sec", 1)]
            .into_iter()
            .find_map(|(ending, order)| text.strip_suffix(ending).map(|length| (length, order)))
            .unwrap_or((&text, 0));
        unit(&LENGTHS, length).map(|metres| (Self::Motion(order), metres))
    }

    /// Reads an axis: its quantity, the factor to SI, and whether the file states its units.
    fn of_axis(axis: &AxisRecord, units: Option<FileUnits>) -> Result<(Self, f64, bool), String> {
        let AxisRecord { data_type, exponents, label } = axis;
        let labelled = Self::of_label(label);
        let side = match (Self::of_type(*data_type), labelled) {
            (Some(side), Some((other, _))) if side != other => {
                return Err(format!("its type is {} ({data_type}), its units are {label:?}", side.name()));
            }
            (Some(side), _) | (None, Some((side, _))) => side,
            (None, None) => {
                let exponents = match data_type {
                    1 => format!(", exponents {} of length and {} of force", exponents[0], exponents[1]),
                    _ => String::new(),
                };
                return Err(format!(
                    "its type is {data_type}{exponents}, its units are {label:?}: nothing says whether it is a \
                     displacement (8), a velocity (11), an acceleration (12) or a force (13)"
                ));
            }
        };
        // A general type is converted by its exponents: they must agree with what the label names.
        let expected = if side == Self::Force { [0, 1] } else { [1, 0] };
        if *data_type == 1 && *exponents != [0, 0] && *exponents != expected {
            return Err(format!(
                "its units are {label:?}, its exponents {} of length and {} of force",
                exponents[0], exponents[1]
            ));
        }
        let by_file = units.map(|units| 1.0 / if side == Self::Force { units.force } else { units.length });
        match (by_file, labelled) {
            (Some(file), Some((_, label_unit))) if (file / label_unit - 1.0).abs() > SAME_UNIT => Err(format!(
                "its units are {label:?}, but dataset 164 has {:.6} of them for one of SI; correct one of the two",
                1.0 / file
            )),
            (Some(file), _) => Ok((side, file, true)),
            (None, Some((_, unit))) => Ok((side, unit, true)),
            (None, None) => Ok((side, 1.0, false)),
        }
    }
}

impl Quantity {
    /// Reads numerator and denominator. Unknown or contradicting quantities and units are errors, in words.
    pub(super) fn of(
        numerator: &AxisRecord,
        denominator: &AxisRecord,
        units: Option<FileUnits>,
    ) -> Result<Self, String> {
        let (above, over, above_given) =
            Side::of_axis(numerator, units).map_err(|wrong| format!("record 9 (numerator): {wrong}"))?;
        let (below, under, below_given) =
            Side::of_axis(denominator, units).map_err(|wrong| format!("record 10 (denominator): {wrong}"))?;
        let (order, inverse) = match (above, below) {
            (Side::Motion(order), Side::Force) => (order, false),
            (Side::Force, Side::Motion(order)) => (order, true),
            _ => return Err(format!("it is {} over {}, not motion over force", above.name(), below.name())),
        };
        Ok(Self { order, inverse, to_si: over / under, si_assumed: !(above_given && below_given) })
    }

    /// Name of the ratio, for reports.
    pub(super) fn name(self) -> &'static str {
        match (self.order, self.inverse) {
            (0, false) => "receptance",
            (1, false) => "mobility",
            (_, false) => "accelerance",
            (0, true) => "dynamic stiffness",
            (1, true) => "impedance",
            (_, true) => "apparent mass",
        }
    }

    /// Converts a value at a frequency \[Hz\] to a mobility \[m/(N s)\].
    pub(super) fn mobility(self, value: Complex64, frequency: f64) -> Complex64 {
        let ratio = if self.inverse { (self.to_si * value).inv() } else { self.to_si * value };
        match self.order {
            1 => ratio,
            order => ratio * Complex64::new(0.0, TAU * frequency).powi(1 - order),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(data_type: i64, label: &str) -> AxisRecord {
        AxisRecord { data_type, exponents: [0, 0], label: label.to_owned() }
    }

    #[test]
    fn every_quantity_of_an_oscillator_becomes_its_mobility() {
        let (frequency, value) = (80.0, Complex64::new(0.002, 0.003));
        let i_omega = Complex64::new(0.0, TAU * frequency);
        for (above, below, measured) in [
            (axis(8, "NONE"), axis(13, "NONE"), value / i_omega),
            (axis(11, ""), axis(13, ""), value),
            (axis(12, "m/s^2"), axis(13, "N"), value * i_omega),
            (axis(12, "g"), axis(13, "lbf"), value * i_omega / GRAVITY * POUND_FORCE),
            (axis(8, "mm"), axis(13, "kN"), value / i_omega * 1e6),
            (axis(0, "(in/s)"), axis(9, "N"), value / INCH),
            (axis(13, ""), axis(8, ""), i_omega / value),
            (axis(13, ""), axis(11, ""), value.inv()),
            (axis(13, ""), axis(12, ""), (value * i_omega).inv()),
        ] {
            let found = Quantity::of(&above, &below, None).unwrap().mobility(measured, frequency);
            assert!((found - value).norm() < 1e-12 * value.norm(), "{above:?} over {below:?}: {found}");
        }
        // File units per metre and per newton: millimetres and kilonewtons.
        let units = Some(FileUnits { length: 1e3, force: 1e-3 });
        let quantity = Quantity::of(&axis(11, "mm/s"), &axis(13, ""), units).unwrap();
        assert!((quantity.mobility(value * 1e6, frequency) - value).norm() < 1e-12 && !quantity.si_assumed);
        assert!(Quantity::of(&axis(11, ""), &axis(13, "N"), None).unwrap().si_assumed);
    }

    #[test]
    fn missing_or_contradictory_quantities_are_refused() {
        let units = |length| Some(FileUnits { length, force: 1.0 });
        let general = AxisRecord { data_type: 1, exponents: [1, 0], label: "NONE".to_owned() };
        let cubed = AxisRecord { data_type: 1, exponents: [3, 0], label: "m".to_owned() };
        for (above, below, units, words) in [
            (axis(11, "m/s^2"), axis(13, "N"), None, "velocity (11), its units are \"m/s^2\""),
            (axis(0, ""), axis(13, "N"), None, "nothing says whether"),
            (general, axis(13, "N"), None, "exponents 1 of length"),
            (cubed, axis(13, "N"), None, "exponents 3 of length"),
            (axis(12, "g"), axis(13, "N"), units(1.0), "dataset 164"),
            (axis(15, "Pa"), axis(13, "N"), None, "its type is 15"),
            (axis(12, ""), axis(12, ""), None, "acceleration over acceleration"),
        ] {
            let reported = Quantity::of(&above, &below, units).unwrap_err();
            assert!(reported.contains(words), "{words}: {reported}");
        }
    }
}

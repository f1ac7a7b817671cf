//! `sections.csv`: values of the sections of a run's road, a row each, and `sections.svg`, the strip chart of them.

use serde::Deserialize;

use super::plots::{StripChart, StripPanel, StripSection, StripSeries};
use super::table::{csv_rows, optional};

pub(crate) const SECTIONS_FILE: &str = "sections.csv";
pub(crate) const SECTIONS_PICTURE: &str = "sections.svg";

/// Header of the table. `begin_m` and `end_m` are road coordinates under the axle; `nominal_hz` is that of a third
/// octave of the force, `wavelength_mm` that of the texture, and both are empty for overall values.
pub(crate) const SECTIONS_HEADER: &str = "section,begin_m,end_m,speed_kmh,quantity,receiver,nominal_hz,wavelength_mm,\
                                          value,unit,standard_error,valid\n";

/// A quantity of sections: its name in the table, and its unit.
pub(crate) type SectionQuantity = [&'static str; 2];

pub(crate) const MEAN_FORCE: SectionQuantity = ["mean_force", "N"];
pub(crate) const SECTION_FORCE: SectionQuantity = ["force_level", "dB re 1 N"];
pub(crate) const SECTION_SOUND: SectionQuantity = ["sound_level_a", "dB(A)"];
pub(crate) const SECTION_DEPTH: SectionQuantity = ["mean_profile_depth", "mm"];
pub(crate) const SECTION_TEXTURE: SectionQuantity = ["texture_level", "dB re 1e-6 m"];
pub(crate) const SECTION_MACROTEXTURE: SectionQuantity = ["macrotexture_level", "dB re 1e-6 m"];
pub(crate) const SECTION_MEGATEXTURE: SectionQuantity = ["megatexture_level", "dB re 1e-6 m"];

/// A section of a run's road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Section {
    /// Number, from 1.
    pub number: u64,
    /// Road coordinates under the axle at its begin and end \[m\].
    pub ends: [f64; 2],
    /// Rolling speed \[km/h\].
    pub speed_kmh: f64,
}

/// Value of a section.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SectionValue<'a> {
    pub quantity: SectionQuantity,
    /// Name of the receiver, for sound.
    pub receiver: &'a str,
    /// Nominal mid-frequency \[Hz\] of a third octave of the force, nominal wavelength \[mm\] of one of the texture.
    pub place: [Option<f64>; 2],
    /// Value in the unit of its quantity.
    pub value: f64,
    /// Standard error in the same unit; `None` where it is not known.
    pub error: Option<f64>,
    pub valid: bool,
}

impl SectionValue<'_> {
    /// A valid overall value.
    pub(crate) fn overall(quantity: SectionQuantity, value: f64, error: Option<f64>) -> Self {
        Self { quantity, receiver: "", place: [None; 2], value, error, valid: true }
    }
}

impl Section {
    /// Rows of the table with some values of the section.
    pub(crate) fn rows<'a>(&self, values: impl IntoIterator<Item = SectionValue<'a>>) -> String {
        csv_rows(values.into_iter().map(|SectionValue { quantity, receiver, place, value, error, valid }| {
            // To a micrometre, without what rounding adds.
            let ([name, unit], [begin, end]) = (quantity, self.ends.map(|end| ((1e6 * end).round() / 1e6).to_string()));
            let [frequency, wavelength, error] = [place[0], place[1], error].map(optional);
            let (number, speed) = (self.number.to_string(), self.speed_kmh.to_string());
            let (value, valid) = (value.to_string(), u8::from(valid).to_string());
            let [name, receiver, unit] = [name, receiver, unit].map(str::to_owned);
            [number, begin, end, speed, name, receiver, frequency, wavelength, value, unit, error, valid]
        }))
    }
}

/// Overall value in a row of the table.
#[derive(Deserialize)]
struct OverallRow {
    begin_m: f64,
    end_m: f64,
    quantity: String,
    receiver: String,
    nominal_hz: Option<f64>,
    wavelength_mm: Option<f64>,
    value: Option<f64>,
    standard_error: Option<f64>,
    valid: u8,
}

/// Strip chart of the overall values of a table; `None` without any.
pub(crate) fn strip_chart(table: &str, title: &str) -> Option<String> {
    let rows = csv::Reader::from_reader(table.as_bytes()).into_deserialize::<OverallRow>();
    let is_overall = |row: &OverallRow| row.nominal_hz.is_none() && row.wavelength_mm.is_none() && row.valid > 0;
    let rows: Vec<OverallRow> = rows.filter_map(Result::ok).filter(is_overall).collect();
    let series = |name, [quantity, _]: SectionQuantity, receiver: &str| StripSeries {
        name,
        sections: rows
            .iter()
            .filter(|row| row.quantity == quantity && row.receiver == receiver)
            .filter_map(|row| {
                let error = row.standard_error.unwrap_or(0.0);
                Some(StripSection { ends: [row.begin_m, row.end_m], value: row.value?, error })
            })
            .collect(),
    };
    let mut receivers: Vec<&str> = Vec::new();
    for row in rows.iter().filter(|row| row.quantity == SECTION_SOUND[0]) {
        if !receivers.contains(&row.receiver.as_str()) {
            receivers.push(&row.receiver);
        }
    }
    let sound = receivers.into_iter().map(|receiver| series(receiver, SECTION_SOUND, receiver)).collect();
    let texture = [("macrotexture", SECTION_MACROTEXTURE), ("megatexture", SECTION_MEGATEXTURE)];
    let texture = texture.map(|(name, quantity)| series(name, quantity, ""));
    let texture = texture.into_iter().filter(|series| !series.sections.is_empty()).collect();
    let panels = vec![
        StripPanel { title: "Force [dB re 1 N]", series: vec![series("", SECTION_FORCE, "")] },
        StripPanel { title: "Sound [dB(A)]", series: sound },
        StripPanel { title: "Profile depth [mm]", series: vec![series("", SECTION_DEPTH, "")] },
        StripPanel { title: "Texture [dB re 1 µm]", series: texture },
    ];
    StripChart { title, along: "Distance along the road [m]", panels }.to_svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overall_values_are_drawn_and_bands_are_not() {
        let section = |number: u64| Section {
            number,
            ends: [0.1 + 20.0 * (number as f64 - 1.0), 0.1 + 20.0 * number as f64],
            speed_kmh: 80.0,
        };
        let band = SectionValue {
            place: [Some(1250.0), None],
            valid: false,
            ..SectionValue::overall(SECTION_FORCE, 99.0, None)
        };
        let sound = SectionValue { receiver: "cpx, left", ..SectionValue::overall(SECTION_SOUND, 91.5, Some(0.25)) };
        let values = [SectionValue::overall(SECTION_FORCE, 50.25, Some(0.5)), band, sound];
        let rows: String = (1..3).map(|number| section(number).rows(values.clone())).collect();
        assert!(rows.starts_with("1,0.1,20.1,80,force_level,,,,50.25,dB re 1 N,0.5,1\n"), "{rows}");
        assert!(rows.contains("\n1,0.1,20.1,80,force_level,,1250,,99,dB re 1 N,,0\n"), "{rows}");
        let svg = strip_chart(&format!("{SECTIONS_HEADER}{rows}"), "Title").unwrap();
        assert_eq!(svg.matches("<polygon").count(), 2, "{svg}");
        assert!(svg.contains(">cpx, left<") && svg.contains("Title") && !svg.contains(">99"), "{svg}");
        assert_eq!(strip_chart(SECTIONS_HEADER, "Title"), None);
    }
}

//! Radiation of a tyre as JSON, for scripts.

use serde_json::{Value, json};

use crate::response::pressure::PressureShares;
use crate::study::radiation::{AHEAD, AtFrequency, CIRCLE, Radiator, named_receivers};

/// Number of angles around the tyre up to which shares are given.
const ANGLES: usize = 72;

/// Radiation of a tyre, frequency by frequency, as JSON in SI units.
pub(crate) fn radiation_record(title: &str, radiator: &Radiator, found: &[AtFrequency]) -> Value {
    let receiver = |(name, position)| json!({ "name": name, "position": position });
    let parts = |shares: &PressureShares| {
        let pressures = shares.parts.map(|part| part.norm());
        let of = shares.of_parts().into_iter().zip(pressures).zip(PressureShares::PARTS);
        of.map(|((share, pressure), part)| (part, json!({ "share": share, "pressure": pressure }))).collect::<Value>()
    };
    let of_frequency = |at: &AtFrequency| {
        json!({
            "frequency": at.frequency,
            "transfer": at.transfers,
            "horn": at.horn,
            "circle": at.circle,
            "pressure": at.shares.iter().map(|shares| shares.pressure.norm()).collect::<Vec<_>>(),
            "share_up_to_wave": at.shares.iter().map(PressureShares::up_to_wave).collect::<Vec<_>>(),
            "share_up_to_angle": at.shares.iter().map(|shares| shares.up_to_angle(ANGLES)).collect::<Vec<_>>(),
            "parts": at.shares.iter().map(parts).collect::<Vec<_>>(),
            "unknowns": at.unknowns,
            "reciprocal_condition": at.reciprocal_condition,
        })
    };
    json!({
        "title": title,
        "patch_length": radiator.patch_length(),
        "ahead": AHEAD,
        "receivers": named_receivers(radiator.width()).map(receiver),
        "circle": { "radius": CIRCLE[0], "height": CIRCLE[1] },
        "frequencies": found.iter().map(of_frequency).collect::<Vec<_>>(),
    })
}

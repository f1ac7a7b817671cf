//! Consistency of the air under the patch with the rest of a scene.

use super::problem::Problem;
use super::table::Table;
use super::{AirPumping, BlockModel, PatchAir, RadiationQuality, Scene, Switch, Tread, Zone};

/// Refuses air paths under the patch that the rest of the scene rules out; `None` after a complaint.
pub(super) fn check(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let complain =
        |key: &str, wrong: &str, right: &str| table.complain::<()>(key, Problem::new(wrong.to_owned(), right));
    let is_open = matches!(&scene.air_pumping, Some(AirPumping { patch, .. }) if *patch != PatchAir::Sealed);
    let squeezes = scene.air_pumping.as_ref().is_some_and(|pumping| pumping.squeeze);
    if !is_open {
        if squeezes && scene.effects.air_pumping != Switch::Off {
            let wrong = "the patch is sealed: air that blocks press out cannot radiate";
            return complain("air_pumping.squeeze", wrong, "add patch = \"grooves\", or leave this out");
        }
        if scene.effects.air_pumping == Switch::On {
            let right = "\"auto\" or \"off\", or a table [air_pumping] with patch = \"grooves\"";
            return complain("effects.air_pumping", "there is no [air_pumping] that opens the patch", right);
        }
        return Some(());
    }
    if scene.effects.air_pumping == Switch::Off {
        return Some(());
    }
    let sealed = "leave [air_pumping] out";
    if scene.receivers.is_empty() {
        let right = "add a [[receiver]], or leave this out";
        return complain("air_pumping", "there is no [[receiver]] for its sound", right);
    }
    let (radiation, pattern) = (&scene.radiation, scene.tread_pattern.as_ref());
    let has_grooves = pattern.is_some_and(|pattern| pattern.grooves.iter().any(|groove| groove.depth > 0.0));
    let takes_voids = scene.air_pumping.as_ref().is_some_and(|pumping| pumping.patch == PatchAir::Voids);
    let missing = match pattern {
        _ if has_grooves || takes_voids => None,
        Some(pattern) if pattern.file.is_some() => Some("a raster does not say which of its voids run round the tyre"),
        _ => Some("there are no grooves that run round the tyre"),
    };
    let are_compliant = pattern.is_some_and(|pattern| pattern.blocks == BlockModel::Compliant);
    let compliant = "tread_pattern.blocks = \"compliant\", or leave this out";
    let springs = "springs do not conserve volume: the air under them would be moved by more than the tread";
    let refused = [
        (missing.is_some(), "air_pumping.patch", missing.unwrap_or_default(), "give tread_pattern.grooves"),
        (
            takes_voids && scene.contact.zone != Zone::Cells,
            "air_pumping.patch",
            "slices do not resolve where tread and road touch across",
            "contact.zone = \"cells\", or \"grooves\"",
        ),
        (scene.contact.tread != Tread::Elastic, "contact.tread", springs, "\"elastic\", or leave [air_pumping] out"),
        (
            radiation.acoustic_gap > 0.0,
            "radiation.acoustic_gap",
            "a patch is open by its grooves or by a slit, not by both",
            sealed,
        ),
        (
            radiation.quality == RadiationQuality::Draft,
            "radiation.quality",
            "a draft computes no field at the openings of the grooves",
            "\"full\", or leave [air_pumping] out",
        ),
        (
            squeezes && scene.contact.zone != Zone::Cells,
            "air_pumping.squeeze",
            "slices have no compliant blocks",
            "contact.zone = \"cells\", or leave this out",
        ),
        (
            squeezes && !are_compliant,
            "air_pumping.squeeze",
            "blocks as stiff as an uncut tread press no air out",
            compliant,
        ),
    ];
    let mut fits = Some(());
    for (_, key, wrong, right) in refused.into_iter().filter(|(is_refused, ..)| *is_refused) {
        fits = complain(key, wrong, right);
    }
    fits
}

//! The page of a sweep: levels against what is varied, third octaves and sounds of its runs, its tables.

use std::collections::BTreeSet;

use maud::{Markup, html};
use serde_json::json;

use super::compare::Comparison;
use super::html::{article, document, figure, report, table};
use super::page::curves;
use super::sections::player;
use crate::effects::stored::Stored;
use crate::effects::{EFFECTS, ReportError, SectionBlock};
use crate::results::sound::SOUND_LEVEL;
use crate::results::spectra::FORCE_LEVEL;
use crate::study::sweep::table::{MOST_SPECTRA, growth_plot, side_by_side};
use crate::study::sweep::{Done, Label, RepeatedTable, StoredSweep, blocks};

/// Largest total size of the sound files in a page; the others stay in their folders \[bytes\].
const MOST_SOUND: usize = 24 << 20;

/// Caption of levels against what is varied.
const LEVELS: &str = "Levels in dB, over the bands that are valid in every run, so that they may differ from those of \
                      the tables: at the receivers A-weighted, the maximum of a pass-by or else the mean; of the \
                      contact force. Several seeds are one point, their mean; its bar is the 95 % interval of that \
                      mean. Without a bar the interval is not known: a single run.";

impl StoredSweep {
    /// HTML page of the sweep.
    ///
    /// # Errors
    /// [`ReportError`].
    pub(crate) fn page(&self) -> Result<String, ReportError> {
        let found = |stored: &Stored| {
            let levels = stored.spectrum(FORCE_LEVEL, "").map_or_else(Vec::new, |spectrum| spectrum.levels.clone());
            let receiver_levels = stored.spectra.iter().filter(|spectrum| spectrum.quantity == SOUND_LEVEL);
            let receiver_levels: Vec<_> =
                receiver_levels.map(|spectrum| (spectrum.name.clone(), spectrum.levels.clone())).collect();
            Done::new(true, levels, &receiver_levels, &json!(stored.summary))
        };
        let runs: Vec<(Label, Option<Done>)> =
            self.variants.iter().map(|(label, stored)| (label.clone(), stored.as_ref().map(found))).collect();
        let (blocks, means) = (blocks(&runs), RepeatedTable::of(&runs));
        let mut against = means.curves(&self.title);
        if against.is_empty() {
            against = means.plots(&self.title).into_iter().map(|(_, svg)| svg).collect();
        }
        let growth = if blocks.len() > MOST_SPECTRA { None } else { growth_plot(&blocks, "Growth with the speed") };
        let tables = RepeatedTable::new(&runs).map_or_else(|| side_by_side(&blocks), |means| means.report());
        let (names, shown, of_all) = self.shown();
        let third_octaves = third_octaves(&names, &shown)?;
        let sounds = sounds(&names, &shown)?;
        let missing = runs.iter().filter(|(_, done)| done.is_none()).count();
        let lead = html! {
            p { "A sweep of " (runs.len()) " runs: " (self.varied()) "." }
            @if missing > 0 { p.warning { "Not finished and not shown: " (missing) " of them." } }
        };
        let caption = "Growth of each third octave of the contact force in dB per decade of speed, by least squares. \
                       Grey: from bands that are not valid in a run.";
        let words = |more: &str| html! { p { (of_all) (more) } };
        let below = |lead: Markup, content: Markup| {
            if content.0.is_empty() {
                content
            } else {
                html! { (lead) (content) }
            }
        };
        let sections = [
            ("Levels", html! { @for svg in &against { (figure(svg, LEVELS)) } }),
            ("Third octaves", below(words(""), third_octaves)),
            ("Sound", below(words(" Players of a receiver share one scale: loudness can be compared."), sounds)),
            ("Growth with the speed", html! { @if let Some(svg) = growth { (figure(&svg, caption)) } }),
            ("Tables", report(&tables)),
        ];
        let sections = sections.map(|(heading, content)| (heading.to_owned(), content));
        let content = article(0, &self.title, &lead, sections);
        Ok(document(&self.title, &content))
    }

    /// Factors in words, each with its values or their number and ends.
    fn varied(&self) -> String {
        let factors = self.variants.first().map_or(&[][..], |(label, _)| &label.choices);
        let words = factors.iter().enumerate().map(|(place, choice)| {
            let all = self.variants.iter().filter_map(|(label, _)| Some(label.choices.get(place)?.value.as_str()));
            let mut seen = BTreeSet::new();
            let values: Vec<&str> = all.filter(|value| seen.insert(*value)).collect();
            match values.as_slice() {
                [first, .., last] if values.len() > MOST_SPECTRA => {
                    format!("{} with {} values, {first} to {last}", choice.factor, values.len())
                }
                values => format!("{} = {}", choice.factor, values.join(", ")),
            }
        });
        words.collect::<Vec<_>>().join("; ")
    }

    /// Names and results of the runs whose third octaves and sounds are shown, and a sentence on the selection: of
    /// several seeds the first, of many combinations some at equal distances.
    fn shown(&self) -> (Vec<String>, Vec<Stored>, String) {
        let (mut seen, mut shown) = (BTreeSet::new(), Vec::<(String, &Stored)>::new());
        let finished = || self.variants.iter().filter_map(|(label, stored)| Some((label, stored.as_ref()?)));
        for (label, stored) in finished() {
            let settings = label.settings();
            if seen.insert(settings.clone()) {
                shown.push((if settings.is_empty() { stored.name() } else { settings }, stored));
            }
        }
        if shown.len() > MOST_SPECTRA {
            let last = shown.len() - 1;
            shown = (0..MOST_SPECTRA).map(|place| shown[place * last / (MOST_SPECTRA - 1)].clone()).collect();
        }
        let (some, all) = (shown.len(), finished().count());
        let seeds = if some < all && seen.len() < all { ", of several seeds the first" } else { "" };
        let words = if some < all { format!("{some} of {all} runs{seeds}.") } else { "All runs.".to_owned() };
        let (names, shown) = shown.into_iter().map(|(name, stored)| (name, stored.clone())).unzip();
        (names, shown, words)
    }
}

/// Third octaves of sound and force of all runs, with their differences from the first run of the same speed; the first
/// run of each speed is compared with none.
fn third_octaves(names: &[String], shown: &[Stored]) -> Result<Markup, ReportError> {
    let of = Comparison { names: names.to_vec(), ..Comparison::of(shown) };
    let speed = |stored: &Stored| stored.plan.scene.rolling.speed_kmh;
    let first = |stored: &Stored| shown.iter().position(|other| speed(other).total_cmp(&speed(stored)).is_eq());
    let references = shown.iter().enumerate().map(|(index, stored)| first(stored).filter(|first| *first != index));
    let references: Vec<Option<usize>> = references.collect();
    let mut parts = Vec::new();
    for spectrum in of.spectra.iter().filter(|spectrum| [SOUND_LEVEL, FORCE_LEVEL].contains(&spectrum.quantity)) {
        parts.push((curves(shown, &of, spectrum, &references)?, of.spectrum_table(spectrum)));
    }
    Ok(html! {
        @for (curves, levels) in &parts {
            @for (svg, caption) in curves { (figure(svg, caption)) }
            details { summary { "The levels as a table" } (table(levels)) }
        }
    })
}

/// Players of all runs side by side, receiver by receiver, up to [`MOST_SOUND`].
fn sounds(names: &[String], shown: &[Stored]) -> Result<Markup, ReportError> {
    let (mut room, mut left_out, mut receivers) = (MOST_SOUND, Vec::new(), Vec::<(String, Vec<Markup>)>::new());
    for (name, stored) in names.iter().zip(shown) {
        for section in EFFECTS.into_iter().map(|effect| effect.sections(stored, shown)) {
            for block in section?.into_iter().flat_map(|section| section.blocks) {
                let SectionBlock::Sound { words, file, bytes } = block else { continue };
                if bytes.len() > room {
                    left_out.push(format!("{}/{file} ({:.1} MB)", stored.name(), 1e-6 * bytes.len() as f64));
                    continue;
                }
                room -= bytes.len();
                let words = words.trim_end_matches([':', ' ']);
                let (receiver, length) = words.split_once(", ").unwrap_or((words, ""));
                let played = html! { div { dt { (name) ", " (length) } dd { (player(&bytes)) } } };
                match receivers.iter_mut().find(|(other, _)| other == receiver) {
                    Some((_, players)) => players.push(played),
                    None => receivers.push((receiver.to_owned(), vec![played])),
                }
            }
        }
    }
    Ok(html! {
        @for (receiver, players) in &receivers {
            h3 { (receiver) }
            dl.figures.players { @for player in players { (player) } }
        }
        @if !left_out.is_empty() {
            p {
                "A page holds " (MOST_SOUND >> 20) " MB of sound. These files stay in the folder of the sweep: "
                (left_out.join(", ")) "."
            }
        }
    })
}

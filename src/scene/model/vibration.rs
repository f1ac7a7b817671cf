//! `[outputs.vibration]`: what is wanted of the tyre's vibration.

use serde::{Deserialize, Serialize};

use crate::scene::Problem;
use crate::scene::keys::keys;
use crate::scene::kind::{Bounds, Flag, NumberList, OneOf, Whole};
use crate::scene::table::{Keys, Nested, Table};

keys! {
    /// Which velocities, means across the contact strip, are computed from the contact forces, and how they are shown.
    /// A scene without this table computes none.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub Vibration {
        /// Normal velocity of the tread surface, local deformation included.
        tread: bool = true => Flag,
        /// Normal velocity of the belt's inner face.
        belt: bool = true => Flag,
        /// Tangential velocity of the tread surface under the normal forces.
        tangential: bool = false => Flag,
        /// The frames of the spectra.
        frames: Frames = Frames::Both => OneOf::new(),
        /// Positions along the circumference from the axle, positive in the rolling direction, at which spectra of the
        /// non-rotating frame are wanted \[m\].
        #[serde(skip_serializing_if = "Vec::is_empty")]
        points: Vec<f64> = Vec::new() => NumberList(Bounds::any("m").plausible(1e-9, 1e3)),
        /// Numbers 0..N of elements at which spectra of the material frame are wanted: points that turn with the tyre.
        /// The element e meets the road at the distance e dx from its beginning.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        elements: Vec<usize> = Vec::new() => NumberList(Whole::least(0)),
        /// Maps over wavenumber and frequency.
        map: bool = false => Flag,
        /// Length of the averaged segments, brought to whole revolutions \[s\]; by default for a resolution of 1 Hz,
        /// fine compared with any resonance of rubber.
        segment: f64 = 1.0 => Bounds::positive("s").plausible(1e-4, 1e4),
        /// Over contact.zone = "cells": largest share of the mean square velocity in waves across the strip that are
        /// left out, for forces that are independent from cell to cell; 0.02 by default, below 0.1 dB.
        lateral_tolerance?: f64 => Bounds::inside(0.0, 1.0, ""),
    }
}

pub(in crate::scene) const VIBRATION: Nested<Vibration> =
    Nested::new("[outputs.vibration]", "the table [outputs.vibration]").read_by(vibration);

impl Vibration {
    /// Default of [`Self::lateral_tolerance`].
    pub const LATERAL_TOLERANCE: f64 = 0.02;
}

fn vibration(table: &mut Table<'_>) -> Option<Vibration> {
    let read = Vibration::read(table)?;
    if !(read.tread || read.belt || read.tangential) {
        let wrong = "neither tread, belt nor tangential velocity is wanted";
        let right = "tread = true, belt = true or tangential = true, or leave the table out";
        return table.complain_here(Problem::new(wrong, right));
    }
    if !read.points.is_empty() && !read.frames.non_rotating() {
        let right = "frames = \"both\" or \"non-rotating\", or leave the points out";
        return table.complain("points", Problem::does_not_belong("frames = \"material\"", right));
    }
    if !read.elements.is_empty() && !read.frames.material() {
        let right = "frames = \"both\" or \"material\", or leave the elements out";
        return table.complain("elements", Problem::does_not_belong("frames = \"non-rotating\"", right));
    }
    Some(read)
}

/// Frame of the observer of the vibration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Frames {
    /// Both of the following.
    #[default]
    Both,
    /// Frame of an observer on the tread.
    Material,
    /// Frame of an observer beside the road who moves along with the axle.
    NonRotating,
}

impl Frames {
    /// True if spectra in the material frame are wanted.
    pub const fn material(self) -> bool {
        matches!(self, Self::Both | Self::Material)
    }

    /// True if spectra in the non-rotating frame are wanted.
    pub const fn non_rotating(self) -> bool {
        matches!(self, Self::Both | Self::NonRotating)
    }
}

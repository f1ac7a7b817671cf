//! The stages of a run.

use serde::Serialize;

/// A stage of the pipeline, in the order of the data's way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Surface compliance summed to influence functions; convolution weights; a fitted model read from the cache.
    Influence,
    /// Poles fitted to the influence functions.
    Fit,
    /// Reading or making the road and resampling it.
    Road,
    /// Stiffness curves of the road slices.
    Slices,
    /// Waiting for road that is being made in the background.
    RoadWait,
    /// Static solution and axle height.
    Axle,
    /// Displacement left over from past forces, without its transforms.
    History,
    /// Transforms of forces and displacements between elements and wavenumbers.
    Transforms,
    /// Displacement that the road slices ask for.
    Penetration,
    /// Active-set search, its factorisations left out.
    ActiveSet,
    /// Factorisations of active-set matrices.
    Factorisation,
    /// Spectra of the vibration from the patch forces.
    Vibration,
    /// Boundary elements, and from them the pressures for unit forces.
    Radiation,
    /// Sound pressures from the patch forces.
    Sound,
    /// Writing arrays.
    Output,
    /// Spectra and plots.
    Response,
}

impl Stage {
    /// All stages in order.
    pub const ALL: [Self; 16] = [
        Self::Influence,
        Self::Fit,
        Self::Road,
        Self::Slices,
        Self::RoadWait,
        Self::Axle,
        Self::History,
        Self::Transforms,
        Self::Penetration,
        Self::ActiveSet,
        Self::Factorisation,
        Self::Vibration,
        Self::Radiation,
        Self::Sound,
        Self::Output,
        Self::Response,
    ];

    /// The stages that every time step goes through, in order.
    pub const OF_A_STEP: [Self; 10] = [
        Self::Road,
        Self::Slices,
        Self::History,
        Self::Transforms,
        Self::Penetration,
        Self::ActiveSet,
        Self::Factorisation,
        Self::Vibration,
        Self::Sound,
        Self::Output,
    ];

    /// The stage named as people read it in a table.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Influence => "sum influence functions",
            Self::Fit => "fit poles",
            Self::Road => "make or read the road",
            Self::Slices => "build slice stiffness curves",
            Self::RoadWait => "wait for the road",
            Self::Axle => "find the axle height",
            Self::History => "convolve the force history",
            Self::Transforms => "transform the force history",
            Self::Penetration => "press into the road slices",
            Self::ActiveSet => "search the active set",
            Self::Factorisation => "factorise",
            Self::Vibration => "transform to vibration",
            Self::Radiation => "solve for the radiation",
            Self::Sound => "transform to sound",
            Self::Output => "write arrays",
            Self::Response => "compute spectra and plots",
        }
    }

    /// The stage that it is a part of. Times and work of the two are told apart; the whole is their sum.
    pub const fn part_of(self) -> Option<Self> {
        match self {
            Self::Factorisation => Some(Self::ActiveSet),
            _ => None,
        }
    }
}

/// What a run is about while it goes through its stages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// From the scene to a contact at rest.
    #[default]
    Prepare,
    /// Time step by time step.
    Contact,
    /// Arrays completed, spectra, plots, summary.
    Results,
}

impl Phase {
    /// All phases in order.
    pub const ALL: [Self; 3] = [Self::Prepare, Self::Contact, Self::Results];

    /// The phase in a word.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Prepare => "prepare",
            Self::Contact => "contact",
            Self::Results => "results",
        }
    }
}

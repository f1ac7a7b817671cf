//! The stages of a run.

use super::catalogue::catalogue;

catalogue! {
    /// A stage of the pipeline, in the order of the data flow.
    pub enum Stage,
    /// Name of the stage in printed tables.
    title {
        /// Surface compliance summed to influence functions; convolution weights; a fitted model read from the cache.
        Influence => "sum influence functions",
        /// Poles fitted to the influence functions.
        Fit => "fit poles",
        /// Reading or making the road, and resampling it.
        Road => "make or read the road",
        /// Stiffness curves of the road slices.
        Slices => "build slice stiffness curves",
        /// Waiting for road that is being made in the background.
        RoadWait => "wait for the road",
        /// Static solution and axle height.
        Axle => "find the axle height",
        /// Displacement due to past forces, without its transforms.
        History => "convolve the force history",
        /// Transforms of forces and displacements between elements and wavenumbers.
        Transforms => "transform the force history",
        /// Displacement that the road slices require.
        Penetration => "press into the road slices",
        /// Active-set search, its factorisations left out.
        ActiveSet => "search the active set",
        /// Factorisations of active-set matrices.
        Factorisation => "factorise",
        /// Spectra of the vibration from the patch forces.
        Vibration => "transform to vibration",
        /// Boundary-element solution, or reading it from the cache, and the tyre's waves.
        Radiation => "solve for the radiation",
        /// Sound pressures from the patch forces.
        Sound => "transform to sound",
        /// Writing arrays.
        Output => "write arrays",
        /// Spectra and plots.
        Response => "compute spectra and plots",
    }
}

impl Stage {
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

    /// The stage that this one is a part of. Times and work of the two are counted apart; the whole is their sum.
    pub const fn part_of(self) -> Option<Self> {
        match self {
            Self::Factorisation => Some(Self::ActiveSet),
            _ => None,
        }
    }
}

catalogue! {
    /// Section of a run, each with its stages.
    #[derive(Default)]
    pub enum Phase,
    /// Name of the phase, one word.
    title {
        /// From the scene to a contact at rest.
        #[default]
        Prepare => "prepare",
        /// Time step by time step.
        Contact => "contact",
        /// Arrays completed, spectra, plots, summary.
        Results => "results",
    }
}

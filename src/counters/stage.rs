//! Stages of a run, which are timed, and exact counters of its work.

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

catalogue! {
    /// An exact work counter.
    pub enum Counter,
    /// Name of the counter in printed tables.
    title {
        /// Evaluations of the layered compliance at one wavenumber and one s.
        ComplianceEvaluations => "compliance evaluations",
        /// Poles of the rational models, conjugates counted.
        Poles => "poles of the influence functions",
        /// Multiply-adds of the convolution over past forces.
        HistoryMultiplyAdds => "history multiply-adds",
        /// Road slices made.
        Slices => "road slices",
        /// Time steps.
        Steps => "time steps",
        /// Active-set iterations (linear solves).
        Solves => "linear solves",
        /// Factorisations of an active-set matrix.
        Factorisations => "factorisations",
        /// Factorisations of a band of an active-set matrix, whose solutions are corrected iteratively.
        Bands => "factorisations of a band",
        /// Bands whose corrections converged too slowly: the whole matrix was factorised, too.
        Refactorisations => "bands given up for the whole matrix",
        /// Active sets whose factor was cached.
        CacheHits => "factor cache hits",
        /// Active sets whose factor was not cached.
        CacheMisses => "factor cache misses",
        /// Active sets solved with the cached factor of a set that differs by few points.
        Neighbours => "misses that a neighbour's factor served",
        /// Factors dropped from the cache.
        CacheEvictions => "factor cache evictions",
        /// Steps in which the least-index fallback took over.
        Fallbacks => "least-index fallbacks",
        /// Steps in which an outermost candidate of the window carried force: the window may be too short.
        WindowEdgeContacts => "steps with contact at the window's edge",
        /// Fourier transforms of the vibration, over time and over the elements.
        VibrationTransforms => "transforms of the vibration",
        /// Velocities for unit force evaluated, by wavenumber and frequency.
        VibrationEvaluations => "evaluations of the vibration's transfers",
        /// Frequencies at which boundary elements were solved.
        RadiationSolves => "frequencies of the radiation solved",
        /// Evaluations of the acoustic kernel between two nodes.
        RadiationKernels => "kernels of the radiation",
        /// Fourier transforms of the sound, over time.
        SoundTransforms => "transforms of the sound",
        /// Passes over the transfers to all receivers, each for all blocks of the sound that wait.
        SoundPasses => "passes over the sound's transfers",
        /// Bytes written to result arrays.
        BytesWritten => "bytes written",
    }
}

impl Counter {
    /// True for counters of trouble, which are not printed when they are zero.
    pub const fn counts_trouble(self) -> bool {
        matches!(self, Self::Fallbacks | Self::Refactorisations | Self::WindowEdgeContacts)
    }
}

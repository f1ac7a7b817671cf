//! Errors of the contact.

use thiserror::Error;

/// An error of the contact stage.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ContactError {
    /// The matrix of the points in contact could not be factorised.
    #[error("the {points} x {points} influence matrix of the points in contact is singular at step {step}")]
    SingularMatrix {
        /// Points in contact.
        points: usize,
        /// Time step.
        step: u64,
    },
    /// Newton's method and its fallback have ended without the forces.
    #[error(
        "the search for the forces of {points} points in contact did not settle at step {step}: \
         the contact's tolerance is below what rounding allows here"
    )]
    Unsettled {
        /// Points in contact.
        points: usize,
        /// Time step.
        step: u64,
    },
    /// The first weight G0 is not positive: the time rule does not suit this tyre and time step.
    #[error(
        "the instantaneous influence function is not positive definite (smallest eigenvalue {smallest:.3e}, \
         largest {largest:.3e} m/N): \
         this time rule and time step cannot be stepped; choose bdf1 or bdf2, or another time step"
    )]
    NotPositive {
        /// Smallest eigenvalue of the circulant G0 \[m/N\].
        smallest: f64,
        /// Largest eigenvalue \[m/N\].
        largest: f64,
    },
    /// The search for the forces of cells with friction has ended without them.
    #[error(
        "the search for the forces of {points} cells with a coefficient of friction of {friction} has ended without \
         them at step {step}: choose a smaller coefficient, or more substeps"
    )]
    FrictionUnsettled {
        /// Cells that carry force.
        points: usize,
        /// Largest coefficient of friction of a cell.
        friction: f64,
        /// Time step.
        step: u64,
    },
    /// The skew part of the first weight G0 of a tyre that turns is too large beside the symmetric one.
    #[error(
        "the tyre turns too far in a step: the odd part of its influence within a step is {skewness:.2} of the even \
         one; choose more elements or substeps, or a lower speed"
    )]
    TooSkew {
        /// Largest |O_n|/E_n of both over the wavenumbers.
        skewness: f64,
    },
    /// A force or displacement stopped being a number.
    #[error("the solution stopped being finite at step {step} (t = {time:.6} s)")]
    NotFinite {
        /// Time step.
        step: u64,
        /// Time \[s\].
        time: f64,
    },
    /// The road is given as curves where heights are needed, or the other way round.
    #[error("slices need the road as curves, cells as heights")]
    RoadForm,
    /// A model of the influence functions was made for another displacement than the tread law needs.
    #[error("the model of the influence functions does not hold the displacement that this tread law needs")]
    NoSuchField,
    /// The motion exceeds everything that a linear tyre can represent.
    #[error(
        "the tread would have to move by {displacement:.3} m at step {step} (t = {time:.6} s), more than the \
         tyre's radius of {radius:.3} m: the motion grows without bound, as rolling contact can do above the speed of \
         the waves in the belt; choose a lower speed or more damping"
    )]
    Unbounded {
        /// Time step.
        step: u64,
        /// Time \[s\].
        time: f64,
        /// Required displacement \[m\].
        displacement: f64,
        /// Radius of the tyre \[m\].
        radius: f64,
    },
    /// The first or the last column of a window of cells carries force, and the tyre has more: the step is to be solved
    /// again with a wider window.
    #[error("contact reaches the end of the window of cells at step {step} (t = {time:.6} s)")]
    AtWindowEnd {
        /// Time step.
        step: u64,
        /// Time \[s\].
        time: f64,
    },
    /// No scaling makes the static contact as stiff as the elastic tread's.
    #[error(
        "no scaling gives the tread law the static stiffness of the elastic tread: {force:.1} N are required, \
         {lowest:.1} to {highest:.1} N are possible"
    )]
    NoEqualStiffness {
        /// Static force of the elastic tread \[N\].
        force: f64,
        /// With the softest scaling \[N\].
        lowest: f64,
        /// With the stiffest one \[N\].
        highest: f64,
    },
    /// No axle height gives the load.
    #[error("no axle height carries {load} N: even {indentation:.4} m of indentation gives {force:.1} N")]
    LoadNotReached {
        /// Load asked for \[N\].
        load: f64,
        /// Deepest indentation tried \[m\].
        indentation: f64,
        /// Its static force \[N\].
        force: f64,
    },
}

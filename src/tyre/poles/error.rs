//! Reasons for which a model is refused.

use thiserror::Error;

/// A model that was refused.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FitError {
    /// One wavenumber did not reach the tolerance.
    #[error(
        "wavenumber {wavenumber}: a rational model with {order} poles reaches {error:.1e}, wanted {tolerance:.1e}: \
         {reason}"
    )]
    Refused {
        /// Wavenumber n.
        wavenumber: usize,
        /// Smallest error reached.
        error: f64,
        /// Tolerance wanted.
        tolerance: f64,
        /// Poles in use, conjugates counted.
        order: usize,
        /// Why the attempt ended.
        reason: RefusalReason,
    },
    /// A material that responds before it is pushed: on a finite band a stable model can be made to follow it, but not
    /// a passive tyre.
    #[error(
        "layer '{layer}': the law 'hysteretic' is not causal and has no time-domain model; use 'power-law', 'prony' or \
         'elastic'"
    )]
    NotCausal {
        /// Name of the layer.
        layer: String,
    },
    /// Options out of range.
    #[error("{what} = {value} is out of range: {wanted}")]
    Options {
        /// Name of the option.
        what: &'static str,
        /// Value given.
        value: f64,
        /// Values allowed, for the message.
        wanted: &'static str,
    },
    /// The fit was stopped from outside.
    #[error("the fit was stopped")]
    Stopped,
}

/// End of an attempt at one wavenumber.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum RefusalReason {
    /// The largest number of poles was reached.
    #[error("the largest number of poles is reached; allow more, or a larger tolerance")]
    Poles,
    /// The finest rungs were reached: resonances are sharper than the ladder.
    #[error("resonances are sharper than the sampling can follow; more damping or a lower top frequency is needed")]
    Resolution,
    /// Neither more poles nor more samples helped.
    #[error(
        "neither more poles nor more samples helped; resonances too sharp and too many for this tolerance, or a law \
         that is not causal"
    )]
    Rounds,
    /// The fit generates energy at some frequency.
    #[error("the fit would generate energy; a smaller tolerance may mend that")]
    Passivity,
    /// A sample that is not finite: not a transfer function.
    #[error("a sample is not finite")]
    NotATransferFunction,
}

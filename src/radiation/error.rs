//! Errors of a radiation problem.

use thiserror::Error;

/// Error of a radiation problem, with the numbers that were given.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RadiationError {
    /// A size that must be a positive finite number.
    #[error("{what} is {value}, but must be a positive finite number")]
    NotPositive {
        /// Name of the size.
        what: &'static str,
        /// Given value.
        value: f64,
    },
    /// A size out of the range of bodies.
    #[error("{what} is {value:?} m: from {least} to {most} m is computed")]
    Size {
        /// Name of the size.
        what: &'static str,
        /// Given value \[m\].
        value: f64,
        /// Smallest value that is accepted \[m\].
        least: f64,
        /// Largest value that is accepted \[m\].
        most: f64,
    },
    /// The shoulder's radius does not fit into the body.
    #[error(
        "a shoulder of {shoulder:?} m does not fit a tyre of width {width} m and radius {radius} m: at most half the \
         width, less than the radius, and 0 or at least {least:?} m"
    )]
    Shoulder {
        /// Radius of the shoulder \[m\].
        shoulder: f64,
        /// Width of the body \[m\].
        width: f64,
        /// Radius of the tread \[m\].
        radius: f64,
        /// Smallest radius of a round shoulder \[m\].
        least: f64,
    },
    /// The body's height over the plane cannot be treated.
    #[error("{what} of height {height} m and radius {radius} m: {why}")]
    Height {
        /// Name of the body.
        what: &'static str,
        /// Height \[m\].
        height: f64,
        /// Radius of the body \[m\].
        radius: f64,
        /// Remedy.
        why: &'static str,
    },
    /// A receiver or a source that is not in the air, or a point that is not on the surface.
    #[error("the point ({x}, {y}, {z}) m {why}")]
    Point {
        /// Fore and aft \[m\].
        x: f64,
        /// Across \[m\].
        y: f64,
        /// Height \[m\].
        z: f64,
        /// Where it lies, and should not.
        why: &'static str,
    },
    /// More memory than allowed.
    #[error(
        "{unknowns} unknowns in each of four blocks need {needed} bytes, {limit} are allowed: a lower frequency, fewer \
         nodes per wavelength or a higher limit"
    )]
    Memory {
        /// Unknowns of a block.
        unknowns: usize,
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// More elements than a mesh may have.
    #[error(
        "a mesh of {patches} elements or more on a quarter of the body, {most} are made at most: a lower \
         frequency, fewer nodes per wavelength or a smaller body"
    )]
    Patches {
        /// Elements counted until there were too many.
        patches: usize,
        /// Elements that are made at most.
        most: usize,
    },
    /// The factorisation gave values that are not finite.
    #[error("the equations at {wavenumber} rad/m with {unknowns} unknowns are singular")]
    Singular {
        /// Wavenumber \[rad/m\].
        wavenumber: f64,
        /// Unknowns of the block.
        unknowns: usize,
    },
    /// A gap between patch and road that cannot be given.
    #[error("an acoustic gap of {gap} m is not available: {why}")]
    Gap {
        /// Height of the gap \[m\].
        gap: f64,
        /// Remedy.
        why: &'static str,
    },
    /// An order of the elements that is not available.
    #[error("elements of {order} x {order} nodes are not available: 3 or 4")]
    Order {
        /// Nodes along a side.
        order: usize,
    },
    /// A grid that does not mirror onto itself.
    #[error("{around} cells around the tread: an even number is needed")]
    Cells {
        /// Cells around.
        around: usize,
    },
    /// A list of parity blocks from which transfers cannot be computed.
    #[error("a transfer takes the two blocks even across, or all four")]
    Blocks,
    /// The caller stopped the work; finished frequencies have gone to the sink.
    #[error("interrupted")]
    Interrupted,
}

/// Checks that a value is positive and finite.
pub(super) fn positive(what: &'static str, value: f64) -> Result<(), RadiationError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(RadiationError::NotPositive { what, value }) }
}

//! Frame of a tyre: places and sides.

/// Place \[m\]: x forward, y to the left, z up from the road below the axle's centre.
pub(crate) type Position = [f64; 3];

/// A side of the tyre.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Side {
    /// y > 0.
    #[default]
    Left,
    /// y < 0.
    Right,
}

impl Side {
    /// Returns the sign of y: +1 to the left, -1 to the right.
    pub fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }
}

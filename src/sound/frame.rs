//! Frame of a tyre: positions and sides.

/// Position \[m\]: x forward, y to the left, z up; the origin is on the road below the axle's centre.
pub(crate) type Position = [f64; 3];

/// Side of the tyre, seen in the direction of travel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Side {
    /// y > 0.
    #[default]
    Left,
    /// y < 0.
    Right,
}

impl Side {
    /// Sign of y: +1 to the left, -1 to the right.
    pub fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }
}

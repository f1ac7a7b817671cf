//! A row of cells: `influence` of each on the others, and the whole load curve of a profile by one factorisation,
//! `growing` with the contact.

mod growing;
mod influence;

pub use growing::GrowingContact;
pub use influence::LineInfluence;

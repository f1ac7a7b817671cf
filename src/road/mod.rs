//! Roads: measured or made height maps, brought to the run's elements, and the stiffness curve of each slice.

pub mod slices;

//! Passivity.

//! Rolling contact in the time domain.

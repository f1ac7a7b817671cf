//! What is heard of the forces: third-octave levels and spectra.

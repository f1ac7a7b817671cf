"""Levels of signals."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tyrewave import _native


def third_octaves(
    signal: ArrayLike, time_step: float, *, reference: float = 1.0, lowest: float = 20.0, segment: float | None = None
) -> dict[str, NDArray[np.float64]]:
    """Third-octave levels (IEC 61260-1, base ten) of an evenly sampled signal, its mean removed.

    `time_step` [s]; levels are in dB re `reference` (1 N for forces, 20e-6 Pa for sound); bands lie whole above
    `lowest` [Hz]; spectra of segments of `segment` [s] are averaged, by default the whole signal is one. Columns:
    `nominal_hz` and `mid_frequency_hz` [Hz], `mean_square` [unit^2], `level_db` [dB], minus infinity for silence.
    """
    samples = np.ascontiguousarray(signal, dtype=np.float64)
    return _native.third_octaves(samples, time_step, reference, lowest, segment)

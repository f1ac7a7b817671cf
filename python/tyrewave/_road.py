"""Measured roads from instruments whose files the program does not read."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

_METRES = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "\u00b5m": 1e-6, "\u03bcm": 1e-6, "nm": 1e-9, "cm": 1e-2}


class Road(dict[str, Any]):
    """The table `[road]` of a scene, as a dictionary for `Scene.from_dict({..., "road": road})`."""

    @classmethod
    def from_topography(cls, topography: Any, file: str | PathLike[str]) -> Road:
        """Writes a topography's heights as the array `file` (.npy) and returns the road that it makes.

        A topography is one of the package SurfaceTopography, which reads SUR, X3P and most files of profilometers:
        `SurfaceTopography.read_topography("scan.x3p")`. Its first axis runs along the road; heights that were not
        measured are NaN.
        """
        path = Path(file)
        if path.suffix != ".npy":
            raise ValueError(f"the file of an array is to end with .npy, not {path.suffix!r}")
        if topography.unit not in _METRES:
            raise ValueError(f"heights in {topography.unit!r} are no lengths: units are {', '.join(_METRES)}")
        heights = np.ma.filled(np.ma.asarray(topography.heights(), dtype=float), np.nan)
        if heights.ndim != 2:
            raise ValueError("a line scan makes no grid: write its positions and heights as a table, kind = 'profile'")
        metres = _METRES[topography.unit]
        np.save(path, heights * metres)
        dx, dy = (metres * size / count for size, count in zip(topography.physical_sizes, heights.shape, strict=True))
        return cls(kind="grid", file=str(path), dx=dx, dy=dy)

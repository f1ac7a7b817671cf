"""Contact of single slices, and of rough bodies with a half-space."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tyrewave import _native


def numbers(values: ArrayLike) -> list[float]:
    """One number or several as a list."""
    return [float(value) for value in np.atleast_1d(np.asarray(values, dtype=np.float64)).ravel()]


def slice_curve(
    heights: ArrayLike, dx: float, dy: float, penetration: ArrayLike, *, law: str = "winkler"
) -> dict[str, NDArray[np.float64]]:
    """How a slice of a road, one row of cells across the tyre, yields: the curve of its law, "winkler" or "half-space".

    `heights` [m] of cells of `dx` along by `dy` across [m]; `penetration` [m] past the highest point. Found are
    `displacement` S [m], `stiffness` dS/dy, and `pressure` over the effective modulus E* of every cell,
    [penetrations, cells].
    """
    return _native.slice_curve(numbers(heights), (dx, dy), law, numbers(penetration))


def indent(
    heights: ArrayLike,
    dx: float,
    dy: float,
    *,
    modulus: float,
    poisson: float = 0.0,
    load: float | None = None,
    penetration: float | None = None,
    tolerance: float | None = None,
) -> dict[str, Any]:
    """Presses a rigid rough body, its highest points first, into an elastic half-space without friction.

    `heights` [m], rows `dx` and columns `dy` apart [m]; Young's `modulus` [Pa] and Poisson's ratio of the half-space;
    either `load` [N] or `penetration` of the highest peak [m]. Found are `pressure` [Pa] of the heights' shape, `load`
    [N], `penetration` [m], `area_fraction`, `iterations` and `residual`.
    """
    body = np.ascontiguousarray(heights, dtype=np.float64)
    if not -1.0 < poisson <= 0.5:
        raise ValueError(f"Poisson's ratio must be above -1 and at most 0.5, not at {poisson}")
    effective = modulus / (1.0 - poisson * poisson)
    return _native.indent(body, (dx, dy), effective, load, penetration, tolerance)

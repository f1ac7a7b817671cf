"""Roads from topographies of instruments."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import tyrewave


def topography(unit: str, heights: np.ndarray) -> SimpleNamespace:
    """What `SurfaceTopography.read_topography` returns, as far as a road needs it."""
    return SimpleNamespace(unit=unit, heights=lambda: heights, physical_sizes=(300.0, 80.0))


def test_a_topography_is_a_grid_in_metres(tmp_path: Path) -> None:
    heights = np.ma.masked_greater(np.arange(600.0).reshape(60, 10), 598.5)
    road = tyrewave.Road.from_topography(topography("mm", heights), tmp_path / "road.npy")
    assert road["kind"] == "grid"
    assert (road["dx"], road["dy"]) == pytest.approx((0.005, 0.008))
    written = np.load(road["file"])
    assert written.shape == (60, 10) and written[1, 2] == pytest.approx(0.012) and np.isnan(written[-1, -1])


def test_a_topography_without_lengths_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no lengths"):
        tyrewave.Road.from_topography(topography("V", np.zeros((4, 4))), tmp_path / "road.npy")

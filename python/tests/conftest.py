"""Common things of the tests: a small scene, and the program."""

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

import tyrewave

ROOT = Path(__file__).parents[2]

SMALL = {
    "numerics.elements": 64,
    "rolling.warm_up": 0.1,
    "rolling.duration": 0.6,
    "outputs.plots": False,
    # A fraction of a second is no time to keep to a load.
    "rolling.axle.tolerance": 0.5,
}
LONG = SMALL | {"rolling.duration": 900.0}


@pytest.fixture
def scene() -> tyrewave.Scene:
    return tyrewave.Scene.load(ROOT / "scenes" / "default.toml", set=SMALL)


@pytest.fixture
def long_scene() -> tyrewave.Scene:
    return tyrewave.Scene.load(ROOT / "scenes" / "default.toml", set=LONG)


@pytest.fixture
def program() -> Callable[..., str]:
    """Calls the program; what it prints."""
    path = os.environ.get("TYREWAVE_PROGRAM")
    if not path:
        pytest.skip("TYREWAVE_PROGRAM does not name the program")

    def call(*arguments: object) -> str:
        line = [path, *map(str, arguments)]
        return subprocess.run(line, check=True, capture_output=True, text=True, cwd=ROOT).stdout

    return call


def settings(of: dict[str, object]) -> list[str]:
    """As the program takes them."""
    return [word for key, value in of.items() for word in ("--set", f"{key}={json.dumps(value)}")]

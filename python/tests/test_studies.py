"""Sweeps, effects, tyre and radiation: the numbers of the program."""

import json
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, SMALL, settings

import tyrewave

DEFAULT = ROOT / "scenes/default.toml"


def test_a_sweep_has_the_tables_of_the_program(
    scene: tyrewave.Scene, program: Callable[..., str], tmp_path: Path
) -> None:
    varied = ["--speed", "60,90", "--set", "road.seed=1,2,3"]
    program("sweep", DEFAULT, *settings(SMALL), *varied, "--out", tmp_path / "program")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", tyrewave.RunWarning)
        found = scene.sweep(tmp_path / "package", speed_kmh=[60, 90], set={"road.seed": [1, 2, 3]})
    assert len(found) == 6 and "seed=2-90kmh" in found
    for name, table in (("sweep.csv", found.table), ("design.csv", found.design)):
        expected = tyrewave.Table.of_csv((tmp_path / "program" / name).read_text())
        assert table.keys() == expected.keys(), name
        for column, values in table.items():
            assert np.array_equal(values, expected[column], equal_nan=values.dtype.kind == "f"), (name, column)
    assert found.table["valid"].dtype == found.table["load_met"].dtype == np.bool_
    assert found.table.units["speed_kmh"] == "km/h" and found.table.units["rolling_resistance"] == "1"
    assert found.sound == {}
    for name, results in found.items():
        force = (tmp_path / "program" / name / "total_force.npy").read_bytes()
        assert (tmp_path / "package" / name / "total_force.npy").read_bytes() == force
        assert results.folder == tmp_path / "package" / name


def test_a_sweep_that_makes_no_sense_is_refused(scene: tyrewave.Scene, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="nothing is varied"):
        scene.sweep(tmp_path)
    with pytest.raises(ValueError, match="given twice"):
        scene.sweep(tmp_path, speed_kmh=[50, 50.0])
    with pytest.raises(tyrewave.SceneError) as refused:
        scene.sweep(tmp_path, speed_kmh=-50.0)
    assert refused.value.complaints[0].key == "rolling.speed_kmh"
    with pytest.raises(tyrewave.SceneError, match="sead"):
        scene.sweep(tmp_path, set={"road.sead": [1, 2]})
    with pytest.raises(ValueError, match="road"):
        scene.sweep(tmp_path, road=[tmp_path / "none.toml"])
    assert not list(tmp_path.iterdir())


def test_a_sweep_that_misses_its_load_warns(tmp_path: Path) -> None:
    keys = SMALL | {"rolling.axle.tolerance": 1e-9}
    with pytest.warns(tyrewave.RunWarning, match="60kmh: missed the load") as told:
        found = tyrewave.Scene.load(DEFAULT, set=keys).sweep(tmp_path / "a", speed_kmh=60)
    assert told[-1].filename == __file__ and found.missed == ["60kmh"] and not found.table["load_met"].any()


def test_effects_are_those_of_the_program(program: Callable[..., str], tmp_path: Path) -> None:
    # A flat tyre has it soonest. The axle has a mass of its own: one wheel's is too small for such long steps.
    plate, axle = ROOT / "scenes/plate.toml", {"mass": 350.0, "stiffness": 2e4, "damping": 1e3}
    keys = {key: value for key, value in SMALL.items() if not key.startswith("rolling.axle")}
    keys |= {f"rolling.axle.{key}": value for key, value in axle.items()}
    keys |= {"rolling.duration": 0.3}
    program("effects", plate, *settings(keys), "--out", tmp_path / "effects")
    expected = tyrewave.Table.of_csv((tmp_path / "effects/effects.csv").read_text())
    found = tyrewave.Scene.load(plate, set=keys).effects()
    assert found.keys() == expected.keys() and list(found["effects"][:2]) == ["none", "all"]
    # Influence functions that the program has fitted are kept: the second plan has no memory for fits.
    assert (found["memory_bytes"] <= expected["memory_bytes"]).all() and found["memory_bytes"].min() > 1e6
    for name, values in found.items():
        same = np.array_equal(values, expected[name], equal_nan=values.dtype.kind == "f")
        assert same or name in ("steps_s", "memory_bytes"), name
        assert values.dtype.kind == "U" or name in found.units, name


def test_the_tyre_is_that_of_the_program(scene: tyrewave.Scene, program: Callable[..., str], tmp_path: Path) -> None:
    sizes = ["--waves", "2", "--highest", "150", "--loads", "3000N,4000N", "--patch", "50", "--points", "3"]
    program("tyre", DEFAULT, *settings(SMALL), *sizes, "--out", tmp_path / "tyre")
    found = scene.tyre(waves=2, highest=150.0, load=[3000.0, 4000.0], patch=0.05, points=3)
    assert found == json.loads((tmp_path / "tyre/tyre.json").read_text())
    assert [load["load"] for load in found["loads"]] == pytest.approx([3000.0, 4000.0]) and found["modes"]
    for wrong in ({"load": -1.0}, {"waves": 501}, {"highest": 0.0}, {"patch": 1e-9}, {"points": 1}):
        with pytest.raises(ValueError):
            scene.tyre(**wrong)  # type: ignore[arg-type]


def test_the_radiation_is_that_of_the_program(
    scene: tyrewave.Scene, program: Callable[..., str], tmp_path: Path
) -> None:
    program("radiation", DEFAULT, *settings(SMALL), "--highest", "200", "--points", "2", "--out", tmp_path / "a")
    told: list[tuple[str, int, int]] = []
    found = scene.radiation(highest=200.0, points=2, progress=lambda *state: told.append(state))
    assert found == json.loads((tmp_path / "a/radiation.json").read_text())
    assert len(found["frequencies"]) == 2 and len(found["frequencies"][0]["horn"]) == len(found["receivers"])
    assert told
    for wrong in ({"highest": 1.0}, {"points": 0}):
        with pytest.raises((ValueError, OverflowError)):
            scene.radiation(**wrong)  # type: ignore[arg-type]

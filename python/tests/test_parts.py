"""Tyre, road and contact by themselves, against each other and against what is known of them."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, SMALL

import tyrewave


def test_mobility_is_the_program_s(program: Callable[..., str], tmp_path: Path) -> None:
    # A flat tyre has it soonest.
    plate = ROOT / "scenes/plate.toml"
    program("mobility", plate, "--patch", "20,50", "--points", "5", "--out", tmp_path / "mobility")
    table = np.genfromtxt(tmp_path / "mobility/mobility.csv", delimiter=",", names=True)
    found = tyrewave.Scene.load(plate).mobility(table["frequency_hz"], patch=[0.02, 0.05])
    assert found.shape == (5, 2)
    assert np.array_equal(found[:, 0].real, table["re_20mm"]) and np.array_equal(found[:, 1].imag, table["im_50mm"])


def test_compliance_is_symmetric_and_passive(scene: tyrewave.Scene) -> None:
    found = scene.compliance([0, 3, 40], [10.0, 300.0, 2000.0], lateral=2)
    assert found.shape == (3, 3, 3, 3) and np.isfinite(found).all()
    # Displacement lags behind traction: its power goes into the tyre.
    assert (found[..., 2, 2].imag < 0.0).all()
    # Reciprocity: displacement along for traction outward is minus the reverse at the opposite wave.
    assert np.allclose(found[..., 0, 2], -found[..., 2, 0], rtol=1e-3, atol=1e-3 * np.abs(found[..., 2, 2]).max())


def test_influence_functions_are_causal_symmetric_and_passive(scene: tyrewave.Scene) -> None:
    times = np.linspace(1e-5, 3e-3, 200)
    over_time = scene.influence([0, 1, 5, 63, 64], times)
    assert over_time.shape == (5, 200)
    # Once round the tyre is where it began. As it turns, it answers differently to the left and to the right.
    assert np.array_equal(over_time[0], over_time[4]) and not np.allclose(over_time[1], over_time[3])
    resting = tyrewave.Scene.load(ROOT / "scenes/default.toml", set=SMALL | {"effects.rotation": "off"})
    held = resting.influence([1, 63], times)
    assert np.allclose(held[0], held[1])
    # Five elements away nothing is felt at first.
    assert np.abs(over_time[2, :20]).max() < 1e-2 * over_time[0].max()
    spectrum = scene.influence_spectrum(np.arange(33), [0.0, 500.0])
    against = scene.influence_spectrum(-np.arange(33), [0.0, 500.0])
    assert np.array_equal(spectrum[:, 0], against[:, 0].conj()) and abs(against[3, 1] / spectrum[3, 1] - 1.0) > 0.01
    assert np.abs(spectrum[:, 0].imag).max() < 1e-6 * np.abs(spectrum).max() and (spectrum[:, 1].imag <= 0.0).all()


def test_heights_are_where_they_say(scene: tyrewave.Scene) -> None:
    road = scene.heights(2.0, 0.5)
    rows, columns = road["heights"].shape
    assert road["x"].shape == (rows,) and road["y"].shape == (columns,)
    assert abs(road["x"][0] - 2.0) < 0.04 and road["x"][-1] - road["x"][0] >= 0.4
    assert abs(road["y"].sum()) < 1e-9 and np.ptp(road["y"]) < 0.111
    assert 1e-5 < road["heights"].std() < 5e-3
    further = scene.heights(2.0, 1.0)["heights"]
    assert np.array_equal(further[:rows], road["heights"])


def test_the_texture_is_that_of_the_program(scene: tyrewave.Scene, program: Callable[..., str], tmp_path: Path) -> None:
    out = tmp_path / "road"
    settings = [
        word for key, value in SMALL.items() if key == "numerics.elements" for word in ("--set", f"{key}={value}")
    ]
    program("road", ROOT / "scenes/default.toml", *settings, "--out", out)
    told = json.loads((out / "road.json").read_text())
    found = scene.road()
    assert found["levels"] == told["levels"] and found["mean_profile_depth"] == told["mean_profile_depth"]


def test_slices_yield_by_both_laws(scene: tyrewave.Scene) -> None:
    depths = np.array([-1e-3, 0.0, 5e-4, 2e-3])
    found = scene.slices(depths, start=1.0, count=7)
    assert set(found) == {"winkler", "half-space"}
    for displacement in found.values():
        assert displacement.shape == (7, 4)
        assert np.allclose(displacement[:, 0], -1e-3) and (displacement[:, 1] == 0.0).all()
        assert (displacement[:, 3] > displacement[:, 2]).all() and (displacement <= depths + 1e-12).all()


def test_a_slice_s_pressures_add_up() -> None:
    heights = 1e-3 * np.sin(0.7 * np.arange(40))
    flat = tyrewave.slice_curve(np.zeros(40), 4e-3, 2e-3, 1.0, law="half-space")["pressure"].sum()
    for law in ("winkler", "half-space"):
        curve = tyrewave.slice_curve(heights, 4e-3, 2e-3, [2e-4, 1e-3, 5e-3], law=law)
        assert np.allclose(curve["pressure"].sum(axis=1) / flat, curve["displacement"])
        assert (np.diff(curve["stiffness"]) >= 0.0).all() and (curve["stiffness"] <= 1.0).all()


def test_a_sphere_is_pressed_as_hertz_has_it() -> None:
    spacing, radius, modulus, poisson = 2e-4, 0.05, 1e7, 0.45
    place = spacing * (np.arange(81) - 40)
    heights = -(place[:, None] ** 2 + place[None, :] ** 2) / (2.0 * radius)
    found = tyrewave.indent(heights, spacing, spacing, modulus=modulus, poisson=poisson, penetration=5e-4)
    hertz = 4.0 / 3.0 * modulus / (1.0 - poisson**2) * radius**0.5 * 5e-4**1.5
    assert found["load"] == pytest.approx(hertz, rel=0.01)
    assert found["pressure"].shape == heights.shape
    assert found["pressure"].sum() * spacing**2 == pytest.approx(found["load"])
    again = tyrewave.indent(heights, spacing, spacing, modulus=modulus, poisson=poisson, load=found["load"])
    assert again["penetration"] == pytest.approx(5e-4, rel=1e-6)


def test_third_octaves_lose_nothing() -> None:
    time = np.arange(48000) / 48000.0
    signal = 3.0 + np.sqrt(2.0) * np.sin(2.0 * np.pi * 1000.0 * time)
    levels = tyrewave.third_octaves(signal, 1.0 / 48000.0)
    at = int(np.argmax(levels["level_db"]))
    assert levels["nominal_hz"][at] == 1000.0 and levels["level_db"][at] == pytest.approx(0.0, abs=0.01)
    assert levels["mean_square"].sum() == pytest.approx(1.0, rel=1e-3)
    in_pascals = tyrewave.third_octaves(signal, 1.0 / 48000.0, reference=20e-6, segment=0.25)
    assert in_pascals["level_db"].max() == pytest.approx(93.98, abs=0.05)

"""Mistakes are refused, with their place; nothing else escapes than these exceptions."""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROOT, SMALL

import tyrewave

SCENES = ROOT / "scenes"


def complaint(scene: str) -> tyrewave.Complaint:
    with pytest.raises(tyrewave.SceneError) as refused:
        tyrewave.Scene.from_toml(scene, name="mine.toml")
    return refused.value.complaints[0]


def test_a_mistake_has_file_line_and_key(tmp_path: Path) -> None:
    text = (SCENES / "default.toml").read_text()
    path = tmp_path / "wrong.toml"
    path.write_text(text.replace("speed_kmh = 80.0", "speed_kmh = -80.0").replace("thickness = 0.013", "thicknes = 1"))
    with pytest.raises(tyrewave.SceneError) as refused:
        tyrewave.Scene.load(path)
    lines = path.read_text().splitlines()
    found = {mistake.key: mistake for mistake in refused.value.complaints}
    speed = found["rolling.speed_kmh"]
    assert speed.file == str(path) and lines[speed.line - 1].startswith("speed_kmh") and speed.column > 1
    assert "-80" in speed.message and speed.hint
    unknown = found["tyre.layers[2].thicknes"]
    assert lines[unknown.line - 1].startswith("thicknes") and "thickness" in unknown.hint
    assert str(unknown).startswith(f"{path}:{unknown.line}:")
    # The message shows the places, as on the command line.
    assert "speed_kmh = -80.0" in str(refused.value) and isinstance(refused.value, ValueError)


def test_texts_dictionaries_and_settings_are_answered_alike() -> None:
    assert complaint("[rolling]\nspeed_kmh = 'fast'").file == "mine.toml"
    assert complaint("this is no TOML").line == 1
    settings = tyrewave.Scene.load(SCENES / "default.toml").settings
    settings["rolling"]["speed_kmh"] = -1
    with pytest.raises(tyrewave.SceneError) as refused:
        tyrewave.Scene.from_dict(settings)
    assert [mistake.key for mistake in refused.value.complaints] == ["rolling.speed_kmh"]
    with pytest.raises(tyrewave.SceneError, match="sped_kmh"):
        tyrewave.Scene.load(SCENES / "default.toml", set={"rolling.sped_kmh": 3})


def test_a_dictionary_makes_the_scene_that_its_file_makes() -> None:
    for path in sorted(SCENES.glob("*.toml")):
        scene = tyrewave.Scene.load(path)
        if scene.settings["road"].get("file") is None:
            assert tyrewave.Scene.from_dict(scene.settings).sha256 == scene.sha256, path.name
            assert tyrewave.Scene.from_toml(scene.to_toml()).sha256 == scene.sha256, path.name


def test_settings_are_numbers_texts_arrays_and_paths_of_python_and_numpy() -> None:
    scene = tyrewave.Scene.load(
        SCENES / "default.toml",
        set={
            "rolling.speed_kmh": np.float32(50),
            "road.seed": np.int64(7),
            "title": 'quoted "and\\broken" \u00fc',
            "outputs.plots": False,
            "tyre.layers[0].tension": np.array([4e4, 2e4]),
            "tyre.layers[1].material": {"law": "elastic", "modulus": 6e6, "poisson": 0.49, "density": 1000},
        },
    )
    settings = scene.settings
    assert settings["rolling"]["speed_kmh"] == 50 and settings["road"]["seed"] == 7
    assert scene.title == 'quoted "and\\broken" \u00fc' and settings["outputs"]["plots"] is False
    assert settings["tyre"]["layers"][0]["tension"] == [4e4, 2e4]
    assert settings["tyre"]["layers"][1]["material"]["law"] == "elastic"
    # As in a file: a text is one line.
    with pytest.raises(tyrewave.SceneError, match="control character"):
        tyrewave.Scene.load(SCENES / "default.toml", set={"title": 'quoted "and\nbroken"'})
    tyre = Path("tyres/car.toml")
    assert tyrewave.Scene.load(SCENES / "default.toml", set={"tyre": tyre}).settings["tyre"]["circumference"] > 1.0


@pytest.mark.parametrize(
    "value",
    [object(), 10**30, float("nan"), float("inf"), b"bytes", [[[]]], {"a": {"b": None}}, np.zeros(3), -0.0, "\0", 1j],
    ids=repr,
)
def test_no_nonsense_as_a_setting_is_more_than_an_exception(value: Any) -> None:
    for key in ("rolling.speed_kmh", "tyre", "road.seed", "receiver", "nothing", "a..b", ""):
        with pytest.raises((ValueError, TypeError)):
            tyrewave.Scene.load(SCENES / "default.toml", set={key: value})


def test_a_dictionary_within_itself_is_refused() -> None:
    endless: dict[str, Any] = {}
    endless["tyre"] = endless
    with pytest.raises(ValueError, match="within each other"):
        tyrewave.Scene.from_dict(endless)
    with pytest.raises(TypeError):
        tyrewave.Scene.from_dict({1: 2})  # type: ignore[dict-item]


def test_files_are_answered_as_files(tmp_path: Path, scene: tyrewave.Scene) -> None:
    with pytest.raises(FileNotFoundError, match=r"none\.toml"):
        tyrewave.Scene.load(tmp_path / "none.toml")
    with pytest.raises(IsADirectoryError):
        tyrewave.Scene.load(tmp_path)
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis/chapter.tex").write_text("ten years of work")
    with pytest.raises(FileExistsError, match="not a tyrewave results folder"):
        scene.run(tmp_path / "thesis")
    with pytest.raises(FileNotFoundError):
        tyrewave.open(tmp_path / "nothing")
    with pytest.raises(FileNotFoundError, match="nothing to resume"):
        tyrewave.resume(tmp_path / "nothing")
    with pytest.raises(NotADirectoryError):
        tyrewave.open(tmp_path / "thesis/chapter.tex")
    for summary in (None, "", "{}", "[1]", '{"format": "other"}'):
        if summary is not None:
            (tmp_path / "summary.json").write_text(summary)
        with pytest.raises(ValueError, match="not a tyrewave results folder"):
            tyrewave.open(tmp_path)
    if sys.platform == "linux":
        with pytest.raises(OSError, match="/proc"):
            scene.run("/proc/nothing")


def test_what_a_run_cannot_do_is_told_before_it() -> None:
    with pytest.raises(tyrewave.SceneError, match="memory"):
        tyrewave.Scene.load(SCENES / "default.toml", set=SMALL | {"numerics.memory_limit": 1e-3}).run()
    law = {"tyre.layers[1].material.law": "hysteretic"}
    with pytest.raises(tyrewave.SceneError, match="causal") as refused:
        tyrewave.Scene.load(SCENES / "default.toml", set=SMALL | law).plan()
    assert refused.value.complaints[0].key == "tyre.layers[1].material.law"


@pytest.mark.parametrize("threads", [0, 1025, 10**9])
def test_no_number_of_threads_that_cannot_be_meant(scene: tyrewave.Scene, threads: int) -> None:
    with pytest.raises(ValueError, match="threads"):
        scene.run(threads=threads)


def test_no_nonsense_as_an_argument_is_more_than_an_exception(scene: tyrewave.Scene) -> None:
    bad = [float("nan"), float("inf"), -1.0, 1e300, -1e300]
    wrong = (ValueError, TypeError, OverflowError)
    for number in bad:
        for call in (
            lambda x: scene.mobility(x),
            lambda x: scene.mobility(100.0, patch=x),
            lambda x: scene.compliance(1, x),
            lambda x: scene.influence_spectrum(1, x),
            lambda x: scene.heights(x, 1.0) if x != -1.0 else scene.heights(0.0, x),
            lambda x: scene.heights(0.0, x),
            lambda x: (
                tyrewave.slice_curve([0.0, 1e-3], x, 1e-3, 1e-3) if x < 1e300 else tyrewave.slice_curve([x], 1, 1, 1)
            ),
            lambda x: tyrewave.indent([[0.0, 1e-3]], x, 1e-3, modulus=1e7, load=1.0),
            lambda x: tyrewave.indent([[0.0, 1e-3]], 1e-3, 1e-3, modulus=1e7, load=x),
            lambda x: tyrewave.third_octaves([0.0, 1.0] * 50, x) if x < 1e300 else tyrewave.third_octaves([x], 1.0),
        ):
            try:
                found = call(number)
            except (*wrong, tyrewave.RunError):
                continue
            assert number in (1e300, -1e300), (number, found)
    for call in (
        lambda: scene.compliance(0.5, 100.0),
        lambda: scene.compliance(-1, 100.0),
        lambda: scene.compliance(10**9, 100.0),
        lambda: scene.influence(-1, 0.0),
        lambda: scene.influence(0, -1.0),
        lambda: scene.influence_spectrum(33, 100.0),
        lambda: scene.slices(1e-3, count=0),
        lambda: scene.slices(1e-3, count=10**15),
        lambda: tyrewave.slice_curve([], 1e-3, 1e-3, 1e-3),
        lambda: tyrewave.slice_curve([0.0], 1e-3, 1e-3, 1e-3, law="none"),
        lambda: tyrewave.indent([[0.0]], 1e-3, 1e-3, modulus=1e7),
        lambda: tyrewave.indent([[0.0]], 1e-3, 1e-3, modulus=1e7, load=1.0, penetration=1.0),
        lambda: tyrewave.indent([[0.0]], 1e-3, 1e-3, modulus=1e7, load=1.0, poisson=0.7),
        lambda: tyrewave.indent(np.zeros((0, 3)), 1e-3, 1e-3, modulus=1e7, load=1.0),
        lambda: tyrewave.indent([0.0], 1e-3, 1e-3, modulus=1e7, load=1.0),
        lambda: tyrewave.third_octaves([], 1e-3),
        lambda: tyrewave.third_octaves([0.0] * 100, 1e-3, reference=0.0),
    ):
        with pytest.raises(wrong):
            call()


def test_empty_lists_have_empty_answers(scene: tyrewave.Scene) -> None:
    assert scene.compliance([], [100.0]).shape == (0, 1, 3, 3)
    assert scene.mobility([]).shape == (0, 1)
    assert scene.influence_spectrum([], []).shape == (0, 0)

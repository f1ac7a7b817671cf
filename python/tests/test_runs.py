"""Runs: the same bytes as the program's, in memory and in folders."""

import importlib.util
import json
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, SMALL, settings

import tyrewave

ARRAYS = ["time", "total_force", "patch_force", "patch_element"]
SOUND = {"receiver": [{"name": "near", "position": [0.0, 0.4, 0.15]}], "radiation.quality": "draft"}
PASSED = SOUND | {
    "rolling.speed_kmh": 130.0,
    "rolling.duration": 3.0,
    "receiver": [{"name": "1", "position": [0.0, 0.7, 0.3]}, {"name": "line", "standard": "coast-by"}],
    "outputs.vibration": {"points": [0.1], "elements": [3], "map": True},
}


@pytest.fixture(autouse=True)
def quiet() -> None:
    warnings.simplefilter("ignore", tyrewave.RunWarning)


def test_a_folder_has_the_bytes_of_the_command_line(
    scene: tyrewave.Scene, program: Callable[..., str], tmp_path: Path
) -> None:
    program("run", ROOT / "scenes/default.toml", *settings(SMALL), "--out", tmp_path / "program")
    results = scene.run(tmp_path / "package")
    names = sorted(path.name for path in (tmp_path / "program").iterdir())
    assert sorted(path.name for path in (tmp_path / "package").iterdir()) == names
    assert {"total_force.npy", "spectra.csv", "summary.json"} <= set(names)
    for name in names:
        found, expected = ((tmp_path / whose / name).read_bytes() for whose in ("package", "program"))
        if name == "summary.json":
            # Costs are those of the machine and the moment.
            found, expected = (json.loads(text) | {"cost": None} for text in (found, expected))
        assert found == expected, name
    assert results.folder == tmp_path / "package"


def test_memory_holds_what_a_folder_does(scene: tyrewave.Scene, tmp_path: Path) -> None:
    folder, memory = scene.run(tmp_path / "a", threads=1), scene.run(threads=2)
    for name in ARRAYS:
        assert memory[name].dtype == folder[name].dtype
        assert memory[name].tobytes() == folder[name].tobytes(), name
    assert memory.spectra.keys() == folder.spectra.keys()
    for name, column in memory.spectra.items():
        assert np.array_equal(column, folder.spectra[name], equal_nan=True), name
    without = {"cost": None, "files": None}
    assert memory.summary | without == folder.summary | without
    forces = {"total_force": "N", "patch_force": "N", "patch_element": "1"}
    assert memory.units == {"time": "s", "contact_length": "m"} | forces


def test_vibration_pressures_and_passages_are_in_memory_as_in_a_folder(tmp_path: Path) -> None:
    scene = tyrewave.Scene.load(ROOT / "scenes/default.toml", set=SMALL | PASSED)
    folder, memory = scene.run(tmp_path / "a"), scene.run()
    assert memory.keys() == folder.keys() and "vibration_map_tread_material" in memory
    for name in memory:
        assert memory[name].tobytes() == folder[name].tobytes(), name
    without = {"cost": None, "files": None}
    assert memory.summary | without == folder.summary | without
    tables = [path.name for path in (tmp_path / "a").glob("*.csv")]
    assert {"vibration.csv", "sound_narrow.csv", "pass_by_line.csv"} <= set(tables)
    for name in tables:
        same_table(memory.table(name), folder.table(name))
    assert set(memory.vibration["field"]) == {"tread", "belt"}
    assert list(memory.sound) == ["1", "line"]
    for name in memory.sound:
        rate, pressures = memory.pressure(name)
        assert rate == 48000 and 1e-4 < np.abs(pressures).max() < 100.0
        assert pressures.tobytes() == folder.pressure(name)[1].tobytes()
    same_table(memory.pass_by("line"), folder.pass_by("line"))
    assert memory.pass_by("line").units["time_s"] == "s"
    for results in (memory, folder):
        with pytest.raises(KeyError, match="'line'"):
            results.pass_by("1")
        with pytest.raises(KeyError, match="'1', 'line'"):
            results.pressure("near")


def same_table(found: tyrewave.Table, expected: tyrewave.Table) -> None:
    assert found.keys() == expected.keys()
    for name, column in found.items():
        assert column.dtype == expected[name].dtype, name
        assert np.array_equal(column, expected[name], equal_nan=column.dtype.kind == "f"), name


def test_tables_have_units_and_masks(tmp_path: Path) -> None:
    results = tyrewave.Scene.load(ROOT / "scenes/default.toml", set=SMALL | PASSED).run(tmp_path / "a")
    tables = {path.name: results.table(path.name) for path in (tmp_path / "a").glob("*.csv")}
    assert len(tables) == 6, tables.keys()
    for file, table in tables.items():
        for name, column in table.items():
            assert column.dtype.kind in "fbU" and (column.dtype.kind == "f") == (name in table.units), (file, name)
    force = results.spectra
    assert force["valid"].dtype == np.bool_ and force["valid"].any()
    assert force.units["level_db_re_1n"] == "dB re 1 N" and force.units["nominal_hz"] == "Hz"
    assert force.units["mean_square_n2"] == "N^2"
    assert np.array_equal(force.where(force["valid"])["nominal_hz"], force["nominal_hz"][force["valid"]])
    heard = results.sound["1"]
    assert heard.units["level_db_a"] == "dB(A)" and heard["valid"].dtype == np.bool_
    assert results.vibration.units["level_db_re_1m_s"] == "dB re 1 m/s" and results.vibration.units["position_m"] == "m"


def test_a_dataset_without_xarray_says_what_to_install(scene: tyrewave.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(ImportError, match="pip install xarray"):
        scene.run().to_xarray()


def test_an_axle_that_moves_is_recorded_in_both(tmp_path: Path) -> None:
    axle = {"rolling.axle": {"mass": 350.0, "stiffness": 2e4, "damping": 1e3, "load": 3400.0}}
    moving = tyrewave.Scene.load(ROOT / "scenes/default.toml", set=axle | {key: SMALL[key] for key in list(SMALL)[:4]})
    assert moving.run(tmp_path / "a")["axle"].tobytes() == moving.run()["axle"].tobytes()


def test_sound_is_heard_in_memory_and_in_a_folder(tmp_path: Path) -> None:
    heard = tyrewave.Scene.load(ROOT / "scenes/default.toml", set=SMALL | SOUND)
    folder, memory = heard.run(tmp_path / "a"), heard.run()
    assert list(folder.sound) == list(memory.sound) == ["near"]
    levels = memory.sound["near"]
    assert np.array_equal(levels["level_db_a"], folder.sound["near"]["level_db_a"], equal_nan=True)
    assert 60.0 < np.nanmax(levels["level_db_a"]) < 130.0
    assert levels["valid"].dtype == np.bool_
    if importlib.util.find_spec("xarray"):
        heard_by = memory.to_xarray()["sound_level_a"].sel(receiver="near")
        assert heard_by.attrs["units"] == "dB(A)" and np.array_equal(
            heard_by.values, levels["level_db_a"], equal_nan=True
        )
    rate, pressure = folder.pressure("near")
    assert rate == 48000 and pressure.ndim == 2 and 0.001 < np.abs(pressure).max() < 100.0
    with pytest.raises(KeyError):
        memory.pressure("far")


def test_no_file_outside_of_the_folder_is_read(tmp_path: Path) -> None:
    folder, outside = tmp_path / "a", tmp_path / "outside.wav"
    tyrewave.Scene.load(ROOT / "scenes/default.toml", set=SMALL | SOUND).run(folder)
    summary = json.loads((folder / "summary.json").read_text())
    (heard,) = summary["sound"]["receivers"]
    own = heard["audio"]["file"]
    outside.write_bytes((folder / own).read_bytes())
    (folder / "below").mkdir()
    (folder / "below/sound.wav").write_bytes(outside.read_bytes())

    def named(file: object) -> tyrewave.Results:
        """The results after their summary was changed."""
        heard["audio"] = heard["pass_by"] = {"file": file}
        (folder / "summary.json").write_text(json.dumps(summary))
        return tyrewave.open(folder)

    kept = named(own).pressure("near")[1]
    assert np.abs(kept).max() > 0.0
    names = ["../outside.wav", str(outside), "below/sound.wav", "./" + own, own + "/", "..", ".", ""]
    for name in [*names, "..\\outside.wav", "C:outside.wav", "\\\\host\\share\\a.wav", 3, None]:
        changed = named(name)
        for read in (changed.pressure, changed.pass_by):
            with pytest.raises(ValueError, match="is not the name of a file of the run"):
                read("near")
    with pytest.raises(ValueError, match="is not the name of a file of the run"):
        changed.table("../a/spectra.csv")
    with pytest.raises(KeyError, match="not there any more"):
        named("gone.wav").pressure("near")
    if sys.platform != "win32":
        for target in (outside, Path(own)):
            (folder / "link.wav").symlink_to(target)
            with pytest.raises(ValueError, match=r"link\.wav is a link"):
                named("link.wav").pressure("near")
            (folder / "link.wav").unlink()
    assert named(own).pressure("near")[1].tobytes() == kept.tobytes()


def test_arrays_are_handed_over_and_not_copied(scene: tyrewave.Scene, tmp_path: Path) -> None:
    memory = scene.run()
    for name in ARRAYS:
        owner: object = memory[name]
        while isinstance(owner, np.ndarray) and owner.base is not None:
            owner = owner.base
        # numpy owns nothing of it: the memory is the run's own.
        assert not isinstance(owner, np.ndarray), name
        assert "PySliceContainer" in type(owner).__name__, name
        assert memory[name].flags.c_contiguous and not memory[name].flags.owndata
    scene.run(tmp_path / "a")
    for name, array in tyrewave.open(tmp_path / "a").items():
        assert isinstance(array, np.memmap), name


def test_results_are_a_dataset_with_units(scene: tyrewave.Scene) -> None:
    pytest.importorskip("xarray")
    results = scene.run()
    data = results.to_xarray()
    assert data["total_force"].attrs["units"] == "N" and data["time"].attrs["units"] == "s"
    assert data["patch_force"].dims == ("time", "column")
    assert np.shares_memory(data["patch_force"].values, results.patch_force)
    assert data["force_level"].attrs["units"] == "dB" and data["band"].attrs["units"] == "Hz"
    assert data.attrs["scene_sha256"] == results.summary["scene_sha256"]
    assert float(data["total_force"].sum("time")) == pytest.approx(float(data["patch_force"].sum()))


def test_a_plan_says_what_the_program_says(scene: tyrewave.Scene, program: Callable[..., str]) -> None:
    plan = scene.plan(threads=1)
    line = program("plan", ROOT / "scenes/default.toml", *settings(SMALL), "--json", "--threads", "1")
    told = json.loads(line)
    for name in ("sizes", "effects", "choices", "notes", "work", "counters", "result_bytes", "scene_sha256"):
        assert plan.record[name] == told[name], name
    assert plan.sizes["elements"] == 64
    assert all(effect["reason"] for effect in plan.effects)
    assert plan.forecast["threads"] == 1 and plan.forecast["wall_seconds"] > 0.0
    assert "64 elements" in repr(plan)


def test_what_should_be_known_is_a_warning() -> None:
    missed = tyrewave.Scene.load(ROOT / "scenes/default.toml", set=SMALL | {"rolling.axle.tolerance": 1e-9})
    with pytest.warns(tyrewave.RunWarning, match="off the load") as told:
        missed.run()
    assert told[0].filename == __file__


def test_choices_of_a_preset_are_notes_and_no_warnings() -> None:
    chosen = {"numerics": {"preset": "draft", "fmax": 200.0}, "rolling.duration": 1.5, "rolling.axle.tolerance": 0.5}
    scene = tyrewave.Scene.load(ROOT / "scenes/default.toml", set=chosen)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", tyrewave.RunWarning)
        results = scene.run()
    assert any("numerics.elements = " in note for note in results.notes)
    assert not any("numerics." in str(warning.message) for warning in told)


def test_progress_is_told() -> None:
    told: list[tuple[str, int, int]] = []
    scene = tyrewave.Scene.load(ROOT / "scenes/default.toml", set=SMALL | {"rolling.duration": 3.0})
    scene.run(progress=lambda *state: told.append(state))
    stages = {stage for stage, _, _ in told}
    assert "roll" in stages, told
    steps = [(done, total) for stage, done, total in told if stage == "roll"]
    assert steps == sorted(steps) and all(0 <= done <= total for done, total in steps)

"""Results of a run: arrays, tables, summary, with their units."""

from __future__ import annotations

import io
import json
import os
import warnings
from collections.abc import Iterator, Mapping
from os import PathLike
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tyrewave import _native
from tyrewave._progress import Told, teller
from tyrewave._table import Table

if TYPE_CHECKING:
    import xarray

_Path = str | PathLike[str]

_KINDS_OF_PATH = (PurePosixPath, PureWindowsPath)
"""Rules by which a name may hold folders; a plain name holds none by either."""

_CHANNELS = {name: (unit, meaning, row, every) for name, unit, meaning, row, every in _native.channels()}

UNITS = {name: unit for name, (unit, *_) in _CHANNELS.items()}
"""Units of the arrays."""


class RunWarning(UserWarning):
    """Something that the user of a run's results should act on."""


class Results(Mapping[str, NDArray[Any]]):
    """Results of a run: a mapping of arrays by name, beside tables and a summary.

    Arrays have a row for every time step, the warm-up included. Those of a folder are mapped, not read: they take no
    memory until they are looked at, and cannot be written to.
    """

    folder: Path | None
    """Where they are; None for results in memory."""
    summary: dict[str, Any]
    """Settings, outcome and cost of the run: `summary.json` of a results folder."""
    units: dict[str, str]
    """Units of the arrays; those of a table are in its own `units`."""

    def __init__(
        self, arrays: dict[str, NDArray[Any]], summary: dict[str, Any], files: dict[str, bytes], folder: Path | None
    ) -> None:
        self._arrays, self._files = arrays, files
        self.summary, self.folder = summary, folder
        self.units = {name: unit for name in arrays if (unit := _unit(name)) is not None}

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self._arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    def __repr__(self) -> str:
        shapes = ", ".join(f"{name} {list(array.shape)}" for name, array in self._arrays.items())
        where = "in memory" if self.folder is None else f"in {self.folder}"
        return f"<tyrewave.Results {where}: {self.summary['title']}; {shapes}>"

    @property
    def time(self) -> NDArray[np.float64]:
        """Time [s], [steps]."""
        return self["time"]

    @property
    def total_force(self) -> NDArray[np.float64]:
        """Contact force [N], [steps]."""
        return self["total_force"]

    @property
    def patch_force(self) -> NDArray[np.float64]:
        """Contact force of every element of a window round the patch [N], [steps, columns]."""
        return self["patch_force"]

    @property
    def patch_element(self) -> NDArray[np.int64]:
        """Number of the element in the window's first column, [steps]."""
        return self["patch_element"]

    @property
    def warnings(self) -> list[str]:
        """Texts that the user should act on: each was a `RunWarning` of the run."""
        return list(self.summary["warnings"])

    @property
    def notes(self) -> list[str]:
        """Settings that were chosen, and what the run leaves out. Empty for results of before 2026-11-25, which have
        them among their warnings."""
        return list(self.summary.get("notes", []))

    @property
    def spectra(self) -> Table:
        """Third octaves of the contact force after the warm-up: the columns of `spectra.csv`, levels in dB re 1 N.

        Empty for a run that is too short. `valid` is a mask of the bands that are valid.
        """
        return self.table("spectra.csv")

    @property
    def vibration(self) -> Table:
        """Third octaves of velocities of tread and belt, dB re 1 m/s: the columns of `vibration.csv`; empty unless the
        scene asks for them."""
        return self.table("vibration.csv")

    @property
    def sound(self) -> dict[str, Table]:
        """Third octaves at each receiver, dB re 20 uPa and dB(A): the columns of `sound.csv` by the receiver's name."""
        table = self.table("sound.csv")
        if not table:
            return {}
        names = table.pop("receiver")
        return {str(name): table.where(names == name) for name in dict.fromkeys(names.tolist())}

    def table(self, name: str) -> Table:
        """Columns of a table of the run, by its file's name; empty where it has none. An empty cell is NaN.

        A `ValueError` for a name that leads out of the run's folder, and for a link.
        """
        content = self._file(name)
        return Table({}) if content is None else Table.of_csv(content.decode("utf-8"))

    def pass_by(self, receiver: str) -> Table:
        """Level against time as the tyre, or the vehicle, passes a receiver beside the road: A-weighted, time weighting
        F, mean over the passages. A `KeyError` where nothing passes it, or the run is too short for a passage."""
        return self.table(self._receiver_file(receiver, "pass_by", "passage")["file"])

    def pressure(self, receiver: str) -> tuple[int, NDArray[np.float64]]:
        """The sound at a receiver: samples a second, and pressures [Pa], [samples, channels]. A `KeyError` where it is
        not recorded, a `ValueError` where the summary names a file outside of the run's folder, or a link."""
        name = self._receiver_file(receiver, "audio", "sound")["file"]
        content = self._file(name)
        if content is None:
            raise KeyError(f"{name} is not there any more")
        return _native.read_sound(name, content)

    def _receiver_file(self, receiver: str, key: str, what: str) -> dict[str, Any]:
        """Entry of the summary for a file of a receiver."""
        receivers = (self.summary.get("sound") or {"receivers": []})["receivers"]
        found: dict[str, Any] | None = next((entry.get(key) for entry in receivers if entry["name"] == receiver), None)
        if found is None:
            names = ", ".join(repr(entry["name"]) for entry in receivers if entry.get(key)) or "none"
            raise KeyError(f"no {what} at a receiver {receiver!r}; those that have one: {names}")
        return found

    def _file(self, name: str) -> bytes | None:
        """Content of a file of the run. A folder may come from a stranger, and so may the names in its summary."""
        plain = isinstance(name, str) and all(name == kind(name).name for kind in _KINDS_OF_PATH)
        if not plain or name in ("", ".."):
            raise ValueError(f"{name!r} is not the name of a file of the run; nothing outside of its folder is read")
        if self.folder is None:
            return self._files.get(name)
        path = self.folder / name
        if path.is_symlink():
            raise ValueError(f"{path} is a link, and links are not followed here")
        return path.read_bytes() if path.is_file() else None

    def to_xarray(self) -> xarray.Dataset:
        """Arrays and third octaves as a dataset, units and names in the attributes. Needs xarray."""
        try:
            import xarray
        except ImportError as missing:
            raise ImportError("to_xarray needs the package xarray: pip install xarray") from missing

        data: dict[str, Any] = {}
        for name, array in self._arrays.items():
            unit, meaning, row, every_step = _CHANNELS.get(name, ("", "", "", False))
            if every_step and name != "time":
                dims = ["time", row] if row else ["time"]
                data[name] = (dims, array, {"units": unit, "long_name": meaning})
        coordinates: dict[str, Any] = {}
        if "time" in self:
            coordinates["time"] = ("time", self.time, {"units": "s", "long_name": _CHANNELS["time"][1]})
        if bands := self.spectra:
            coordinates["band"] = ("band", bands["nominal_hz"], {"units": "Hz", "long_name": "nominal frequency"})
            attributes = {"units": "dB", "long_name": "contact force level re 1 N"}
            data["force_level"] = ("band", bands["level_db_re_1n"], attributes)
            data["force_level_valid"] = ("band", bands["valid"], {"long_name": "the band is valid"})
        if sound := self.sound:
            tables = list(sound.values())
            sound_bands = tables[0]["nominal_hz"]
            coordinates["receiver"] = ("receiver", list(sound))
            coordinates["sound_band"] = ("sound_band", sound_bands, {"units": "Hz", "long_name": "nominal frequency"})
            for name, column, units in (
                ("sound_level", "level_db_re_20upa", "dB"),
                ("sound_level_a", "level_db_a", "dB(A)"),
            ):
                levels = np.stack([table[column] for table in tables])
                attributes = {"units": units, "long_name": "sound pressure level re 20 uPa"}
                data[name] = (["receiver", "sound_band"], levels, attributes)
            valid = np.stack([table["valid"] for table in tables])
            data["sound_level_valid"] = (["receiver", "sound_band"], valid, {"long_name": "the band is valid"})
        about = {name: self.summary[name] for name in ("title", "version", "scene_sha256")}
        return xarray.Dataset(data, coordinates, about)


def _unit(array: str) -> str | None:
    return UNITS["vibration_map"] if array.startswith("vibration_map_") and array not in UNITS else UNITS.get(array)


def in_memory(found: dict[str, Any]) -> Results:
    """Results from what a run has handed over."""
    summary, files = json.loads(found.pop("summary")), found.pop("files")
    for name in [name for name in files if name.endswith(".npy")]:
        found[name.removesuffix(".npy")] = np.load(io.BytesIO(files.pop(name)), allow_pickle=False)
    return Results(found, summary, files, None)


def open_results(folder: _Path) -> Results:
    """Opens a results folder, of a run that is complete or not. Arrays are mapped, not read.

    What is not there is a `FileNotFoundError`, a file a `NotADirectoryError`, any other folder a `ValueError`.
    """
    place = Path(folder)
    # The system's own error where it is no folder.
    names = os.listdir(place)
    try:
        summary = json.loads((place / "summary.json").read_text(encoding="utf-8")) if "summary.json" in names else None
    except ValueError:
        summary = None
    if not isinstance(summary, dict) or summary.get("format") != "tyrewave results":
        raise ValueError(f"{place} is not a tyrewave results folder: it has no summary.json of one")
    arrays: dict[str, NDArray[Any]] = {
        path.stem: np.load(path, mmap_mode="r", allow_pickle=False) for path in sorted(place.glob("*.npy"))
    }
    return Results(arrays, summary, {}, place)


def warned(results: Results, depth: int) -> Results:
    """The results, after what the user should act on was said."""
    for text in results.warnings:
        warnings.warn(text, RunWarning, stacklevel=depth + 1)
    return results


def resume(folder: _Path, *, threads: int | None = None, progress: Told | bool | None = None) -> Results:
    """Goes on with a run into a folder that was interrupted or killed, named by its results folder or by its own: the
    same bytes as if it had never stopped."""
    return warned(open_results(_native.resume(folder, threads, teller(progress))), 2)

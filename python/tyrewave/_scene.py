"""Scenes: what rolls on what, and all that can be asked of it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tyrewave import _native
from tyrewave._contact import numbers
from tyrewave._plan import Plan
from tyrewave._progress import Told, teller
from tyrewave._results import Results, in_memory, open_results, warned
from tyrewave._sweep import Sweep
from tyrewave._sweep import warned as warned_of
from tyrewave._table import Table

_Path = str | PathLike[str]


def _whole(values: ArrayLike) -> list[int]:
    array = np.atleast_1d(np.asarray(values))
    if array.size and not np.issubdtype(array.dtype, np.integer):
        raise TypeError(f"whole numbers are needed, not {array.dtype}")
    return [int(value) for value in array.ravel()]


class Scene:
    """A tyre, a road, and how the one rolls over the other; checked, with every default filled in.

    Made by `Scene.load`, `Scene.from_toml` or `Scene.from_dict`. `set` holds settings in place of the scene's own, by
    key: `{"rolling.speed_kmh": 110, "receiver[0].position": [0, 7.5, 1.2]}`.
    """

    def __init__(self, native: _native.Scene) -> None:
        self._native = native

    @classmethod
    def load(cls, path: _Path, *, set: Mapping[str, Any] | None = None, allow_outside: bool = False) -> Scene:
        """Reads a scene file. Its tyre and its road lie in its folder or below, unless `allow_outside`."""
        return cls(_native.Scene.load(path, dict(set or {}), allow_outside))

    @classmethod
    def from_toml(cls, text: str, *, name: str = "scene", set: Mapping[str, Any] | None = None) -> Scene:
        """Reads a scene from a text; `name` stands in messages where a file's name would."""
        return cls(_native.Scene.from_toml(text, name, dict(set or {})))

    @classmethod
    def from_dict(cls, keys: Mapping[str, Any], *, name: str = "scene", set: Mapping[str, Any] | None = None) -> Scene:
        """Makes a scene of a dictionary with the keys of a scene file; what is None counts as left out.

        Lines in complaints are those of the scene as TOML.
        """
        return cls(_native.Scene.from_dict(dict(keys), name, dict(set or {})))

    @property
    def title(self) -> str:
        """The title, or the name where there is none."""
        return self._native.title

    @property
    def name(self) -> str:
        """The file's name without its ending."""
        return self._native.name

    @property
    def settings(self) -> dict[str, Any]:
        """All settings, defaults filled in: a dictionary for `Scene.from_dict`."""
        settings: dict[str, Any] = json.loads(self._native.settings())
        return settings

    @property
    def sha256(self) -> str:
        """The settings' digest, which results bear."""
        return self._native.sha256()

    def to_toml(self) -> str:
        """The scene as a text for a file, every default spelt out."""
        return self._native.to_toml()

    def __repr__(self) -> str:
        return f"<tyrewave.Scene {self.name}: {self.title}>"

    def plan(self, *, threads: int | None = None) -> Plan:
        """Plans a run: its work with reasons, and its cost on so many threads of this machine.

        The first time on a machine, costs of units of work are measured (two or three seconds) and kept.
        """
        return Plan(json.loads(_native.plan(self._native, threads)))

    def run(
        self, out: _Path | None = None, *, threads: int | None = None, progress: Told | bool | None = None
    ) -> Results:
        """Rolls the tyre: into memory, or into the folder `out`, which gets the very bytes of the command line.

        Memory holds what the folder does, pictures and arrays of cells excepted. `progress` is called some ten times a
        second as `progress(stage, done, total)`, `total` being 0 where it is not known; True: a line on standard error.
        What is raised in it, and Ctrl-C, stops the run after its step; a run into a folder is kept then, the
        exception's `kept` says where, and `tyrewave.resume` goes on. Results do not depend on `threads` (default: all
        processors).
        """
        told = teller(progress)
        if out is None:
            return warned(in_memory(_native.run_in_memory(self._native, threads, told)), 2)
        return warned(open_results(_native.run_to_folder(self._native, out, threads, told)), 2)

    def sweep(
        self,
        out: _Path,
        *,
        speed_kmh: ArrayLike | None = None,
        load: ArrayLike | None = None,
        road: Sequence[_Path] = (),
        set: Mapping[str, Sequence[Any]] | None = None,
        threads: int | None = None,
        progress: Told | bool | None = None,
    ) -> Sweep:
        """Rolls every combination of speeds [km/h], loads [N], road files and values of other keys, each into a folder
        of its own below `out`, several at a time.

        `set` has the values of a key, `{"road.seed": [1, 2, 3]}`; over those of seeds there are means. The same call
        again, also after Ctrl-C, leaves alone what is finished and goes on with the rest. Failed variants are a
        `RunError`; the others are done then.
        """
        values: dict[str, list[Any]] = {
            "speed_kmh": [] if speed_kmh is None else numbers(speed_kmh),
            "load": [] if load is None else numbers(load),
            "road": list(road),
        }
        factors = [(key, list(listed)) for key, listed in (set or {}).items()]
        for name, listed in [*values.items(), *factors]:
            if len({repr(value) for value in listed}) < len(listed):
                raise ValueError(f"{name}: a value is given twice")
        if not (factors or any(values.values())):
            raise ValueError("nothing is varied: give speed_kmh, load, road, or set, such as {'road.seed': [1, 2, 3]}")
        axes = (values["speed_kmh"], values["load"], values["road"])
        found = _native.sweep(self._native, out, axes, factors, threads, teller(progress))
        return warned_of(Sweep(Path(out), found), 2)

    def effects(
        self, *, duration: float | None = None, threads: int | None = None, progress: Told | bool | None = None
    ) -> Table:
        """Measures the worth of each effect: the columns of `effects.csv`, a row for each run without any effect, with
        all, with one alone (`+`), with all but one (`-`).

        `duration` [s] is rolled after the warm-up for each, by default the scene's, at most 3 s.
        """
        return Table.of_csv(_native.effects(self._native, duration, threads, teller(progress)))

    def tyre(
        self,
        *,
        waves: int = 10,
        lateral: int = 3,
        highest: float = 500.0,
        load: ArrayLike = (2943.0, 3433.5, 3924.0),
        rolling: bool = False,
        patch: ArrayLike = (0.05, 0.02, 0.01, 0.005),
        points: int = 300,
        threads: int | None = None,
        progress: Told | bool | None = None,
    ) -> dict[str, Any]:
        """Describes the tyre as `tyre.json` of `tyrewave tyre` does: modes, stiffness and patch under loads, mobility.

        Modes with up to `waves` periods round the tyre, of the `lateral` lowest numbers across it, up to `highest`
        [Hz]; loads [N], with the mean length of the patch at the scene's speed if `rolling`; mobility of square patches
        [m] at so many `points` over frequency.
        """
        under, mobility = (numbers(load), rolling), (numbers(patch), points)
        told = _native.tyre(self._native, (waves, lateral, highest), under, mobility, threads, teller(progress))
        described: dict[str, Any] = json.loads(told)
        return described

    def radiation(
        self,
        *,
        highest: float = 2500.0,
        points: int = 16,
        threads: int | None = None,
        progress: Told | bool | None = None,
    ) -> dict[str, Any]:
        """Describes how the tyre radiates as it stands on a road, as `radiation.json` of `tyrewave radiation` does:
        transfers [1/m] and horn amplification [dB] at some receivers, directivity on a circle, which waves radiate.

        At so many `points` from 100 Hz to `highest` [Hz].
        """
        told = _native.radiation(self._native, highest, points, threads, teller(progress))
        described: dict[str, Any] = json.loads(told)
        return described

    def compliance(self, around: ArrayLike, frequency: ArrayLike, *, lateral: int = 0) -> NDArray[np.complex128]:
        """Compliance C [m/Pa] of the tread's surface, [waves, frequencies, 3, 3]: displacement i for unit traction j.

        For waves with `around` periods round the tyre and the number `lateral` across it, at frequencies [Hz]. Order of
        the directions: circumferential, lateral, outward.
        """
        return _native.compliance(self._native, _whole(around), lateral, numbers(frequency))

    def mobility(self, frequency: ArrayLike, *, patch: ArrayLike = 0.02) -> NDArray[np.complex128]:
        """Driving-point mobility [m/(N s)] of square patches in the middle of the tread, [frequencies, patches].

        `frequency` [Hz]; `patch`: sides [m].
        """
        return _native.mobility(self._native, numbers(patch), numbers(frequency))

    def influence(self, distance: ArrayLike, time: ArrayLike) -> NDArray[np.float64]:
        """Influence function g [m/(N s)], [distances, times]: displacement after a unit impulse on one element.

        `distance` in whole elements, those of a tyre that turns counted against its rotation; `time` [s]. From the poles
        fitted to the tyre, which are kept on disk.
        """
        return _native.influence(self._native, _whole(distance), numbers(time))

    def influence_spectrum(self, wavenumber: ArrayLike, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Influence function H_n [m/N] over wavenumber and frequency, [wavenumbers, frequencies].

        `wavenumber`: whole waves round the tyre, at most half of the elements; of a tyre that turns those above 0 run
        with the rotation, those below 0 against it. `frequency` [Hz].
        """
        return _native.influence_spectrum(self._native, _whole(wavenumber), numbers(frequency))

    def heights(self, start: float = 0.0, length: float = 1.0) -> dict[str, NDArray[np.float64]]:
        """Heights of the road as the run sees it: `heights` [m], [rows, columns], at `x` along and `y` across [m].

        `length` [m] from the road coordinate `start` [m] on, in whole elements; less where the road ends.
        """
        return _native.heights(self._native, start, length)

    def road(self) -> dict[str, Any]:
        """The road described: third octaves of its texture, profile depth, what was found in its file."""
        described: dict[str, Any] = json.loads(_native.road_description(self._native))
        return described

    def slices(self, penetration: ArrayLike, *, start: float = 0.0, count: int = 100) -> dict[str, NDArray[np.float64]]:
        """Displacement S [m] of `count` slices of the road from `start` [m] on, by both laws, [slices, penetrations].

        `penetration` [m] past each slice's highest point. Laws: "winkler" and "half-space".
        """
        return _native.slice_displacements(self._native, start, count, numbers(penetration))

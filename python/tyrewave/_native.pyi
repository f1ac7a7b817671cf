from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Complaint",
    "RunError",
    "Scene",
    "SceneError",
    "channels",
    "compliance",
    "effects",
    "heights",
    "indent",
    "influence",
    "influence_spectrum",
    "mobility",
    "plan",
    "radiation",
    "read_sound",
    "resume",
    "road_description",
    "run_in_memory",
    "run_to_folder",
    "slice_curve",
    "slice_displacements",
    "sweep",
    "third_octaves",
    "tyre",
]

_Progress: TypeAlias = Callable[[str, int, int], object]
_Path: TypeAlias = str | PathLike[str]

class SceneError(ValueError):
    complaints: list[Complaint]

class RunError(RuntimeError): ...

@final
class Complaint:
    file: str
    line: int
    column: int
    key: str
    message: str
    hint: str
    text: str

@final
class Scene:
    title: str
    name: str
    @staticmethod
    def load(path: _Path, settings: dict[str, Any] | None = None, allow_outside: bool = False) -> Scene: ...
    @staticmethod
    def from_toml(text: str, name: str = "scene", settings: dict[str, Any] | None = None) -> Scene: ...
    @staticmethod
    def from_dict(keys: dict[str, Any], name: str = "scene", settings: dict[str, Any] | None = None) -> Scene: ...
    def settings(self) -> str: ...
    def to_toml(self) -> str: ...
    def sha256(self) -> str: ...

def channels() -> list[tuple[str, str, str, str, bool]]: ...
def plan(scene: Scene, threads: int | None = None) -> str: ...
def run_in_memory(scene: Scene, threads: int | None = None, progress: _Progress | None = None) -> dict[str, Any]: ...
def run_to_folder(scene: Scene, out: _Path, threads: int | None = None, progress: _Progress | None = None) -> Path: ...
def resume(folder: _Path, threads: int | None = None, progress: _Progress | None = None) -> Path: ...
def compliance(
    scene: Scene, around: Sequence[int], lateral: int, frequencies: Sequence[float]
) -> NDArray[np.complex128]: ...
def mobility(scene: Scene, patches: Sequence[float], frequencies: Sequence[float]) -> NDArray[np.complex128]: ...
def influence(scene: Scene, distances: Sequence[int], times: Sequence[float]) -> NDArray[np.float64]: ...
def influence_spectrum(
    scene: Scene, wavenumbers: Sequence[int], frequencies: Sequence[float]
) -> NDArray[np.complex128]: ...
def heights(scene: Scene, start: float, length: float) -> dict[str, NDArray[np.float64]]: ...
def slice_displacements(
    scene: Scene, start: float, count: int, at: Sequence[float]
) -> dict[str, NDArray[np.float64]]: ...
def road_description(scene: Scene) -> str: ...
def slice_curve(
    heights: Sequence[float], cell: tuple[float, float], law: str, at: Sequence[float]
) -> dict[str, NDArray[np.float64]]: ...
def indent(
    heights: NDArray[np.float64],
    cell: tuple[float, float],
    modulus: float,
    load: float | None = None,
    penetration: float | None = None,
    tolerance: float | None = None,
) -> dict[str, Any]: ...
def third_octaves(
    signal: NDArray[np.float64], time_step: float, reference: float, lowest: float, segment: float | None = None
) -> dict[str, NDArray[np.float64]]: ...
def read_sound(name: str, file: bytes) -> tuple[int, NDArray[np.float64]]: ...
def tyre(
    scene: Scene,
    range: tuple[int, int, float],
    under: tuple[Sequence[float], bool],
    mobility: tuple[Sequence[float], int],
    threads: int | None = None,
    progress: _Progress | None = None,
) -> str: ...
def radiation(
    scene: Scene, highest: float, points: int, threads: int | None = None, progress: _Progress | None = None
) -> str: ...
def effects(
    scene: Scene, duration: float | None = None, threads: int | None = None, progress: _Progress | None = None
) -> str: ...
def sweep(
    scene: Scene,
    out: _Path,
    axes: tuple[Sequence[float], Sequence[float], Sequence[_Path]],
    factors: Sequence[tuple[str, Sequence[Any]]],
    threads: int | None = None,
    progress: _Progress | None = None,
) -> dict[str, Any]: ...

"""Sweeps: one scene at many speeds, loads, roads and settings."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from tyrewave._results import Results, RunWarning, open_results
from tyrewave._table import Table


class Sweep(Mapping[str, Results]):
    """Results of a sweep: a mapping of the results of its variants by name, beside its tables.

    The results are opened when they are looked at.
    """

    folder: Path
    """Where they are, each variant in a folder of its name."""
    missed: list[str]
    """Variants that missed their load by more than the axle's tolerance."""
    table: Table
    """Third octaves of the contact force by speed, and how they grow with it: the columns of `sweep.csv`."""
    sound: Table
    """Levels at receivers, and how they grow with the speed: the columns of `sweep_sound.csv`; empty without any."""
    design: Table
    """Means over seeds with their 95 % intervals: the columns of `design.csv`; empty unless other keys are varied."""

    def __init__(self, folder: Path, found: dict[str, Any]) -> None:
        self.folder, self.missed = folder, found["missed"]
        self._names: list[str] = found["names"]
        texts = [found[name] for name in ("sweep.csv", "sweep_sound.csv", "design.csv")]
        self.table, self.sound, self.design = (Table({}) if text is None else Table.of_csv(text) for text in texts)

    def __getitem__(self, name: str) -> Results:
        if name not in self._names:
            raise KeyError(name)
        return open_results(self.folder / name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __repr__(self) -> str:
        return f"<tyrewave.Sweep in {self.folder}: {', '.join(self._names)}>"


def warned(sweep: Sweep, depth: int) -> Sweep:
    """The sweep, after what the user should know was said."""
    if sweep.missed:
        told = f"{', '.join(sweep.missed)}: missed the load by more than its tolerance; the results are kept"
        warnings.warn(told, RunWarning, stacklevel=depth + 1)
    return sweep

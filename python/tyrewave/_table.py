"""Tables: columns as arrays, with their units."""

from __future__ import annotations

import csv
import io
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

_UNITS = [
    (re.compile(name), unit)
    for name, unit in (
        ("db_re_1n(_|$)", "dB re 1 N"),
        ("db_re_1m_s(_|$)", "dB re 1 m/s"),
        ("db_re_20upa(_|$)", "dB re 20 uPa"),
        ("db_a(_|$)", "dB(A)"),
        ("db_per_decade$", "dB/decade"),
        ("_db$", "dB"),
        ("_m2_s2_hz$", "m^2/s^2/Hz"),
        ("_m2_s2$", "m^2/s^2"),
        ("_pa2_hz$", "Pa^2/Hz"),
        ("_n2$", "N^2"),
        ("_n_per_m$", "N/m"),
        ("_hz$", "Hz"),
        ("_kmh$", "km/h"),
        ("_m$", "m"),
        ("_n$", "N"),
        ("_s$", "s"),
        ("_w$", "W"),
        ("_bytes$", "bytes"),
        ("^(element|speeds|runs|rolling_resistance)$", "1"),
    )
]
"""Units by what a column's name holds; the first that fits counts."""

_TEXTS = {"receiver", "field", "frame", "group", "effects", "quantity", "unit"}
"""Columns of names, also where they look like numbers."""

_MASKS = {"valid", "load_met"}
"""Columns of yes and no."""


class Table(dict[str, NDArray[Any]]):
    """Columns of a table by name: names, masks (`valid`) as arrays of bool, all others as numbers; an empty cell is
    NaN."""

    units: dict[str, str]
    """Units of the columns of numbers."""

    def __init__(self, columns: dict[str, NDArray[Any]]) -> None:
        super().__init__(columns)
        self.units = {name: unit for name in self if (unit := _unit(self, name)) is not None}

    @classmethod
    def of_csv(cls, text: str) -> Table:
        """Reads the text of a file."""
        rows = csv.reader(io.StringIO(text))
        header = next(rows)
        columns = list(zip(*rows, strict=True)) or [()] * len(header)
        return cls({name: _column(name, cells) for name, cells in zip(header, columns, strict=True)})

    def where(self, rows: NDArray[np.bool_]) -> Table:
        """The rows of a mask."""
        return Table({name: values[rows] for name, values in self.items()})


def _unit(table: Table, name: str) -> str | None:
    if table[name].dtype.kind != "f":
        return None
    return next((unit for pattern, unit in _UNITS if pattern.search(name)), None)


def _column(name: str, cells: tuple[str, ...]) -> NDArray[Any]:
    if name in _TEXTS:
        return np.array(cells, dtype=np.str_)
    if name in _MASKS and all(cell in ("0", "1") for cell in cells):
        return np.array([cell == "1" for cell in cells], dtype=np.bool_)
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells)

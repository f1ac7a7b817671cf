"""First things: import, the ten lines, the notebook; and what memory a run takes."""

import json
import os
import re
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT, SMALL, settings

import tyrewave

LINES = re.search(r"```python\n(.*?)```", (ROOT / "python/README.md").read_text(), re.DOTALL)


def python(code: str, **environment: str) -> str:
    line = [sys.executable, "-c", code]
    surrounding = os.environ | environment
    return subprocess.run(line, check=True, capture_output=True, text=True, cwd=ROOT, env=surrounding).stdout


def test_the_ten_lines_are_ten_and_do_what_they_say() -> None:
    assert LINES is not None
    code = LINES[1]
    assert len([line for line in code.splitlines() if line]) == 9
    # They stand in the package's own page, too.
    assert tyrewave.__doc__ is not None
    assert re.sub(r"\s", "", code) in re.sub(r"\s", "", tyrewave.__doc__)
    # The same lines with fewer elements: a test must be quick.
    told = python(code.replace('{"rolling', '{"numerics.elements": 64, "rolling', 1))
    assert "64 elements" in told and re.search(r"^3\d{3}\.\d+ N$", told, re.MULTILINE), told
    assert re.search(r"^ +160 Hz +-?\d+\.\d dB re 1 N$", told, re.MULTILINE), told


def test_import_takes_little_more_than_numpy() -> None:
    def seconds(code: str) -> float:
        def once() -> float:
            begin = time.perf_counter()
            python(code)
            return time.perf_counter() - begin

        return statistics.median(once() for _ in range(5))

    own = seconds("import numpy, tyrewave") - seconds("import numpy")
    print(f"import tyrewave takes {1e3 * own:.0f} ms beside numpy")
    assert own < 0.3


def test_a_run_takes_little_more_memory_than_the_program_s(program: Callable[..., str], tmp_path: Path) -> None:
    if not Path("/proc/self/status").exists():
        pytest.skip("the system does not tell the largest memory of a process")
    begin = f"import tyrewave; scene = tyrewave.Scene.load('scenes/default.toml', set={SMALL!r})\n"
    peak = "print(next(int(line.split()[1]) for line in open('/proc/self/status') if line.startswith('VmHWM')))"
    idle, folder, memory = (
        int(python(begin + run + peak)) / 1024
        for run in (
            "",
            f"results = scene.run({str(tmp_path / 'a')!r}, threads=2)\n",
            "results = scene.run(threads=2)\n",
        )
    )
    line = program("run", "scenes/default.toml", *settings(SMALL), "--threads", 2, "--out", tmp_path / "b", "--json")
    alone = json.loads(line)["cost"]["peak_memory"] / 2**20
    print(f"largest memory in MiB: idle {idle:.0f}, run into a folder {folder:.0f}, in memory {memory:.0f}", end="; ")
    print(f"the program {alone:.0f}")
    # Beside what python and numpy take, which is what they take idle.
    assert folder < alone + idle and memory < alone + idle


PICTURES = 6


def pictures(book: Any) -> list[str]:
    """The pictures in a notebook's outputs."""
    outputs = [output for cell in book.cells for output in cell.get("outputs", [])]
    return [output["data"]["image/png"] for output in outputs if "image/png" in output.get("data", {})]


def texts(cell: Any) -> list[Any]:
    """A cell's outputs without pictures."""
    outputs = [dict(output) for output in cell.get("outputs", [])]
    return [output | {"data": {**output.get("data", {}), "image/png": ""}} for output in outputs]


def test_the_notebook_runs(tmp_path: Path) -> None:
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("matplotlib")
    book = nbformat.read(ROOT / "python/notebooks/tyrewave.ipynb", as_version=4)
    kept, size = pictures(book), (ROOT / "python/notebooks/tyrewave.ipynb").stat().st_size
    assert len(kept) == PICTURES and size < 300_000, "a reader sees what it gives"
    shown = json.dumps([texts(cell) for cell in book.cells])
    assert "Plan: 256 elements" in shown and not re.search(r"(?<![\w.])/\w+/|[A-Z]:\\", shown), "a path of a machine"
    client = nbclient.NotebookClient(
        book, timeout=300, resources={"metadata": {"path": str(ROOT / "python/notebooks")}}
    )
    done = client.execute()
    made = pictures(done)
    assert len(made) == PICTURES and all(len(picture) > 5_000 for picture in made)
    nbformat.write(done, tmp_path / "done.ipynb")
    if keep := os.environ.get("TYREWAVE_NOTEBOOK"):
        nbformat.write(done, keep)

"""Ctrl-C, other threads, and who raises while a run goes on."""

import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path

import pytest

import tyrewave


def interrupt_after(seconds: float) -> None:
    timer = threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT))
    timer.daemon = True
    timer.start()


def test_ctrl_c_stops_a_run_in_memory(long_scene: tyrewave.Scene) -> None:
    interrupt_after(0.5)
    begin = time.perf_counter()
    with pytest.raises(KeyboardInterrupt) as stopped:
        long_scene.run()
    assert time.perf_counter() - begin < 5.0
    assert stopped.value.kept is None  # type: ignore[attr-defined]


def test_ctrl_c_keeps_a_run_into_a_folder_which_goes_on(tmp_path: Path) -> None:
    # Stopped and gone on with, or at once: the same bytes.
    from conftest import ROOT, SMALL

    scene = tyrewave.Scene.load(ROOT / "scenes/default.toml", set=SMALL | {"rolling.duration": 8.0})
    rolling = threading.Event()

    def once(stage: str, done: int, total: int) -> None:
        if stage == "roll" and done and not rolling.is_set():
            rolling.set()
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt) as stopped:
        scene.run(tmp_path / "a", progress=once)
    kept = stopped.value.kept  # type: ignore[attr-defined]
    assert Path(kept) == tmp_path / "a.partial" and not (tmp_path / "a").exists()
    assert (kept / "checkpoint").is_file()
    assert tyrewave.open(kept).summary["complete"] is False
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", tyrewave.RunWarning)
        resumed, whole = tyrewave.resume(tmp_path / "a"), scene.run(tmp_path / "b")
    assert resumed.total_force.tobytes() == whole.total_force.tobytes()
    assert resumed.table("spectra.csv").keys() == whole.spectra.keys() and not kept.exists()


def test_ctrl_c_is_heard_while_influence_functions_are_fitted(long_scene: tyrewave.Scene) -> None:
    # Another tyre than any before: nothing of it is on disk.
    settings = long_scene.settings
    settings["tyre"]["layers"][1]["thickness"] *= 1.0 + 1e-6 * (time.time_ns() % 1000)
    settings["numerics"]["elements"] = 512
    interrupt_after(0.3)
    begin = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        tyrewave.Scene.from_dict(settings).influence(0, 1e-3)
    assert time.perf_counter() - begin < 5.0


def test_what_is_raised_in_progress_stops_the_run(long_scene: tyrewave.Scene) -> None:
    def enough(stage: str, done: int, total: int) -> None:
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        long_scene.run(progress=enough)


def test_other_threads_go_on_meanwhile(long_scene: tyrewave.Scene) -> None:
    counted, over = 0, threading.Event()

    def count() -> None:
        nonlocal counted
        while not over.is_set():
            counted += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    interrupt_after(1.0)
    counter.start()
    with pytest.raises(KeyboardInterrupt):
        long_scene.run(threads=1)
    over.set()
    counter.join()
    # With the interpreter held, not one.
    assert counted > 100


def test_a_run_in_another_thread_and_several_at_once(scene: tyrewave.Scene) -> None:
    found: list[bytes] = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", tyrewave.RunWarning)
        runs = [threading.Thread(target=lambda: found.append(scene.run().total_force.tobytes())) for _ in range(3)]
        for run in runs:
            run.start()
        for run in runs:
            run.join()
    assert len(found) == 3 and len(set(found)) == 1


@pytest.mark.skipif(sys.platform == "win32", reason="no fork there")
def test_a_process_that_forks_after_a_run_computes_in_its_child() -> None:
    code = (
        "import multiprocessing, tyrewave\n"
        "curve = lambda: tyrewave.slice_curve([0.0, 1e-3], 1e-3, 1e-3, 2e-3)['displacement'][0]\n"
        "curve()\n"
        "context = multiprocessing.get_context('fork')\n"
        "child = context.Process(target=curve)\n"
        "child.start(); child.join(20)\n"
        "raise SystemExit(child.exitcode)\n"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False, timeout=40).returncode == 0

"""The sound of a tyre rolling on a rough road.

The first ten lines::

    import tyrewave

    scene = tyrewave.Scene.load("scenes/default.toml", set={"rolling.speed_kmh": 50, "rolling.duration": 2.0})
    print(scene.plan())                     # what the run would do, and what it would take on this machine
    results = scene.run(progress=True)      # in memory; run("results/a") makes the folder of the command line
    print(results.summary["outcome"]["mean_force"], "N")
    rolled = results.time >= scene.settings["rolling"]["warm_up"]
    print(results.total_force[rolled].std(), results.units["total_force"])
    for frequency, level in zip(results.spectra["nominal_hz"], results.spectra["level_db_re_1n"]):
        print(f"{frequency:8g} Hz {level:6.1f} dB re 1 N")

Everything is in SI units. An invalid scene is a `SceneError` with every mistake in its place, a run that
fails a `RunError`, a file that cannot be read or written an `OSError`. While the library computes, other threads of
Python go on; Ctrl-C stops a run after its step. `tyrewave keys` on the command line lists what a scene may hold.
"""

from tyrewave._contact import indent, slice_curve
from tyrewave._native import Complaint, RunError, SceneError
from tyrewave._plan import Plan
from tyrewave._results import Results, RunWarning, open_results, resume
from tyrewave._road import Road
from tyrewave._scene import Scene
from tyrewave._signal import third_octaves
from tyrewave._sweep import Sweep
from tyrewave._table import Table

open = open_results

__all__ = [
    "Complaint",
    "Plan",
    "Results",
    "Road",
    "RunError",
    "RunWarning",
    "Scene",
    "SceneError",
    "Sweep",
    "Table",
    "indent",
    "open",
    "resume",
    "slice_curve",
    "third_octaves",
]

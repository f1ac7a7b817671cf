import csv, json, pathlib, sys
import numpy as np
folder = pathlib.Path(sys.argv[1])  # of tyrewave run
summary = json.loads((folder / "summary.json").read_text())
time, force = (np.load(folder / name) for name in ("time.npy", "total_force.npy"))
counts = time > summary["settings"]["rolling"]["warm_up"] - 0.5 * summary["outcome"]["time_step"]
print("mean force", force[counts].mean(), "N")
bands = [row for row in csv.DictReader((folder / "spectra.csv").open()) if row["valid"] == "1"]
squares = np.array([float(row["mean_square_n2"]) for row in bands])
print("level", 10 * np.log10(squares.sum()), "dB re 1 N, from", bands[0]["nominal_hz"], "Hz on")

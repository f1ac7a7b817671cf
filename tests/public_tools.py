#!/usr/bin/env python3
"""Compares mean profile depth, texture levels and dB(A) with public tools, two for each quantity.

    python3 -m venv venv
    venv/bin/pip install numpy scipy pandas parse unsync loguru psutil matplotlib pydantic PyOctaveBand acoular
    venv/bin/pip install --no-deps captif-slp pyrsona
    venv/bin/python tests/public_tools.py target/release/tyrewave [RESULTS]

captif-slp asks for a pandas of 2023, which it does not need. RESULTS, for dB(A), is the folder of a run with the
sound at a receiver that goes with the tyre (`cpx`).
"""

import csv
import json
import subprocess
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

import numpy as np
from scipy import signal
from scipy.io import wavfile

SPACING = 0.5  # mm
LENGTH = 6000.0  # mm
MILLIMETRES = 1e-3


def texture():
    """Returns distances and heights [mm] of a made profile: equal levels of all third octaves of 4 to 100 mm."""
    random = np.random.default_rng(1)
    distances = np.arange(0, LENGTH, SPACING)
    heights = np.zeros_like(distances)
    for wavelength in np.geomspace(4, 100, 400):
        heights += 0.05 * np.cos(2 * np.pi * (distances / wavelength + random.random()))
    return distances, np.round(heights, 4)


def row(quantity, ours, *others):
    """Prints a value beside those of others, with the differences."""
    print(f"{quantity:34s} tyrewave {ours:8.3f}", end="")
    for tool, value in others:
        print(f" | {tool} {value:8.3f} ({value - ours:+.3f})", end="")
    print()


def depth_by_scipy(heights, spacing):
    """The formula of ISO 13473-1:2019 with the filters of SciPy [mm]."""
    low_pass = signal.butter(2, 1 / 2.4, fs=1 / spacing, output="sos")
    smooth = signal.sosfiltfilt(low_pass, heights)
    points = round(100 / spacing)
    depths = []
    for segment in smooth[: len(smooth) // points * points].reshape(-1, points):
        segment = signal.detrend(segment)
        depths.append((segment[: points // 2].max() + segment[points // 2 :].max()) / 2)
    return np.mean(depths)


def depth_by_captif(distances, heights):
    """Mean profile depth by captif-slp [mm]."""
    import pandas
    from captif_slp import Reading

    trace = pandas.DataFrame({"distance_mm": distances, "relative_height_mm": heights})
    return Reading.from_trace(trace, target_sample_spacing_mm=0.5).mpd()["mpd"]


def roads(program):
    distances, heights = texture()
    with tempfile.TemporaryDirectory() as folder:
        profile, results = Path(folder) / "texture.csv", Path(folder) / "road"
        np.savetxt(profile, np.stack([distances, heights], 1), "%.4f", ",", header="distance_mm,height_mm", comments="")
        units = ["--distance-unit", "mm", "--height-unit", "mm"]
        command = [program, "road", profile, *units, "--out", results, "--quiet"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        told = json.loads((results / "road.json").read_text())
    others = [("SciPy", depth_by_scipy(heights, SPACING))]
    try:
        others.insert(0, ("captif-slp", depth_by_captif(distances, heights)))
    except ImportError as error:
        print(f"without captif-slp: {error}")
    row("mean profile depth [mm]", told["mean_profile_depth"]["mean"] / MILLIMETRES, *others)

    # Third octaves: lines of the periodogram, and filters along the profile as if over time (points/m for Hz).
    from pyoctaveband import octavefilter

    straight = signal.detrend(heights) * MILLIMETRES
    cycles, density = signal.periodogram(straight, fs=1e3 / SPACING, window="hann")
    rate = round(1e3 / SPACING)
    filtered, middles = octavefilter(np.tile(straight, 3), rate, fraction=3, limits=[12, 260])
    for level in told["levels"]:
        middle = 1 / level["wavelength"]
        if not level["valid"] or not 12 < middle < 260:
            continue
        inside = (cycles >= middle * 10**-0.05) & (cycles < middle * 10**0.05)
        lines = 10 * np.log10(density[inside].sum() * cycles[1] / 1e-12)
        nearest = int(np.argmin(np.abs(np.log(np.array(middles) / middle))))
        # Its levels are re 20e-6.
        bank = filtered[nearest] + 20 * np.log10(20e-6 / 1e-6)
        wavelength = 1e3 * level["wavelength"]
        row(f"texture at {wavelength:.1f} mm [dB]", level["level"], ("SciPy", lines), ("PyOctaveBand", bank))


def sound(folder):
    """Third octaves of the WAV files of receivers that go with the tyre, weighted and summed over the valid bands."""
    import acoular
    from pyoctaveband import octavefilter

    summary = json.loads((folder / "summary.json").read_text())
    with (folder / "sound.csv").open() as file:
        bands = [band for band in csv.DictReader(file) if band["valid"] == "1"]
    for receiver in summary["sound"]["receivers"]:
        if "pass_by" in receiver or "audio" not in receiver:
            continue
        rate, samples = wavfile.read(folder / receiver["audio"]["file"])
        scale = np.iinfo(samples.dtype).max if samples.dtype.kind == "i" else 1.0
        pressure = samples.reshape(len(samples), -1) / scale * receiver["audio"]["full_scale"]
        name = receiver["name"]
        own = [band for band in bands if band["receiver"] == name and float(band["nominal_hz"]) >= 50]
        middles = np.array([float(band["mid_frequency_hz"]) for band in own])
        levels = np.array([float(band["level_db_re_20upa"]) for band in own])
        weights = np.array([float(band["level_db_a"]) for band in own]) - levels
        limits = [middles[0] * 0.95, middles[-1] * 1.05]
        mean_squares = np.zeros((2, len(middles)))
        for channel in pressure.T:
            filtered, _ = octavefilter(channel, rate, fraction=3, limits=limits)
            mean_squares[0] += 10 ** (np.array(filtered) / 10) / pressure.shape[1]
        source = acoular.TimeSamples(data=pressure, sample_freq=rate)
        for number, middle in enumerate(middles):
            band = acoular.FiltOctave(source=source, band=middle, fraction="Third octave", order=6)
            blocks = np.concatenate(list(band.result(4096)))
            mean_squares[1, number] = np.mean(blocks**2) / 20e-6**2
        total = lambda values: 10 * np.log10(np.sum(10 ** ((values + weights) / 10)))
        tools = ["PyOctaveBand", "acoular"]
        others = [(tool, total(10 * np.log10(found))) for tool, found in zip(tools, mean_squares)]
        label = f"{name}, {own[0]['nominal_hz']} to {own[-1]['nominal_hz']} Hz [dB(A)]"
        row(label, total(levels), *others)


if __name__ == "__main__":
    tools = ["numpy", "scipy", "PyOctaveBand", "acoular", "captif-slp"]
    for tool in tools:
        try:
            print(f"{tool} {version(tool)}", end="  ")
        except ImportError:
            print(f"{tool}: not there", end="  ")
    print()
    roads(sys.argv[1])
    if len(sys.argv) > 2:
        sound(Path(sys.argv[2]))

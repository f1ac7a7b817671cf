"""Mean profile depth, skewness and texture levels of a road's profiles by programs of others.

pip install captif-slp surfalize SurfaceTopography
cargo run --release --example road_profile -- dac-11 > dac-11.csv
python3 profiles/roads_by_public_tools.py dac-11.csv

Depth: captif-slp (CAPTIF, ISO 13473-1:2019). Skewness: surfalize (ISO 25178, Ssk). Levels: spectrum by
SurfaceTopography, summed over third octaves.
"""

import sys

import numpy as np
import pandas as pd
from captif_slp.slp import Reading
from surfalize import Surface
from SurfaceTopography import UniformLineScan


def levels(profiles, spacing):
    """Third-octave texture levels, dB re 1e-6 m, by wavelength in mm."""
    found = {}
    spectra = []
    for heights in profiles:
        scan = UniformLineScan(heights - heights.mean(), len(heights) * spacing)
        wavenumber, density = scan.power_spectrum_from_profile(window="hann", reliable=False, resampling_method=None)
        spectra.append(density)
    density = np.mean(spectra, axis=0)
    step = wavenumber[1] - wavenumber[0]
    for number in range(-22, 0):
        middle = 10.0 ** (-0.1 * number)  # mm
        lower, upper = (2.0 * np.pi / middle * 10.0**edge for edge in (-0.05, 0.05))
        inside = (wavenumber >= lower) & (wavenumber < upper)
        square = 2.0 * density[inside].sum() * step / (2.0 * np.pi)
        found[middle] = 10.0 * np.log10(square * 1e-6 / 1e-12)
    return found


def main(path):
    table = pd.read_csv(path)
    profiles, depths = [], []
    for _, of_profile in table.groupby("profile"):
        heights = of_profile["height_mm"].to_numpy()
        profiles.append(heights)
        trace = pd.DataFrame({"distance_mm": of_profile["distance_mm"].astype(float), "relative_height_mm": heights})
        reading = Reading.from_trace(trace, target_sample_spacing_mm=1.0)
        depths.append(reading.mpd()["mpd"])
    profiles = np.array(profiles)
    surface = Surface(profiles - profiles.mean(), 1.0, 1.0)
    print(f"mean profile depth {np.mean(depths):.3f} mm, skewness {surface.Ssk():.2f}")
    print(", ".join(f"{wavelength:.1f} mm {level:.1f}" for wavelength, level in levels(profiles, 1.0).items()))


main(sys.argv[1])

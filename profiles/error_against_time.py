"""Picture of the error of the force against the time of the steps: error_against_time.csv to an SVG file.

python3 profiles/error_against_time.py profiles/error_against_time.csv profiles/pictures/error_against_time.svg
"""

import csv
import math
import sys

WIDTH, HEIGHT, LEFT, TOP, PANEL, DEEP = 920, 360, 60, 40, 400, 270
TIMES, ERRORS = (0.02, 1000.0), (0.1, 8.0)  # s for a second rolled, dB
COLOURS = {"slices": "#c1492e", "cells": "#1f6f8b", "two meshes": "#6a4c93"}


def place(panel, time, error):
    along = math.log(time / TIMES[0]) / math.log(TIMES[1] / TIMES[0])
    up = math.log(max(error, ERRORS[0]) / ERRORS[0]) / math.log(ERRORS[1] / ERRORS[0])
    return LEFT + panel * (PANEL + 40) + along * PANEL, TOP + (1.0 - up) * DEEP


def text(x, y, words, more=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" {more}>{words}</text>'


def panel(number, road, rows):
    (left, bottom), (right, top) = place(number, TIMES[0], ERRORS[0]), place(number, TIMES[1], ERRORS[1])
    parts = [f'<rect x="{left}" y="{top}" width="{right - left}" height="{bottom - top}" fill="none" stroke="#888"/>']
    parts.append(text(left, top - 10, road, 'font-weight="bold"'))
    for time in (0.1, 1.0, 10.0, 100.0):
        x, _ = place(number, time, 1.0)
        parts.append(f'<path d="M{x:.1f} {bottom}V{top}" stroke="#ddd"/>')
        parts.append(text(x, bottom + 18, f"{time:g}", 'text-anchor="middle"'))
    for error in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0):
        _, y = place(number, 1.0, error)
        parts.append(f'<path d="M{left} {y:.1f}H{right}" stroke="#ddd"/>')
        if number == 0:
            parts.append(text(left - 6, y + 4, f"{error:g}", 'text-anchor="end"'))
    parts.append(text(0.5 * (left + right), bottom + 38, "time of the steps, s for a second rolled",
                      'text-anchor="middle"'))
    for row in rows:
        x, y = place(number, float(row["seconds_per_second"]), float(row["worst_db"]))
        colour = COLOURS[row["kind"]]
        parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4.5" fill="{colour}"/>')
        side = -1 if row["label"] == "left" else 1
        anchor = "end" if side < 0 else "start"
        parts.append(text(x + 8 * side, y + 4, row["name"], f'fill="{colour}" text-anchor="{anchor}"'))
    return parts


def main(table, picture):
    with open(table, encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    roads = list(dict.fromkeys(row["road"] for row in rows))
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" '
             'font-size="12"><rect width="100%" height="100%" fill="white"/>',
             text(0, 0, "error of the worst third octave, 100 Hz to 1 kHz, dB",
                  f'text-anchor="middle" transform="translate(18 {TOP + DEEP / 2}) rotate(-90)"')]
    for number, road in enumerate(roads):
        parts += panel(number, road, [row for row in rows if row["road"] == road])
    with open(picture, "w", encoding="utf-8") as file:
        file.write("\n".join(parts + ["</svg>\n"]))


main(*sys.argv[1:])

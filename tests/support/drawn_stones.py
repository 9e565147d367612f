"""Stones by their corners or painted in pixels, as files of several kinds give them, and whether they came back."""

from __future__ import annotations

import numpy as np
import shapely
from PIL import Image


def polygons(drawing):
    return np.array([shapely.Polygon(outline) for outline in drawing.stones])


def saved(tmp_path, number, kind="colours", name="wall.png"):
    """Save numbers of stones (rows, columns) as a picture in which every stone has a colour, or its number."""
    if kind == "colours":
        colours = np.random.default_rng(1).permutation(2**24 - 2)[: number.max() + 1] + 1
        colours[0] = 0
        code = colours[number]
        picture = Image.fromarray(np.stack([code >> 16, code >> 8 & 255, code & 255], axis=-1).astype(np.uint8))
    elif kind == "palette":
        picture = Image.fromarray(number.astype(np.uint8), mode="P")
        picture.putpalette([0, 0, 0] + np.random.default_rng(1).integers(40, 216, 765).tolist())
    elif kind == "transparent":
        code = np.stack([number * 20 % 256, number * 7 % 256, number, 255 * (number > 0)], axis=-1)
        picture = Image.fromarray(code.astype(np.uint8))
    else:
        picture = Image.fromarray(number.astype(kind))
    picture.save(tmp_path / name)
    return tmp_path / name


def bond(courses=4, mortar=0):
    """Return numbers of the stones of running bond, 60 by 30 pixels each, with void of 20 pixels around."""
    number = np.zeros((40 + 30 * courses, 40 + 240), int)
    count = 0
    for course in range(courses):
        for left in range(-30 * (course % 2), 240, 60):
            count += 1
            first, last = max(left, 0), min(left + 60, 240)
            rows = slice(20 + 30 * course, 20 + 30 * (course + 1) - mortar)
            number[rows, 20 + first : 20 + last - mortar] = count
    return number, count


STONES = [
    [(0, 0), (40, 0), (40, 20), (0, 20)],
    [(40, 0), (100, 0), (95, 20), (40, 20)],
    [(0, 20), (60, 20), (60, 50), (0, 45)],
    [(60, 20), (95, 20), (90, 55), (60, 50)],
]
"""corners in pixels, y downwards"""


GROUND = [(-10, 55), (110, 55), (110, 75), (-10, 75)]


def expected(scale, low=(0, 55)):
    return [(np.array(stone, float) - low) * scale * [1, -1] for stone in STONES]


def same(outline, other):
    return shapely.Polygon(outline).symmetric_difference(shapely.Polygon(other)).area

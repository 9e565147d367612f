"""A picture of the stones, with a scale -> Drawing (Pillow, scikit-image).

Black and white: each connected patch of stone colour is a stone. Colours, or numbers (a label image, a mask): each
connected patch of one colour is a stone, whatever it touches. Mortar between stones is closed: stones grow until they
touch, nowhere beyond what closes joints narrower than the given width.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from annotated_types import Ge, Gt, Le
from scipy import ndimage

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError, naming
from orchestrator.basis.printed import as_place, counted
from orchestrator.basis.units import Unit
from orchestrator.masonry.sources.colours import NEAR_GREY, are_labels, stones_by_colour
from orchestrator.masonry.sources.drawing import Drawing
from orchestrator.masonry.sources.outlines import outlines
from orchestrator.masonry.sources.pixels import Pixels, read_pixels
from orchestrator.masonry.sources.segmentation import cracked, large_patches, run_together, split
from orchestrator.masonry.wall import LARGEST_COUNT

THRESHOLD = 128
"""of 255: the lightness from which a pixel is white, where none is given"""
THRESHOLDS = (32, 64, 96, 160, 192, 224)
"""other thresholds that are tried to see whether they would part more stones"""
HUGE = 20.0
"""times the median area: no stone among others of its wall, lintels included, is that large"""
GREYS = 0.005
"""share of pixels neither black nor white from which a threshold matters"""


@dataclass(frozen=True, slots=True)
class PictureSettings(Checked):
    """What turns pixels into stones."""

    scale: Annotated[float, Gt(0), Unit("m")]
    """side of a pixel"""
    mortar: Annotated[float, Ge(0), Unit("m")] = 0.02
    """widest joint between stones that is closed"""
    stones: Literal["auto", "black", "white", "colours"] = "auto"
    """colour of the stones, or one colour a stone; auto: black, or colours if the picture has sharp patches of many"""
    smallest: Annotated[float, Gt(0), Unit("m")] = 0.02
    """patches of less area than a square of this side are dirt"""
    threshold: Annotated[int, Ge(1), Le(255)] = THRESHOLD
    """lightness from which a pixel is white"""
    split: Annotated[int, Ge(0), Le(20)] = 0
    """pixels of erosion that part stones which run together; 0: they stay one"""
    background: str | float = ""
    """colours of mortar and void in a picture of colours, as in "#000000" or "#000000, #ffffff" (a number in a label
    image of numbers), none: there is none; empty: transparent, else black or white, else 0"""

    @property
    def smallest_patch(self) -> float:
        """Pixels."""
        return (self.smallest / self.scale) ** 2


def read_picture(path: Path, settings: PictureSettings) -> Drawing:
    """Return the stones in the picture `path` in m, y upwards, the lower left corner of its stones at (0, 0).

    Raises CaseError naming file and remedy.
    """
    with naming(path):
        return drawing_of(read_pixels(path), settings)


def drawing_of(pixels: Pixels, settings: PictureSettings) -> Drawing:
    """Return the stones of a picture."""
    kind = _kind(pixels, settings)
    if kind == "colours":
        if settings.split:
            raise CaseError("--split", "does not go with one colour a stone", "paint the stones in two colours")
        number, dirt, remarks = stones_by_colour(pixels, settings.smallest_patch, _background(settings))
    else:
        number, dirt, remarks = _stones_by_lightness(pixels, settings, kind)
    drawing, _ = drawing_of_numbers(number, settings.scale, settings.mortar)
    patches = f"{dirt} {'patch' if dirt == 1 else 'patches'}"
    left_out = [f"{patches} smaller than {1e3 * settings.smallest:g} mm squared left out"] if dirt else []
    return Drawing(drawing.stones, remarks=(*pixels.remarks, *drawing.remarks, *left_out, *remarks))


def _kind(pixels: Pixels, settings: PictureSettings) -> str:
    """Return "black", "white" or "colours", as set or as the picture is."""
    if settings.stones == "colours" and pixels.lossy:
        raise CaseError("--stones", "the picture's format blurs colours into each other", "save it as PNG")
    if settings.stones != "auto":
        return settings.stones
    if settings.split or settings.threshold != THRESHOLD:
        return "black"
    labels = bool(_background(settings)) or are_labels(pixels, settings.smallest_patch)
    return "colours" if labels else "black"


def _background(settings: PictureSettings) -> str:
    return str(settings.background).strip().lower()


def drawing_of_numbers(number: IntArray, scale: float, mortar: float) -> tuple[Drawing, IntArray]:
    """Return the stones (s,) whose numbers the pixels have (0: none), and these numbers (s,), in ascending order.

    scale: side of a pixel in m; mortar: widest joint that is closed, in m.
    """
    if number.max(initial=0) > LARGEST_COUNT:
        raise CaseError("", f"more than {LARGEST_COUNT} patches", "are they stones? see --smallest")
    closed = grown(number, mortar / scale)
    stones, corners, holes = outlines(closed)
    low = lower_left(number)
    turned = tuple(upright(outline, low, scale) for outline in corners)
    found = f"{counted(len(stones), 'stone')} found"
    remarks = [found, f"pixels of {1e3 * scale:.4g} mm: outlines are no better than that"]
    remarks += [f"WARNING: {counted(int(holes.sum()), 'hole')} in stones filled"] if holes.any() else []
    cracks = cracked(number, closed, int(np.ceil(mortar / scale)))
    if len(cracks):
        x, y = upright(cracks[0], low, scale)
        what = f"{len(cracks)} stone{'s' * (len(cracks) > 1)} with void inside, as of a joint that is missing in part"
        remarks.append(f"WARNING: {what}, the first at {as_place(x, y)} m: paint the joint, or use a finer picture")
    return Drawing(turned, remarks=tuple(remarks)), stones


def upright(points: npt.ArrayLike, low: npt.ArrayLike, scale: float) -> FloatArray:
    """Return points (..., 2) in pixels, rows downwards, in m, y upwards; `low` (2,) becomes (0, 0)."""
    return (np.asarray(points, float) - np.asarray(low, float)) * scale * [1.0, -1.0]


def lower_left(number: IntArray) -> IntArray:
    """Return the corner (x, y) of the stones in pixels."""
    return np.array([np.flatnonzero(number.any(axis=0))[0], np.flatnonzero(number.any(axis=1))[-1] + 1])


def grown(number: IntArray, mortar: float) -> IntArray:
    """Return the stones' numbers (rows, columns) with joints up to `mortar` pixels wide shared out between them."""
    from skimage.segmentation import expand_labels

    width = int(np.ceil(mortar))
    if width == 0:
        return number
    inner = slice(width + 1, -(width + 1))
    padded = np.pad(number > 0, width + 1).astype(np.uint8)
    closed = ndimage.grey_closing(padded, size=(width + 1, width + 1))[inner, inner] > 0
    return np.where(closed, expand_labels(number, 2 * width), 0)


def _stones_by_lightness(pixels: Pixels, settings: PictureSettings, kind: str) -> tuple[IntArray, int, list[str]]:
    """Return each pixel's stone, patches of the colour `kind` (black or white), how many are dirt, and remarks."""
    dark, light = int(pixels.lightness.min()), int(pixels.lightness.max())
    if dark < light and not dark < settings.threshold <= light:
        problem = f"{settings.threshold} parts nothing: the picture's lightness is {dark} to {light}"
        raise CaseError("--threshold", problem, f"give one from {dark + 1} to {light}, or --stones colours")
    is_stone = _is_stone(pixels, settings.threshold, kind)
    number, dirt = large_patches(is_stone, settings.smallest_patch)
    if not number.any():
        raise CaseError("", f"no {kind} stones found", "see --scale, --smallest and --stones black|white|colours")
    stones, remarks = int(number.max()), []
    if settings.split:
        number, more = split(number, settings.split, settings.smallest_patch)
        remarks.append(f"{counted(more, 'stone')} more by parting patches with --split {settings.split}")
    return (
        number,
        dirt,
        [
            *remarks,
            *_said_other_colour(~is_stone, settings, kind, stones),
            *_said_together(number, settings),
            *_said_threshold(pixels, settings, kind, stones),
        ],
    )


def _said_other_colour(rest: BoolArray, settings: PictureSettings, kind: str, stones: int) -> list[str]:
    """Return a warning if the stones seem to have the other colour: mortar hangs together, stones do not."""
    others = int(large_patches(rest, settings.smallest_patch)[0].max())
    other = "white" if kind == "black" else "black"
    if others <= 3 * stones:
        return []
    patches = f"{stones} {kind} {'patch' if stones == 1 else 'patches'}"
    return [f"WARNING: {patches}, {others} {other} ones: if those are the stones, give --stones {other}"]


def _is_stone(pixels: Pixels, threshold: int, kind: str) -> BoolArray:
    """Return which pixels are of the stones' colour."""
    return (pixels.lightness >= threshold) == (kind == "white")


def _said_together(number: IntArray, settings: PictureSettings) -> list[str]:
    """Return a warning of patches that look like several stones."""
    area = np.bincount(number.ravel())[1:]
    times = float(area.max() / np.median(area))
    said = [f"WARNING: the largest patch is {times:.0f} times the median one: are joints missing?"] * int(times > HUGE)
    joined = run_together(number, settings.smallest_patch)
    if joined is None:
        return said
    x, y = upright(joined.largest, lower_left(number), settings.scale)
    patches, again = (
        ("1 patch looks", "") if joined.patches == 1 else (f"{joined.patches} patches look", "the largest ")
    )
    missing = f"joints are missing over up to {2 * joined.reach} pixels there"
    remedy = f"use a finer picture, or --split {joined.reach}"
    if settings.split >= joined.reach:
        remedy = "paint them"
    return [
        f"WARNING: {patches} like several stones run together ({joined.stones} stones, {again}at "
        f"{as_place(x, y)} m): "
        f"{missing}; {remedy}",
        *said,
    ]


def _said_threshold(pixels: Pixels, settings: PictureSettings, kind: str, stones: int) -> list[str]:
    """Return a warning if another threshold would part more stones, as thin grey joints need it."""
    greys = np.bincount(pixels.lightness.ravel(), minlength=256)[NEAR_GREY : 256 - NEAR_GREY].sum()
    if greys < GREYS * pixels.lightness.size:
        return []
    count = {
        threshold: int(large_patches(_is_stone(pixels, threshold, kind), settings.smallest_patch)[0].max())
        for threshold in THRESHOLDS
    }
    best = max(count, key=lambda threshold: (count[threshold], -abs(threshold - settings.threshold)))
    if count[best] <= stones:
        return []
    found = f"{counted(stones, 'stone')} at threshold {settings.threshold}"
    return [f"WARNING: {found}, but {count[best]} with --threshold {best}"]

"""Which pixels are which stone: patches of stone colour, those that several stones form, and how these come apart.

Stones run together where a joint is thinner than the pixels tell: a bridge of a few pixels is left between them. What
is deeper in a patch than the bridge is wide falls into one seed a stone; the rest of the patch goes to the seed that
floods it first, from the deepest pixels to the shallowest (watershed, Meyer 1994), which parts stones at the bridge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray

REACHES = (1, 2, 4, 8)
"""pixels of erosion by which stones that run together are looked for: half the width of the bridge between them"""
WIDER = 2
"""times the reach: how deep a seed is, at least. What a bridge joins is wider than the bridge"""
SMALLEST_SEED = 0.05
"""of the median patch: smaller seeds are bulges of a stone"""

CRACK = 5
"""pixels of void inside a stone that are no dirt"""


@dataclass(frozen=True, eq=False, slots=True)
class RunTogether:
    """Patches that look like several stones: how many, how many stones `reach` pixels of erosion make of them, and the
    centre (2,) of the largest in pixels (column, row)."""

    patches: int
    stones: int
    reach: int
    largest: FloatArray


def large_patches(is_stone: BoolArray, smallest: float) -> tuple[IntArray, int]:
    """Return the number of each pixel's patch, from 1 on and 0 for none, and how many patches are left out because
    they have fewer than `smallest` pixels. Patches touch by edges, not by corners."""
    from skimage.measure import label

    return large(label(is_stone, connectivity=1), smallest)


def large(patch: IntArray, smallest: float) -> tuple[IntArray, int]:
    """Return patches (rows, columns) numbered anew without those of fewer than `smallest` pixels, and their count."""
    area = np.bincount(patch.ravel())
    keep = area >= smallest
    keep[0] = False
    number: IntArray = np.where(keep, np.cumsum(keep), 0).astype(np.int32)
    dirt = int(np.count_nonzero(area[1:])) - int(np.count_nonzero(keep))
    return number[patch], dirt


def run_together(number: IntArray, smallest: float) -> RunTogether | None:
    """Return what is to be said of patches that look like several stones; none if every one looks like one."""
    depth = _depth(number)
    owners = {reach: _parted(_seeds(number, depth, reach, smallest)[1]) for reach in REACHES}
    reach = max(REACHES, key=lambda each: len(owners[each]))
    if not len(owners[reach]):
        return None
    patches = np.unique(owners[reach])
    largest = patches[np.argmax(np.bincount(number.ravel())[patches])]
    rows, columns = ndimage.find_objects((number == largest).astype(np.int8))[0]
    centre = np.array([0.5 * (columns.start + columns.stop), 0.5 * (rows.start + rows.stop)])
    return RunTogether(len(patches), len(owners[reach]), reach, centre)


def _parted(owner: IntArray) -> IntArray:
    """Return the patches of those seeds that share their patch with another."""
    return owner[np.bincount(owner)[owner] > 1]


def split(number: IntArray, reach: int, smallest: float) -> tuple[IntArray, int]:
    """Return the patches with those parted that erosion by up to `reach` pixels parts, and how many stones that adds.

    Narrow bridges are cut first: what a wide erosion would swallow has its own number by then.
    """
    stones = int(number.max())
    for pixels in [*(pixels for pixels in REACHES if pixels < reach), reach]:
        number = _parted_by(number, pixels, smallest)
    return number, int(number.max()) - stones


def _parted_by(number: IntArray, reach: int, smallest: float) -> IntArray:
    """Return the patches with those parted that erosion by `reach` pixels parts."""
    from skimage.segmentation import watershed

    depth = _depth(number)
    seed, owner = _seeds(number, depth, reach, smallest)
    count = np.bincount(owner, minlength=int(number.max()) + 1)
    parted = count > 1
    if not parted.any():
        return number
    anew = np.concatenate([[0], np.where(parted[owner], number.max() + np.arange(1, len(owner) + 1), 0)])
    marker = anew[seed]
    inside = parted[number]
    band = inside & ((marker == 0) | ndimage.binary_dilation(inside & (marker == 0)))
    flooded = watershed(-depth, np.where(band, marker, 0), mask=band)
    apart = np.where(inside, np.where(band, flooded, marker), number)
    present = np.bincount(apart.ravel()) > 0
    present[0] = False
    parted_number: IntArray = np.where(present, np.cumsum(present), 0).astype(np.int32)
    return parted_number[apart]


def cracked(number: IntArray, closed: IntArray, width: int) -> FloatArray:
    """Return a place (n, 2) in pixels (column, row) in each stone that has void inside it, from the top.

    number, closed: stones before and after joints up to `width` pixels were closed. The void of joints lies at the
    edges of stones; what lies deeper is left of a joint that is missing elsewhere, and that stone may be two.
    """
    row, column = np.nonzero((number == 0) & (closed > 0) & (_depth(closed) > width + 1))
    _, first, count = np.unique(closed[row, column], return_index=True, return_counts=True)
    first = np.sort(first[count >= CRACK])
    return np.column_stack([column[first], row[first]]) + 0.5


def _depth(number: IntArray) -> IntArray:
    """Return how many pixels (by a king's steps) each pixel lies inside its patch, one less beside another patch."""
    inside = number > 0
    inside[:, :-1] &= (number[:, 1:] == 0) | (number[:, :-1] == number[:, 1:])
    inside[:-1] &= (number[1:] == 0) | (number[:-1] == number[1:])
    depth: IntArray = ndimage.distance_transform_cdt(np.pad(inside, 1), "chessboard")[1:-1, 1:-1]
    return depth


def _seeds(number: IntArray, depth: IntArray, reach: int, smallest: float) -> tuple[IntArray, IntArray]:
    """Return the numbers of the seeds (rows, columns) that erosion leaves, and the patch (seeds,) of each."""
    patch = np.bincount(number.ravel())[1:]
    seed, _ = large_patches(depth > reach, max(smallest, SMALLEST_SEED * float(np.median(patch))))
    inner = np.bincount(seed[depth >= WIDER * reach], minlength=int(seed.max()) + 1) > 0
    inner[0] = False
    anew: IntArray = np.where(inner, np.cumsum(inner), 0).astype(np.int32)
    seed = anew[seed]
    owner = np.zeros(np.count_nonzero(inner) + 1, np.int64)
    owner[seed.ravel()] = number.ravel()
    return seed, owner[1:]

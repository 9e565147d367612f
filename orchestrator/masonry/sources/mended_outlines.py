"""Outlines that cross or touch themselves by a slip of the hand: corners clicked twice, corners that were forgotten."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.printed import as_place, millimetres
from orchestrator.geometry.ring_geometry import Spike, clicked_once, without_spikes

TOLD = 1e-3
"""part of an outline's longest side from which a spike is told: a shorter one is the rounding of a program"""


def mended(outlines: Sequence[FloatArray], within: float) -> tuple[list[FloatArray], list[str]]:
    """Return outlines (n, 2), those that cross or touch themselves without second clicks and spikes within a distance
    (m), where that is enough, and remarks. Other outlines are as they were: short edges are healed with the wall."""
    found, said, apart, first = list(outlines), list[str](), 0.0, ""
    several = 0
    for number, ring in enumerate(outlines):
        if len(ring) < 3 or shapely.Polygon(ring).is_valid:
            continue
        once = clicked_once(ring, within)
        other, spikes = without_spikes(once, within)
        if not shapely.Polygon(other).is_valid:
            continue
        found[number] = other
        said += said_of_spikes("an outline", ring, spikes)
        if len(once) < len(ring):
            near = np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1)
            gone = np.flatnonzero(near <= within)
            x, y = ring[gone[0]]
            several, first = several + 1, first or f"{as_place(x, y)} m"
            apart = max(apart, float(near[gone].max()))
    if several:
        many = f"{several} outlines have corners" if several > 1 else "1 outline has corners"
        said.append(f"{many} drawn twice, up to {millimetres(apart)} apart, taken for one; the first at {first}")
    return found, said


def said_of_spikes(what: str, ring: FloatArray, spikes: Sequence[Spike]) -> list[str]:
    """Return a warning of the longest of the spikes that were taken from an outline (n, 2), unless all are rounding;
    what: as in "the outline of block 22"."""
    longest = max(spikes, key=lambda spike: spike.length, default=None)
    side = float(np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1).max())
    if longest is None or longest.length < TOLD * side:
        return []
    x, y = longest.tip
    return [
        f"WARNING: {what} goes out to {as_place(x, y)} m and back on itself, {millimetres(longest.length)} far: that "
        "spike is taken away; was a corner forgotten?"
    ]

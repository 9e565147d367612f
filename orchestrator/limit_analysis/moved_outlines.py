"""Do blocks go into each other in a mechanism? Checked from outlines and velocities alone: joints are not asked.

Limit analysis knows the contacts that are joints, edges that two blocks share. Blocks that meet in a point only, or
beyond the end of their joint, have none there, and nothing in its programs holds them apart. Here the outlines are
displaced by the mechanism, so little that what joints allow overlaps by a second-order length alone: with a for the
largest displacement and h for the size of a block, a^2 / h.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np
import shapely

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.printed import as_place
from orchestrator.geometry.penetration import penetrations
from orchestrator.geometry.rigid import velocity_of_points
from orchestrator.limit_analysis.paper.limit_state import LimitState
from orchestrator.limit_analysis.validation import LIMITS
from orchestrator.masonry.block_properties import block_centroids
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.wall import Wall, shapes

AMPLITUDE = 1e-3
"""Largest displacement of any corner, over the size of the smallest block (the root of its area)."""
SECOND_ORDER = 10.0
"""Times a^2 / h from which an overlap is more than of second order: at this amplitude a hundredth of the largest
displacement. A block that turns by 2 a / h while it slides by 2 a has 4 of them."""


def blocks_in_each_other(assemblage: Assemblage, state: LimitState, without: Collection[int] = ()) -> tuple[str, ...]:
    """Return a remark on blocks that go into each other in the mechanism of a state, none where none do.

    without: ids of stones that are not there any more. Joints that close in the mechanism (they crush, or stand open)
    are known to: what their two blocks do is no finding.
    """
    wall = assemblage.wall
    stay = np.array([block.id not in without for block in wall.blocks])
    free = np.array([not block.fixed for block in wall.blocks])
    size = np.sqrt(shapely.area(shapes(wall)))
    amplitude = AMPLITUDE * float(size.min())
    velocities = state.mechanism.velocities / state.mechanism.largest_displacement
    moved = shapes(_displaced(wall, amplitude * velocities))
    found = penetrations(moved[stay], free[stay], float(np.abs(shapely.total_bounds(moved)).max()))
    pair = np.flatnonzero(stay)[found.pair]
    beyond = found.depth > SECOND_ORDER * amplitude**2 / size[pair].min(axis=1)
    known = _closing(assemblage, state)
    beyond &= np.array([frozenset(sides) not in known for sides in pair.tolist()], bool)
    if not beyond.any():
        return ()
    worst = int(np.where(beyond, found.depth, -1.0).argmax())
    one, other = (wall.blocks[block].id for block in pair[worst])
    x, y = found.place[worst]
    more = int(np.count_nonzero(beyond)) - 1
    alike = f" (one of {more + 1} such pairs)" if more else ""
    return (
        f"in the mechanism blocks {one} and {other} go into each other at {as_place(x, y)} m{alike}: no joint keeps "
        "them apart there, and the multiplier may be too low",
    )


def _displaced(wall: Wall, displacements: FloatArray) -> Wall:
    """Return the wall with blocks displaced by (n, 3) in m and rad, to first order."""
    arms = zip(wall.blocks, block_centroids(wall), displacements, strict=True)
    blocks = (
        replace(block, polygon=read_only(block.polygon + velocity_of_points(displacement, block.polygon - centroid)))
        for block, centroid, displacement in arms
    )
    return replace(wall, blocks=tuple(blocks))


def _closing(assemblage: Assemblage, state: LimitState) -> set[frozenset[int]]:
    """Return the pairs of blocks of which a joint closes in the mechanism."""
    least = -LIMITS["interpenetration"] * state.mechanism.largest_displacement
    closing = (state.mechanism.opening < least).any(axis=1)
    return {frozenset(sides) for sides, closes in zip(assemblage.joints.pairs, closing, strict=True) if closes}

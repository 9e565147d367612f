"""Control point of N2: tops of blocks whose mean displacement along the load is the curve's abscissa.

It is named (`control_blocks`, `control_level`), or it is the roof or floor that moves most in the mechanism of micro
limit analysis: of a tower beside a squat wall the tower's top, of a surveyed wall more than the one highest stone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orchestrator.assessment.seismic.settings import SeismicSettings
from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.basis.errors import CaseError
from orchestrator.geometry.rigid import velocity_of_points
from orchestrator.limit_analysis import Mechanism
from orchestrator.loads import LoadSettings
from orchestrator.loads.block_loads import horizontal
from orchestrator.loads.dead_loads import AT_LEVEL, extra_dead_loads, top_of
from orchestrator.masonry.block_properties import block_centroids
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.wall import Wall

COVERED = 0.5
"""part of a block's top that other blocks cover where it is no roof"""


@dataclass(frozen=True, slots=True)
class ControlPoint:
    """Blocks (positions in the wall) whose tops are the control point, and what it is called."""

    name: str
    blocks: tuple[int, ...]


def control_point(
    settings: SeismicSettings, assemblage: Assemblage, load: LoadSettings, mechanism: Mechanism
) -> ControlPoint:
    """Return the control point asked for, else the roof or floor that moves most along the load. Raises CaseError."""
    named = named_point(settings, assemblage.wall)
    if named is not None:
        return named
    velocity = velocity_of_tops(assemblage.wall, mechanism) @ horizontal(load.vector)
    return max(candidates(assemblage, load), key=lambda point: float(velocity[list(point.blocks)].mean()))


def named_point(settings: SeismicSettings, wall: Wall) -> ControlPoint | None:
    """Return the control point that the settings name, None for none. Raises CaseError (key only)."""
    if settings.control_blocks and settings.control_level is not None:
        raise CaseError("seismic.control_level", "is given beside control_blocks", "give one of the two")
    free = {block.id: position for position, block in enumerate(wall.blocks) if not block.fixed}
    for wanted in settings.control_blocks:
        if wanted not in free:
            remedy = "name blocks of the wall that can move"
            raise CaseError("seismic.control_blocks", f"there is no block {wanted} that can move", remedy)
    if settings.control_blocks:
        names = ", ".join(map(str, settings.control_blocks))
        return ControlPoint(f"top of block {names}", tuple(free[wanted] for wanted in settings.control_blocks))
    if settings.control_level is None:
        return None
    tops = _tops(wall)
    at_level = tuple(k for k in free.values() if abs(tops[k] - settings.control_level) < AT_LEVEL)
    if not at_level:
        listed = ", ".join(f"{top:g}" for top in sorted({round(float(tops[k]), 3) for k in free.values()})[:20])
        problem = f"no block has its top at {settings.control_level:g} m"
        raise CaseError("seismic.control_level", problem, f"tops are at {listed} m")
    return _named("level", tops, at_level)


def candidates(assemblage: Assemblage, load: LoadSettings) -> list[ControlPoint]:
    """Return floors (extra dead loads) and roofs (tops that no block covers, those of one height together)."""
    wall, tops = assemblage.wall, _tops(assemblage.wall)
    points = []
    for extra in load.dead:
        carrying = np.unique(extra_dead_loads(wall, (extra,)).block)
        points += [_named("floor", tops, level) for level in _levels(tops, carrying)]
    return points + [_named("roof", tops, level) for level in _levels(tops, uncovered(assemblage))]


def uncovered(assemblage: Assemblage) -> IntArray:
    """Return the positions of the free blocks of whose tops others cover no more than COVERED, all where none is."""
    wall = assemblage.wall
    centroids = block_centroids(wall)
    covered = np.zeros(len(wall.blocks))
    run = np.abs(assemblage.joints.end - assemblage.joints.start)
    for joint in np.flatnonzero(run[:, 0] > run[:, 1]):
        pair = (int(assemblage.joints.i[joint]), int(assemblage.joints.j[joint]))
        lower = min(pair, key=lambda k: float(centroids[k, 1]))
        covered[lower] += run[joint, 0]
    free = [position for position, block in enumerate(wall.blocks) if not block.fixed]
    bare = [k for k in free if covered[k] <= COVERED * top_of(wall.blocks[k].polygon)[0]]
    return np.array(bare or free, dtype=np.int64)


def velocity_of_tops(wall: Wall, mechanism: Mechanism) -> FloatArray:
    """Return the velocity (n, 2) of the middle of every block's top, in the mechanism's scale."""
    middle = np.array([top_of(block.polygon)[1] for block in wall.blocks])
    return velocity_of_points(mechanism.velocities, middle - block_centroids(wall))


def _tops(wall: Wall) -> FloatArray:
    return np.array([block.polygon[:, 1].max() for block in wall.blocks])


def _levels(tops: FloatArray, blocks: IntArray) -> list[tuple[int, ...]]:
    """Return blocks grouped by the height of their tops, to AT_LEVEL."""
    ordered = blocks[np.argsort(tops[blocks], kind="stable")]
    breaks = np.flatnonzero(np.diff(tops[ordered]) > AT_LEVEL) + 1
    return [tuple(sorted(group.tolist())) for group in np.split(ordered, breaks) if len(group)]


def _named(kind: str, tops: FloatArray, blocks: Sequence[int]) -> ControlPoint:
    height = float(tops[list(blocks)].max())
    many = f"{len(blocks)} block{'s' * (len(blocks) > 1)}"
    return ControlPoint(f"{kind} at y = {height:.4g} m, {many}", tuple(blocks))

"""Control point of N2: tops of blocks whose mean displacement along the load is the curve's abscissa.

It is named (`control_blocks`, `control_level`), or it is the roof or floor that moves most in the mechanism of micro
limit analysis: of a tower beside a squat wall the tower's top, of a surveyed wall more than the one highest stone.
Stones that fall while the wall goes on are no part of it, from the first row of the curve on: their last place is no
displacement of the wall. Nor is one found among stones that limit analysis lists as local failures.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from orchestrator.assessment.seismic.settings import SeismicSettings
from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.basis.errors import CaseError, ResultError
from orchestrator.geometry.rigid import velocity_of_points
from orchestrator.limit_analysis import LimitAnalysis, LimitState, Mechanism
from orchestrator.loads import LoadSettings
from orchestrator.loads.block_loads import horizontal
from orchestrator.loads.dead_loads import AT_LEVEL, extra_dead_loads, top_of
from orchestrator.masonry.block_properties import block_centroids
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.wall import Wall, shapes

NONE = frozenset[int]()
"""no blocks"""
BLOCKS, LEVEL = "seismic.control_blocks", "seismic.control_level"
"""keys that name a control point"""
COVERED = 0.51
"""part of a block's top, more than half of it, that other blocks cover where it is no roof"""


@dataclass(frozen=True, slots=True)
class ControlPoint:
    """Blocks (positions in the wall) whose tops are the control point, what it is called, and the key that names it,
    "" for none."""

    name: str
    blocks: tuple[int, ...]
    key: str = ""


def control_point(
    settings: SeismicSettings,
    assemblage: Assemblage,
    load: LoadSettings,
    analysis: LimitAnalysis,
    fallen: frozenset[int] = NONE,
) -> ControlPoint:
    """Return the control point asked for, else the roof or floor that moves most along the load; fallen: positions of
    the blocks that have fallen by the end of the curve.

    Raises CaseError (key only), ResultError where nothing of the point stands.
    """
    named = named_point(settings, assemblage.wall)
    if named is not None:
        return standing(named, assemblage.wall, fallen)
    loose = {stone for failure in analysis.local_failures for stone in failure.stones}
    gone = fallen | {position for position, block in enumerate(assemblage.wall.blocks) if block.id in loose}
    velocity = velocity_of_tops(assemblage.wall, state_of_what_stands(analysis).mechanism) @ horizontal(load.vector)
    points = candidates(assemblage, load, gone)
    return max(points, key=lambda point: float(velocity[list(point.blocks)].mean()))


def state_of_what_stands(analysis: LimitAnalysis) -> LimitState:
    """Return the lowest state of the wall without the stones that come loose before it fails, the associative one where
    no other is known."""
    whole = None if analysis.local_failures else analysis.sequence  # the paper's is a state of the wall with them
    others = [state for state in (analysis.lowest, whole) if state is not None and state.converged]
    return min([*filter(None, [analysis.path]), *others], key=lambda s: s.load_multiplier, default=analysis.bound)


def standing(point: ControlPoint, wall: Wall, fallen: frozenset[int]) -> ControlPoint:
    """Return a named control point without the blocks that have `fallen`. Raises ResultError where none is left."""
    left = tuple(block for block in point.blocks if block not in fallen)
    if left == point.blocks:
        return point
    if not left:
        raise ResultError("control point", f"{point.name} has fallen: name stones that stand in {point.key}")
    return _tops_of(wall, left) if point.key == BLOCKS else _named("level", _tops(wall), left, LEVEL)


def named_point(settings: SeismicSettings, wall: Wall) -> ControlPoint | None:
    """Return the control point that the settings name, None for none. Raises CaseError (key only)."""
    if settings.control_blocks and settings.control_level is not None:
        raise CaseError(LEVEL, "is given beside control_blocks", "give one of the two")
    free = {block.id: position for position, block in enumerate(wall.blocks) if not block.fixed}
    for wanted in settings.control_blocks:
        if wanted not in free:
            remedy = "name blocks of the wall that can move"
            raise CaseError(BLOCKS, f"there is no block {wanted} that can move", remedy)
        if settings.control_blocks.count(wanted) > 1:
            raise CaseError(BLOCKS, f"names block {wanted} more than once", "name every block once")
    if settings.control_blocks:
        return _tops_of(wall, tuple(free[wanted] for wanted in settings.control_blocks))
    if settings.control_level is None:
        return None
    tops = _tops(wall)
    near = AT_LEVEL * _heights(wall)
    at_level = tuple(k for k in free.values() if abs(tops[k] - settings.control_level) < near[k])
    if not at_level:
        listed = ", ".join(f"{top:g}" for top in sorted({round(float(tops[k]), 3) for k in free.values()})[:20])
        problem = f"no block has its top at {settings.control_level:g} m"
        raise CaseError(LEVEL, problem, f"tops are at {listed} m")
    return _named("level", tops, at_level, LEVEL)


def candidates(assemblage: Assemblage, load: LoadSettings, gone: frozenset[int] = NONE) -> list[ControlPoint]:
    """Return floors (extra dead loads) and roofs (tops that no block covers or stands above, those of one height
    together) of the blocks that are not `gone` (positions)."""
    wall, tops = assemblage.wall, _tops(assemblage.wall)
    points = []
    for extra in load.dead:
        carrying = np.setdiff1d(extra_dead_loads(wall, (extra,)).block, list(gone))
        points += [_named("floor", tops, level) for level in _levels(wall, carrying)]
    return points + [_named("roof", tops, level) for level in _levels(wall, uncovered(assemblage, gone))]


def uncovered(assemblage: Assemblage, gone: frozenset[int] = NONE) -> IntArray:
    """Return the positions of the free blocks of whose tops others cover no more than COVERED, with none above them as
    above a sill, all where none is; those that are `gone` are no roof and cover none."""
    wall = assemblage.wall
    centroids = block_centroids(wall)
    covered = np.zeros(len(wall.blocks))
    run = np.abs(assemblage.joints.end - assemblage.joints.start)
    for joint in np.flatnonzero(run[:, 0] > run[:, 1]):
        pair = (int(assemblage.joints.i[joint]), int(assemblage.joints.j[joint]))
        lower, upper = sorted(pair, key=lambda k: float(centroids[k, 1]))
        covered[lower] += run[joint, 0] * (upper not in gone)
    free = [position for position, block in enumerate(wall.blocks) if not block.fixed and position not in gone]
    bare = [k for k in free if covered[k] <= COVERED * top_of(wall.blocks[k].polygon)[0]]
    middle = np.array([top_of(wall.blocks[k].polygon)[1] for k in bare]).reshape(-1, 2)
    sky = np.column_stack([middle[:, 0], np.full(len(bare), max(block.polygon[:, 1].max() for block in wall.blocks))])
    lines = shapely.linestrings(np.stack([middle, sky], axis=1))
    line, above = shapely.STRtree(shapes(wall)).query(lines, predicate="intersects")
    begins = np.array([block.polygon[:, 1].min() for block in wall.blocks])
    near = AT_LEVEL * _heights(wall)[bare]
    is_over = begins[above] > (middle[:, 1] + near)[line]  # and does not lie on a part of it
    hidden = {bare[k] for k, other in zip(line[is_over], above[is_over], strict=True) if other not in gone}
    return np.array([k for k in bare if k not in hidden] or free, dtype=np.int64)


def velocity_of_tops(wall: Wall, mechanism: Mechanism) -> FloatArray:
    """Return the velocity (n, 2) of the middle of every block's top, in the mechanism's scale."""
    middle = np.array([top_of(block.polygon)[1] for block in wall.blocks])
    return velocity_of_points(mechanism.velocities, middle - block_centroids(wall))


def _tops(wall: Wall) -> FloatArray:
    return np.array([block.polygon[:, 1].max() for block in wall.blocks])


def _heights(wall: Wall) -> FloatArray:
    return np.array([np.ptp(block.polygon[:, 1]) for block in wall.blocks])


def _levels(wall: Wall, blocks: IntArray) -> list[tuple[int, ...]]:
    """Return blocks grouped by the height of their tops: those that lie above the lowest of a group by no more than
    AT_LEVEL of their height."""
    tops, near = _tops(wall), AT_LEVEL * _heights(wall)
    levels: list[list[int]] = []
    for k in blocks[np.argsort(tops[blocks], kind="stable")].tolist():
        if levels and tops[k] - tops[levels[-1][0]] <= near[k]:
            levels[-1].append(k)
        else:
            levels.append([k])
    return [tuple(sorted(group)) for group in levels]


def _tops_of(wall: Wall, blocks: tuple[int, ...]) -> ControlPoint:
    names = ", ".join(str(wall.blocks[block].id) for block in blocks)
    return ControlPoint(f"top of block {names}", blocks, BLOCKS)


def _named(kind: str, tops: FloatArray, blocks: Sequence[int], key: str = "") -> ControlPoint:
    height = float(tops[list(blocks)].max())
    many = f"{len(blocks)} block{'s' * (len(blocks) > 1)}"
    return ControlPoint(f"{kind} at y = {height:.4g} m, {many}", tuple(blocks), key)

"""Drift of piers: how far their tops move against their feet, over their height, and how far the codes let them.

    drift        |u_top - u_foot| / h since gravity, u the mean over the tops of the blocks under a section; a wall
                 without openings is one pier from its base to the control point
    EN 1998-3    flexure 0.008 H_0/D at SD, shear 0.004; at NC 4/3 of both (C.4.2.1, C.4.3.1)
    NTC 2018     0.002 at SLD (7.3.6.1); at SLC flexure 0.010, shear 0.005 (7.8.2.2), at SLV 3/4 of both (C7.8.1.5.4)

D is the width of the pier, H_0 the distance from its foot to where its moment is zero: h/2 between openings, h where
it ends in the control point. Flexure governs where a rocking pier is weaker than a sliding one: D/(2 a) < friction,
with the moment of its foot over the shear a: h/2 between openings, the height at which the live load acts on a whole
wall.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.assessment.panels import DRAWN_OPEN, Panel, cut, piers
from orchestrator.assessment.seismic.settings import LimitStateName, SeismicSettings
from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.loads import DeadLoad, Loads, LoadSettings
from orchestrator.loads.dead_loads import top_of
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.masonry.block_properties import block_centroids
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.wall import Wall
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.pushover.solids.nodal_loads import nodal_loads

FLEXURE = {"SLV": 0.75 * 0.010, "SLC": 0.010, "SD": 0.008, "NC": 4 / 3 * 0.008}
"""of a pier that rocks; SD and NC times H_0/D"""
SHEAR = {"SLV": 0.75 * 0.005, "SLC": 0.005, "SD": 0.004, "NC": 4 / 3 * 0.004}
"""of a pier that fails in shear"""
SERVICE = {"SLD": 0.002}
"""of any pier, at damage limitation"""
CLAUSES = {
    "SLD": "NTC 2018 7.3.6.1", "SLV": "NTC 2018 7.8.2.2, Circ. 7/2019 C7.8.1.5.4 (3/4)", "SLC": "NTC 2018 7.8.2.2",
    "SD": "EN 1998-3 C.4.2.1, C.4.3.1", "NC": "EN 1998-3 C.4.2.1, C.4.3.1 (4/3)",
}  # fmt: skip
"""where these limits are from"""
GIVEN = "as given (largest_drift)"


@dataclass(frozen=True, slots=True)
class DriftingPier:
    """A pier: name, positions of the blocks under its foot and of those under its top, height, width D, H_0 and the
    moment of its foot over the shear in m, and the coefficient of friction of its foot."""

    name: str
    foot: tuple[int, ...]
    top: tuple[int, ...]
    height: float
    width: float
    moment_height: float
    moment_over_shear: float
    friction: float


@dataclass(frozen=True, eq=False, slots=True)
class Drifts:
    """The piers (p) of a wall, and their drifts (s, p) row by row of a curve."""

    piers: tuple[DriftingPier, ...]
    drift: FloatArray


def drifting_piers(
    assemblage: Assemblage, control_blocks: tuple[int, ...], loads: Loads, fallen: frozenset[int] = frozenset()
) -> tuple[DriftingPier, ...]:
    """Return the piers of a wall, or the whole wall up to the tops of `control_blocks` where it has no openings.

    Blocks that have `fallen` (positions) by the end of the curve are under no section: a pier is between those that
    stand, and is left out where none does. The foot of a pier that is one stone is where that stone stands.
    """
    wall = assemblage.wall
    drifting = []
    for panel in piers(wall):
        foot, top = cut(assemblage, panel, panel.bottom), cut(assemblage, panel, panel.top)
        over = top.lower
        if set(over) == set(foot.lower):  # no joint between the two
            over = _crossed(wall, panel)
            stands = min((float(wall.blocks[block].polygon[:, 1].min()) for block in over), default=panel.bottom)
            foot = cut(assemblage, panel, stands)
        under, head = (np.setdiff1d(blocks, list(fallen)) for blocks in (foot.lower, over))
        if not len(under) or not len(head):
            continue
        height = _level(wall, head) - _level(wall, under)
        friction, half = float(assemblage.joints.friction[foot.joints].min()), 0.5 * height
        drifting.append(DriftingPier(panel.name, tuple(under), tuple(head), height, panel.depth, half, half, friction))
    if drifting:
        return tuple(drifting)
    base = min(float(block.polygon[:, 1].min()) for block in wall.blocks if not block.fixed)
    ground = np.array([block.fixed for block in wall.blocks])
    standing = np.flatnonzero(ground[assemblage.joints.i] | ground[assemblage.joints.j])
    ends = np.concatenate([assemblage.joints.start[standing, 0], assemblage.joints.end[standing, 0]])
    height, width = _level(wall, control_blocks) - base, float(np.ptp(ends))
    friction, acts_at = float(assemblage.joints.friction[standing].min()), _height_of_load(wall, loads, base)
    return (DriftingPier("whole wall", (), control_blocks, height, width, height, acts_at, friction),)


def _crossed(wall: Wall, panel: Panel) -> IntArray:
    """Return the free blocks (positions) that the line through the middle of a pier crosses."""
    boxes = np.array([[block.polygon.min(axis=0), block.polygon.max(axis=0)] for block in wall.blocks])
    low, high, middle = boxes[:, 0], boxes[:, 1], 0.5 * (panel.bottom + panel.top)
    beside = (np.minimum(high[:, 0], panel.right) - np.maximum(low[:, 0], panel.left)) > DRAWN_OPEN * panel.depth
    free = np.array([not block.fixed for block in wall.blocks])
    return np.flatnonzero(free & beside & (low[:, 1] < middle) & (middle < high[:, 1]))


def _height_of_load(wall: Wall, loads: Loads, base: float) -> float:
    """Return the height over `base` (m) at which the horizontal live load acts, m."""
    moment = loads.live[:, 0] * (block_centroids(wall)[:, 1] - base) - loads.live[:, 2]
    free = np.array([not block.fixed for block in wall.blocks])
    return float(moment[free].sum() / loads.live[free, 0].sum())


def _level(wall: Wall, blocks: tuple[int, ...] | np.ndarray) -> float:
    """Return the mean height of the tops of blocks, m."""
    return float(np.mean([top_of(wall.blocks[int(block)].polygon)[1][1] for block in blocks]))


def drift_weights(wall: Wall, bodies: Bodies, meshes: BodyMeshes, drifting: tuple[DriftingPier, ...]) -> FloatArray:
    """Return weights (p, m) of the nodes' horizontal displacements whose sum is the drift of each pier, with a sign."""

    unloaded = nodal_loads(wall, bodies, meshes, LoadSettings()).dead

    def mean_of_tops(blocks: tuple[int, ...]) -> FloatArray:
        free = tuple(wall.blocks[block].id for block in blocks if not wall.blocks[block].fixed)
        if not free:
            return np.zeros(len(meshes.nodes))
        loaded = LoadSettings(dead=(DeadLoad(blocks=free, line_load=1.0),))
        weights = nodal_loads(wall, bodies, meshes, loaded).dead - unloaded
        moving = sum(top_of(wall.blocks[block].polygon)[0] for block in blocks if not wall.blocks[block].fixed)
        everything = sum(top_of(wall.blocks[block].polygon)[0] for block in blocks)
        return np.asarray(weights / weights.sum() * (moving / everything))

    return np.array([(mean_of_tops(pier.top) - mean_of_tops(pier.foot)) / pier.height for pier in drifting])


def largest_drift(pier: DriftingPier, state: LimitStateName, settings: SeismicSettings) -> tuple[float, str] | None:
    """Return the drift that a pier may have at a limit state, and in a word why; None where the code names none."""
    if settings.largest_drift is not None:
        return settings.largest_drift, "as given"
    if state in SERVICE:
        return SERVICE[state], "damage limitation"
    if state not in FLEXURE:
        return None
    if pier.width / (2.0 * pier.moment_over_shear) >= pier.friction:
        return SHEAR[state], "shear"
    share = pier.moment_height / pier.width if state in ("SD", "NC") else 1.0
    return FLEXURE[state] * share, "flexure"


def is_limited(state: LimitStateName, settings: SeismicSettings) -> bool:
    """Return whether the drifts of piers are checked at a limit state."""
    return settings.largest_drift is not None or state in SERVICE or state in FLEXURE


@dataclass(frozen=True, slots=True)
class Allowed:
    """Up to where a curve may be followed: displacement m of the control point at which `pier` has its largest drift
    `limit` by `rule`; reached: whether it has it anywhere on the curve."""

    displacement: float
    pier: int
    limit: float
    rule: str
    reached: bool


def allowed_displacement(
    drifts: Drifts, displacement: FloatArray, state: LimitStateName, settings: SeismicSettings
) -> Allowed | None:
    """Return the displacement at which the first pier has its largest drift; displacement (s,) is the control point's.

    Where none has it the end of the curve stands for it, with the pier that comes nearest; None without a limit.
    """
    best: Allowed | None = None
    share = 0.0
    for number, pier in enumerate(drifts.piers):
        limit = largest_drift(pier, state, settings)
        if limit is None:
            return None
        over = drifts.drift[:, number] / limit[0]
        beyond = int(np.argmax(over > 1.0)) if np.any(over > 1.0) else -1
        if beyond < 0:
            if (best is None or not best.reached) and over.max() >= share:
                share, best = float(over.max()), Allowed(float(displacement[-1]), number, *limit, reached=False)
            continue
        part = (1.0 - over[beyond - 1]) / (over[beyond] - over[beyond - 1]) if beyond else 0.0
        before = float(displacement[max(beyond - 1, 0)])
        at = before + float(part) * (float(displacement[beyond]) - before)
        if best is None or not best.reached or at < best.displacement:
            best = Allowed(at, number, *limit, reached=True)
    return best


def drift_at(drifts: Drifts, displacement: FloatArray, pier: int, moved: float) -> float:
    """Return the drift of a pier where the control point has first moved by `moved` m; at the end of a shorter curve,
    that of its end in proportion."""
    last = float(displacement[-1])
    furthest = np.maximum.accumulate(displacement)
    if moved > furthest[-1]:
        return float(drifts.drift[-1, pier]) * moved / last
    first = int(np.argmax(furthest >= moved))
    if first == 0:
        return float(drifts.drift[0, pier])
    low, high = float(furthest[first - 1]), float(displacement[first])
    part = (moved - low) / (high - low)
    return float((1.0 - part) * drifts.drift[first - 1, pier] + part * drifts.drift[first, pier])

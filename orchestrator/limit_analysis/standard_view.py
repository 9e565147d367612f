"""One view of a wall whatever its numbering and the side it is seen from: the same problem must get the same answer.

Non-associative states are many (Drucker 1954), and which one a search ends at depends in places on the last digit of
every number: random wall 25 of docs/studies and its mirror image, which differ by nothing but the order of sums, ended
2e-3 apart. So each wall is analysed in one view only, in which

    the load pushes to the right      x -> -x for a load along -x
    the origin is the lower left corner of the box round the wall, and coordinates are rounded to PICOMETRE
    blocks are sorted by the height of their centroids, then from left to right; outlines begin at the leftmost corner
    joints are sorted by their blocks and midpoints; where an end lies on a corner it is that corner, to the last digit

and the answer is carried back. With n pointing from block i to j and t along the joint (joints.py), a joint whose
blocks change places keeps N and s but interchanges its ends; a mirrored one interchanges its ends too, and turns s.
Where blocks are drawn with gaps, renumbering still moves the joints by as much: they lie on the outline of block i.
The choice is one of order, not of mechanics: which of several states is the answer stays arbitrary, only not by chance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt
import shapely

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, read_only
from orchestrator.limit_analysis.paper.equilibrium import Equilibrium
from orchestrator.limit_analysis.paper.limit_state import LimitAnalysis, LimitState
from orchestrator.loads.block_loads import Loads, loads_on
from orchestrator.masonry.block_properties import block_centroids, thinner
from orchestrator.masonry.interfaces import STRENGTHS, straight_interfaces
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.wall import Block, Wall

PICOMETRE = 12
"""Digits of coordinates in m: far below any joint, far above the rounding of a wall that was shifted or mirrored."""
SORTED = 7
"""Digits of centroids in m that blocks and joints are sorted by."""
ON_CORNER = 1e-9
"""m; ends of joints nearer to a corner than this are that corner."""


Scalar = TypeVar("Scalar", bound=np.generic)


@dataclass(frozen=True, eq=False, slots=True)
class StandardView:
    """A wall with its joints and loads as analysed, the load towards +x, and the way back.

    block (n,), joint (k,): the original's numbers in the order of the view; interchanged (k,): joints whose start is
    the original's end; mirror: -1 where the view is a mirror image, else 1.
    """

    assemblage: Assemblage
    loads: Loads
    block: IntArray
    joint: IntArray
    interchanged: BoolArray
    mirror: int

    def carried_back(self, answer: LimitAnalysis, equilibrium: Equilibrium) -> LimitAnalysis:
        """Return the answer for the view as the answer for the original, whose equilibrium is checked anew."""
        standing = None if answer.local_failures else equilibrium  # else stones that lie on the ground are not in it
        failures = [replace(failure, state=self._state(failure.state, None)) for failure in answer.local_failures]
        return replace(
            answer,
            associative=self._state(answer.associative, equilibrium),
            sequence=answer.sequence and self._state(answer.sequence, equilibrium),
            path=answer.path and self._state(answer.path, standing),
            lowest=answer.lowest and self._state(answer.lowest, standing),
            drawn=answer.drawn and self._state(answer.drawn, standing),
            associative_left=answer.associative_left and self._state(answer.associative_left, None),
            local_failures=tuple(failures),
        )

    def _state(self, state: LimitState, equilibrium: Equilibrium | None) -> LimitState:
        mechanism = state.mechanism
        velocities, opening = np.empty_like(mechanism.velocities), np.empty_like(mechanism.opening)
        slip, forces = np.empty_like(mechanism.slip), np.empty_like(state.joint_forces)
        velocities[self.block] = mechanism.velocities * [self.mirror, 1.0, self.mirror]
        opening[self.joint] = _ends(mechanism.opening, self.interchanged)
        slip[self.joint] = self.mirror * mechanism.slip
        ends = _ends(state.joint_forces[:, :2], self.interchanged)
        forces[self.joint] = np.column_stack([ends, self.mirror * state.joint_forces[:, 2]])
        moved = replace(mechanism, velocities=read_only(velocities), opening=read_only(opening), slip=read_only(slip))
        stand_open = state.open_ends
        if stand_open is not None:
            seen, stand_open = _ends(stand_open, self.interchanged), np.empty_like(stand_open)
            stand_open[self.joint] = seen
            stand_open = read_only(stand_open, np.bool_)
        residual = (
            state.equilibrium_residual if equilibrium is None else equilibrium.residual(forces, state.load_multiplier)
        )
        return replace(
            state,
            joint_forces=read_only(forces),
            mechanism=moved,
            equilibrium_residual=residual,
            open_ends=stand_open,
        )


def standard_view(assemblage: Assemblage, loads: Loads | None = None) -> StandardView:
    """Return the view of an assemblage under loads, by default its weight and the same forces along +x."""
    wall, loads = assemblage.wall, loads or loads_on(assemblage.wall)
    mirror = -1 if loads.direction[0] < 0 else 1
    seen = np.array([mirror, 1.0])
    corners = np.vstack([block.polygon for block in wall.blocks]) * seen
    origin = corners.min(axis=0)
    outlines = [_outline(block, seen, origin, mirror) for block in wall.blocks]
    moved = Wall(wall.name, tuple(outlines), wall.thickness, wall.friction)
    places = np.round(block_centroids(moved), SORTED)
    block = np.lexsort([places[:, 0], places[:, 1]])
    moved = replace(moved, blocks=tuple(outlines[number] for number in block))
    number = np.argsort(block)
    joints = assemblage.joints
    i, j = number[joints.i], number[joints.j]
    interchanged = (i > j) ^ (mirror < 0)
    ends = [_on_corners(np.round(end * seen - origin, PICOMETRE), moved) for end in (joints.start, joints.end)]
    start, end = (np.where(interchanged[:, None], other, one) for one, other in (ends, ends[::-1]))
    middle = np.round(0.5 * (start + end), SORTED)
    pair = np.minimum(i, j), np.maximum(i, j)
    joint = np.lexsort([middle[:, 1], middle[:, 0], *pair[::-1]])
    joints_seen = replace(
        straight_interfaces(*pair, start, end, thinner(moved, *pair), joints.friction),
        **{name: getattr(joints, name) for name in STRENGTHS},
    )
    seen_so = np.array([mirror, 1.0, mirror])
    loads_seen = replace(  # a mirror image turns the other way, so that the moments of turned blocks are the same
        loads, dead=loads.dead * seen_so, live=loads.live * seen_so, direction=read_only(loads.direction * seen)
    )
    return StandardView(
        assemblage=Assemblage(moved, joints_seen.part(joint)),
        loads=loads_seen.of_blocks(block),
        block=read_only(block, np.int64),
        joint=read_only(joint, np.int64),
        interchanged=interchanged[joint],
        mirror=mirror,
    )


def _outline(block: Block, seen: FloatArray, origin: FloatArray, mirror: int) -> Block:
    """Return a block in the view, its outline counter-clockwise from the leftmost (lowest) corner."""
    polygon = np.round(block.polygon * seen - origin, PICOMETRE)[::mirror]
    first = int(np.lexsort([polygon[:, 1], polygon[:, 0]])[0])
    return replace(block, polygon=read_only(np.roll(polygon, -first, axis=0)))


def _on_corners(points: FloatArray, wall: Wall) -> FloatArray:
    """Return points (k, 2), those on a corner of a block replaced by that corner."""
    corners, moved = np.vstack([block.polygon for block in wall.blocks]), points.copy()
    tree = shapely.STRtree(shapely.points(corners))
    point, corner = tree.query_nearest(shapely.points(points), max_distance=ON_CORNER, all_matches=False)
    moved[point] = corners[corner]
    return moved


def _ends(values: npt.NDArray[Scalar], interchanged: BoolArray) -> npt.NDArray[Scalar]:
    """Return values (k, 2) at start and end, interchanged where that is said."""
    return np.where(interchanged[:, None], values[:, ::-1], values)

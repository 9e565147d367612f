"""Ties in the plane: bars between two blocks, or a block and an anchor, that pull up to a strength and never push.

A tie is added to the joints as one of length L = TIE_LENGTH x the size of stones at its first end, across its line. It
has no friction and no cohesion, so it carries along the line only; its tensile strength is the tie's, its compressive
strength next to nothing, or the same where it pushes too. With the rectangular stress block it could carry a moment of
at most strength x L/8 (L/4 where it pushes) when it carries half its strength, and none when it yields. Here it is
rigid and plastic: a pretension changes nothing of the collapse multiplier. The FE pushover has its stiffness
(pushover/solids/tie_bars.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import shapely
from annotated_types import Ge, Gt, MinLen

from orchestrator.basis.arrays import IntArray, read_only
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.basis.units import Unit
from orchestrator.masonry.block_properties import block_areas, refuse_beyond_weight, thinner, weights_that_move
from orchestrator.masonry.interfaces import straight_interfaces
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.wall import Wall

TIE_LENGTH = 1e-5
"""length of the joint that stands for a tie, over the root of the mean area of blocks that move. A block held by an
anchor turns at its multiplier to 7e-10; 1e-7 would leave 8e-7, as both ends become one to the linear program"""
NO_THRUST = 1e-9
"""compressive over tensile strength of that joint"""
ANCHOR = -1
"""position of the block at an end that no block has"""
ON_OUTLINE = 1e-6
"""of a block's perimeter: an end so near its outline is on it"""


@dataclass(frozen=True, slots=True)
class Tie(Checked):
    """A bar between points of two blocks, or of one and an anchor that does not move; it weighs nothing."""

    blocks: Annotated[tuple[int, ...], MinLen(1)]
    """ids of the two blocks, or of the one that is anchored"""
    start: Annotated[tuple[Annotated[float, Unit("m")], ...], MinLen(2)]
    """x and y where it is fixed to the first block, as in ["0.4 m", "2.8 m"]"""
    end: Annotated[tuple[Annotated[float, Unit("m")], ...], MinLen(2)]
    """x and y where it is fixed to the second block, or anchored"""
    strength: Annotated[float, Gt(0), Unit("N")]
    """force at which it yields, or its anchorage does"""
    stiffness: Annotated[float, Gt(0), Unit("N/m")] | None = None
    """force over elongation, E A over the length; `run` needs it, limit analysis has rigid ties"""
    pretension: Annotated[float, Ge(0), Unit("N")] = 0.0
    """force to which it is tightened while the weight acts; changes nothing in limit analysis"""
    pushes: bool = False
    """it pushes as it pulls, up to `strength`: a floor that holds the wall at one place, or a strut"""


@dataclass(frozen=True, slots=True)
class TieSettings(Checked):
    """Ties and anchors, for limit analysis and the FE pushover."""

    ties: tuple[Tie, ...] = ()
    """each a table [[reinforcement.ties]] with `blocks`, `start`, `end`, `strength`, and for `run` `stiffness`"""


def ends_of(wall: Wall, ties: Sequence[Tie]) -> IntArray:
    """Return the positions (m, 2) of the blocks at the start and at the end of every tie, ANCHOR for none."""
    place = wall.place_of
    ends = [[place[name] for name in tie.blocks] + [ANCHOR] * (2 - len(tie.blocks)) for tie in ties]
    return read_only(np.reshape(ends, (-1, 2)), np.int64)


def with_ties(assemblage: Assemblage, ties: Sequence[Tie], settling: int | None = None) -> Assemblage:
    """Return the assemblage with ties after its joints, for limit analysis alone: they have no place in the planar map.

    An anchor is a point of the ground: of a support, but not of the one (its id) that is `settling`. Raises CaseError
    for a tie that joins nothing, and for an anchor where the ground is nothing but that support.
    """
    if not ties:
        return assemblage
    wall = assemblage.wall
    for number, tie in enumerate(ties):
        _refuse(wall, tie, f"reinforcement.ties.{number}")
    ends = ends_of(wall, ties)
    ground = [position for position, block in enumerate(wall.blocks) if block.fixed and block.id != settling]
    if not ground and (ends == ANCHOR).any():
        number, problem = int(np.argmax((ends == ANCHOR).any(axis=1))), f"no support stays where {settling} gives way"
        raise CaseError(
            f"reinforcement.ties.{number}.blocks", problem, "add a support that stays, or leave out the tie"
        )
    ends = np.where(ends == ANCHOR, ground[0] if ground else ANCHOR, ends)
    first, last = (np.array([getattr(tie, name) for tie in ties], dtype=float) for name in ("start", "end"))
    across = np.column_stack([first[:, 1] - last[:, 1], last[:, 0] - first[:, 0]])  # the normal then leads to the end
    across /= np.linalg.norm(across, axis=1)[:, None]
    free = [not block.fixed for block in wall.blocks]
    length = TIE_LENGTH * float(np.sqrt(np.mean(block_areas(wall)[free])))
    i, j = ends.T
    width = thinner(wall, i, j)
    strength = np.array([tie.strength for tie in ties]) / (length * width)
    start, end = first - 0.5 * length * across, first + 0.5 * length * across
    added = replace(
        straight_interfaces(i, j, start, end, width, np.zeros(len(ties))),
        tensile_strength=strength,
        compressive_strength=np.where([tie.pushes for tie in ties], 1.0, NO_THRUST) * strength,
    )
    return Assemblage(wall, assemblage.joints.and_also(added))


def idle_ties(wall: Wall, ties: Sequence[Tie], body_of_block: IntArray) -> list[str]:
    """Return a remark on every tie between two blocks of one body (n,): its ends keep their distance."""
    place = wall.place_of
    bodies = [{int(body_of_block[place[name]]) for name in tie.blocks} for tie in ties]
    return [
        f"tie {number} joins two stones of one macroblock: it holds nothing that could part there"
        for number, (tie, joined) in enumerate(zip(ties, bodies, strict=True), 1)
        if len(tie.blocks) == 2 and len(joined) == 1
    ]


def _refuse(wall: Wall, tie: Tie, key: str) -> None:
    """Raise CaseError for a tie between no two blocks or points, or whose ends lie beside its blocks."""
    blocks = {block.id: block for block in wall.blocks}
    named = set(tie.blocks)
    if len(tie.blocks) > 2 or len(named) < len(tie.blocks) or not named <= blocks.keys():
        raise CaseError(f"{key}.blocks", f"{[*tie.blocks]} are not one or two blocks", "name blocks of the wall")
    if tie.pretension >= tie.strength:
        problem = f"{tie.pretension:g} N is not less than the strength of the tie, {tie.strength:g} N"
        raise CaseError(f"{key}.pretension", problem, "lower it")
    refuse_beyond_weight(weights_that_move(wall), tie.strength, f"{key}.strength")
    if all(blocks[n].fixed for n in named):
        raise CaseError(f"{key}.blocks", "a tie between supports holds nothing", "name a block that can move")
    if len(tie.start) != 2 or len(tie.end) != 2 or tie.start == tie.end:
        raise CaseError(f"{key}.end", "start and end are not two points", 'give [x, y] of both, as in ["0 m", "2.8 m"]')
    for name, number in zip(("start", "end"), tie.blocks, strict=False):
        outline = shapely.Polygon(blocks[number].polygon)
        x, y = getattr(tie, name)
        if shapely.distance(outline, shapely.Point(x, y)) > ON_OUTLINE * outline.length:
            raise CaseError(f"{key}.{name}", f"({x:g}, {y:g}) m is not on block {number}", "give a point of the block")

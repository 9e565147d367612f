"""What became of the outlines of a drawing, in words: gaps and overlaps that were closed, or not, tips, short edges; or
why they could not be joined."""

from __future__ import annotations

import numpy as np
import shapely

from orchestrator.basis.errors import CaseError
from orchestrator.basis.printed import as_place, few, millimetres
from orchestrator.geometry.healing import Gap, closed_gaps, open_gaps
from orchestrator.geometry.planar_map import OverlapError, PlanarMap
from orchestrator.geometry.ring_geometry import depth_of_overlap
from orchestrator.masonry.sources.doubtful_stones import SLIVER, mean_width, slenderness
from orchestrator.masonry.wall import Block, Wall, shapes

NOT_SEEN = 1e-6
"""m: what is nearer was drawn in one place"""
MORE_THAN_ROUNDING = 0.01
"""part of the tolerance by which an overlap is more than the tolerance, and not as deep as it"""


def said_of_healing(joined: PlanarMap, wall: Wall, within: float) -> list[str]:
    """Return remarks on the healed `wall`: what was not closed over the tolerance `within` (m) first, then what was."""
    gaps = closed_gaps(joined)
    not_closed = [_words(gap, wall, within) for gap in open_gaps(joined)]
    return [*not_closed, *_said_deep(gaps, wall, within), *_summary(gaps, wall), *_said_changes(joined)]


class ThinStoneError(CaseError):
    """A stone thinner than what gaps and overlaps are closed over: no larger tolerance helps."""


def folded(drawn: Wall, error: OverlapError, within: float) -> CaseError:
    """Return what is wrong with blocks that lie on one another once gaps and overlaps up to `within` (m) are closed.

    Whether they overlap is judged on the wall as drawn. Where they do not, a stone between them is thinner than that.
    """
    i, j = error.blocks
    outlines, x, y = shapes(drawn), *error.point
    key = f"blocks {drawn.blocks[i].id} and {drawn.blocks[j].id} at {as_place(x, y)} m"
    near = {i, j, *shapely.STRtree(outlines).query(shapely.Point(x, y), "dwithin", within).tolist()}
    thinnest = min(sorted(near), key=lambda k: mean_width(outlines[k]))
    if depth_of_overlap(outlines[i].intersection(outlines[j])) > within:
        problem = f"lie on one another, by more than the tolerance of {millimetres(within)}"
        return CaseError(key, problem, "correct the drawing, or raise --tolerance")
    if thin := thin_stone(drawn.blocks[thinnest], within):
        return thin
    problem = f"fold over one another where gaps and overlaps up to {millimetres(within)} are closed"
    return CaseError(key, problem, "correct the corners there")


def thin_stone(block: Block, within: float) -> ThinStoneError | None:
    """Return what is wrong with a stone thinner than the `within` (m) that gaps are closed over; None if it is not."""
    outline = shapely.Polygon(block.polygon)
    if (width := mean_width(outline)) >= within:
        return None
    what, remedy = "is", "unite it with a neighbour, or lower --tolerance or --mortar"
    if slenderness(outline) > SLIVER[0]:
        what, remedy = "is a sliver", "a joint drawn twice? remove it"
    thinner = f"thinner than the {millimetres(within)} over which gaps and overlaps are closed"
    return ThinStoneError(f"block {block.id}", f"{what} {millimetres(width)} wide, {thinner}", remedy)


def _words(gap: Gap, wall: Wall, within: float) -> str:
    kind = "gap" if gap.width > 0 else "overlap"
    first, second = wall.blocks[gap.i].id, wall.blocks[gap.j].id
    x, y = gap.at
    why = "wider than the tolerance; --tolerance closes it, or --mortar if it is a joint"
    if abs(gap.width) <= within:
        why = (
            f"though no wider than {millimetres(within)}: a stone would touch itself there or lose more than a fifth "
            "of its area; draw both stones to one line there"
        )
    return (
        f"WARNING: {kind} of {millimetres(gap.width)} between blocks {first} and {second} at {as_place(x, y)} m NOT "
        f"closed, {why}"
    )


def _said_deep(closed: list[Gap], wall: Wall, within: float) -> list[str]:
    """Return a warning of overlaps that were closed with others though they are deeper than the tolerance (m)."""
    deep = [gap for gap in closed if -gap.width > within * (1 + MORE_THAN_ROUNDING)]
    named = [
        f"blocks {wall.blocks[gap.i].id} and {wall.blocks[gap.j].id} by {millimetres(gap.width)} at "
        f"{as_place(gap.at[0], gap.at[1])} m"
        for gap in deep
    ]
    return [f"WARNING: overlaps closed with others are deeper than the tolerance: {few(named)}"] if deep else []


def _summary(closed: list[Gap], wall: Wall) -> list[str]:
    """Return one line about gaps and one about overlaps that were closed, with the widest of each."""
    said = []
    for kind, gaps in (("gap", [g for g in closed if g.width > 0]), ("overlap", [g for g in closed if g.width < 0])):
        if gaps:
            widest = max(gaps, key=lambda gap: abs(gap.width))
            i, j = wall.blocks[widest.i].id, wall.blocks[widest.j].id
            median = float(np.median([abs(gap.width) for gap in gaps]))
            many = f"{len(gaps)} {kind}s" if len(gaps) > 1 else f"1 {kind}"
            said.append(
                f"{many} between blocks closed, median {millimetres(median)}, widest {millimetres(widest.width)} "
                f"between blocks {i} and {j} at {as_place(widest.at[0], widest.at[1])} m"
            )
    return said


def _said_changes(joined: PlanarMap) -> list[str]:
    """Return what else became of the outlines: tips cut back, edges that became points, joints taken straight."""
    said = []
    if joined.tips:
        many = f"{len(joined.tips)} acute tips that overlap" if len(joined.tips) > 1 else "1 acute tip that overlaps"
        said.append(f"WARNING: {many} cut back by up to {millimetres(max(joined.tips))}, more than the tolerance")
    collapsed = [length for length in joined.collapsed if length > NOT_SEEN]
    if collapsed:
        many = f"{len(collapsed)} short edges" if len(collapsed) > 1 else "1 short edge"
        said.append(f"{many} of stones taken for points, up to {millimetres(max(collapsed))} long")
    if joined.straightened:
        said.append(f"joints that bend taken straight, by up to {millimetres(joined.straightened)}")
    return said

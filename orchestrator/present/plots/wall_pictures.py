"""Pictures of the wall before any finite element: blocks, mechanism of micro limit analysis, macroblocks."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.basis.printed import counted, marked
from orchestrator.geometry.rigid import polygon_centroid, velocity_of_points
from orchestrator.limit_analysis.paper.limit_state import LimitState, Mechanism
from orchestrator.loads.block_loads import LoadSettings, height_of_live_load
from orchestrator.loads.dead_loads import DeadLoad
from orchestrator.macroblocks.criteria import Partition, refuse_other_partition
from orchestrator.masonry.block_properties import block_centroids
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.ties import Tie
from orchestrator.masonry.wall import Block, Wall
from orchestrator.present.plots.canvas import (
    BLUE,
    FAINT,
    GREEN,
    INK,
    STONE,
    VERMILLION,
    draw_polygons,
    draw_segments,
    draw_supports,
    label_of,
    number_size,
    wall_figure,
    write_number,
    write_numbers,
)
from orchestrator.present.plots.load_arrows import (
    LENGTH,
    draw_dead_load,
    draw_load,
    load_arrow,
    load_label,
    settlement_arrow,
    size_of,
)
from orchestrator.present.plots.thrust import carrying, moved, thrust
from orchestrator.present.plots.words import legend_below

DRAWN_DISPLACEMENT = 0.08
"""largest displacement of a drawn mechanism, part of the wall's height"""
MARKED_DISPLACEMENT = 1e-2
"""opening or slip of a joint that is marked, part of the mechanism's largest displacement"""
BODY_COLOURS = (
    "#99ddff", "#eedd88", "#44bb99", "#ffaabb", "#bbcc33", "#77aadd", "#ee8866", "#dddddd", "#aaaa00",
)  # fmt: skip
"""Paul Tol's light scheme: fills with dark text on them, distinguishable by colour-blind readers"""
MATERIALS = (STONE, "#ee8866", "#77aadd", "#eedd88", "#44bb99", "#ffaabb", "#bbcc33", "#99ddff", "#aaaa00")
"""fills of blocks by material: that of stone, then Tol's"""
WIDEST_THRUST = 5.0
"""width of the largest resultant, points"""
THINNEST_THRUST = 0.5
"""least width of any resultant, points"""


def blocks(wall: Wall, numbered: bool = False, marked: Sequence[int] = (), loose: Sequence[FloatArray] = ()) -> Figure:
    """Draw the blocks as they stand, a colour for each material, supports hatched, with their ids if `numbered`; the
    outlines of blocks with the ids `marked`, and of stones (n, 2) that were `loose`, in red."""
    figure, axes = wall_canvas(wall)
    draw_blocks(axes, wall)
    for block in wall.blocks:
        if block.id in marked:
            axes.fill(*block.polygon.T, facecolor="none", edgecolor=VERMILLION, linewidth=2.5, zorder=5)
    for number, outline in enumerate(loose):
        label = f"loose, left out or glued ({len(loose)})" if number == 0 else None
        style = {"edgecolor": VERMILLION, "linewidth": 1.5, "linestyle": "--", "zorder": 5}
        axes.fill(*outline.T, facecolor="none", label=label, **style)
    if numbered:
        number_blocks(axes, wall)
    legend_below(axes)
    return figure


def wall_canvas(wall: Wall, beside: FloatArray | None = None, said: str = "") -> tuple[Figure, Axes]:
    """Return a figure of a wall's size that counts its blocks, with room for points (n, 2) `beside` it; what else is
    said of it is a line of the title."""
    free = sum(not block.fixed for block in wall.blocks)
    supports = len(wall.blocks) - free
    title = f"{free} block{'s' * (free != 1)}, {supports} support{'s' * (supports != 1)}"
    corners = [block.polygon for block in wall.blocks]
    points = np.vstack(corners if beside is None else [*corners, beside])
    return wall_figure(points, f"{title}\n{said}".rstrip(), wall.name)


def draw_blocks(axes: Axes, wall: Wall) -> None:
    """Draw the blocks as they stand, a colour for each material, supports hatched."""
    materials = sorted({block.material for block in wall.blocks if not block.fixed})
    for name, fill in zip(materials, MATERIALS * len(materials), strict=False):
        stones = [b.polygon for b in wall.blocks if not b.fixed and b.material == name]
        draw_polygons(axes, stones, fill).set_label(f"{label_of(name)} ({len(stones)})" if name else "block")
    draw_supports(axes, [b.polygon for b in wall.blocks if b.fixed])


def number_blocks(axes: Axes, wall: Wall) -> None:
    """Write the blocks' ids."""
    polygons = [block.polygon for block in wall.blocks]
    centres = [polygon_centroid(polygon) for polygon in polygons]
    write_numbers(axes, centres, [block.id for block in wall.blocks], number_size(polygons, axes))


def mechanism(
    assemblage: Assemblage,
    state: LimitState,
    direction: FloatArray,
    load_name: str = "λ × weight",
    loads: str = "",
    answer: str = "",
    loose: Collection[int] = (),
    ties: Sequence[Tie] = (),
    dead: Sequence[DeadLoad] = (),
    height: float | None = None,
) -> Figure:
    """Draw the collapse mechanism: blocks displaced by their velocities times one factor, hinges and sliding joints.

    The live load is an arrow along its direction (2,), at the `height` (m) of its resultant (none: of the weight), with
    its name. `loads` (weights in words) and `answer`
    (none: the load multiplier) go into the title. Stones `loose` (ids) have come loose before. Ends of ties, and the
    arrows of extra loads `dead`, move with their blocks. A hinge is a joint that opens at one end only (marked at the
    other end), a sliding joint one that slips while it carries load; a joint that has come apart is left to be seen as
    a gap. Thrust: see thrust.py.
    Displacements are linear in the velocities, as in the analysis: large rotations enlarge the blocks.
    """
    wall = assemblage.wall
    wall_height = float(np.ptp([y for block in wall.blocks for y in block.polygon[:, 1]]))
    factor = DRAWN_DISPLACEMENT * wall_height / state.mechanism.largest_displacement
    velocities = factor * state.mechanism.velocities
    displaced = displaced_blocks(assemblage, state.mechanism, DRAWN_DISPLACEMENT)
    arrow = _arrow_of(wall, state, direction, height)
    title = _title_of_mechanism(state, answer, loads, wall_height)
    bars = [_displaced_tie(wall, tie, velocities) for tie in ties]
    above = [np.array([0.0, LENGTH * size_of(wall)]) + np.vstack(displaced).max(axis=0)] * bool(dead)
    shown = np.vstack([*(block.polygon for block in wall.blocks), *displaced, arrow, *bars, *above])
    figure, axes = wall_figure(np.vstack([shown, load_label(shown, arrow, load_name)]), title, wall.name)
    _draw_displaced(axes, wall, displaced, loose)
    _draw_thrust(axes, assemblage, state, velocities)
    _mark_joints(axes, assemblage, state, velocities)
    if bars:
        draw_segments(axes, bars, INK, 2.0, "tie")
    _draw_floors(axes, wall, dead, velocities)
    draw_load(axes, arrow, load_name)
    legend_below(axes, 3)
    return figure


def _draw_floors(axes: Axes, wall: Wall, dead: Sequence[DeadLoad], velocities: FloatArray) -> None:
    """Draw the arrows of extra dead loads, if there are any, where their blocks have moved to."""
    if not dead:
        return
    drawn = draw_dead_load(axes, wall, dead, lambda k, at: at + rigid_displacement(wall.blocks[k], velocities[k], at))
    drawn.set_label("extra dead loads")


def _title_of_mechanism(state: LimitState, answer: str, loads: str, height: float) -> str:
    answer = answer or f"load multiplier {marked('multiplier', state.load_multiplier, state.converged)}"
    drawn = f"{DRAWN_DISPLACEMENT * height:.3g} m ({DRAWN_DISPLACEMENT:.0%} of the height)"
    shown = f"Mechanism of micro-LA ({state.name}): {answer}"
    return "\n".join(filter(None, [shown, loads, f"largest displacement drawn as {drawn}"]))


def _arrow_of(wall: Wall, state: LimitState, direction: FloatArray, height: float | None) -> FloatArray:
    """Return the arrow of the live load, with its resultant at a height, or of the support that gives way."""
    loaded = np.vstack([block.polygon for block in wall.blocks if not block.fixed])
    sinking = [b.polygon for b, v in zip(wall.blocks, state.mechanism.velocities, strict=True) if b.fixed and v.any()]
    if sinking:
        return settlement_arrow(np.vstack(sinking), loaded, direction)
    return load_arrow(loaded, direction, height_of_live_load(wall, LoadSettings()) if height is None else height)


def _draw_displaced(axes: Axes, wall: Wall, displaced: Sequence[FloatArray], loose: Collection[int]) -> None:
    """Draw the blocks before and after, without those that have come loose, which are marked where they were."""
    draw_polygons(axes, [block.polygon for block in wall.blocks], "none", FAINT, 0.5).set_label("undeformed")
    if loose:
        gone = [block.polygon for block in wall.blocks if block.id in loose]
        draw_polygons(axes, gone, VERMILLION + "80").set_label("comes loose before: local failure")
    there = [p for p, b in zip(displaced, wall.blocks, strict=True) if not b.fixed and b.id not in loose]
    draw_polygons(axes, there, STONE + "c0").set_label("displaced")
    draw_supports(axes, [p for p, b in zip(displaced, wall.blocks, strict=True) if b.fixed])


def macroblocks(assemblage: Assemblage, partition: Partition) -> Figure:
    """Draw the bodies in colours that differ between neighbours, their numbers, and the interfaces thick.

    Raises CaseError for a partition of another wall.
    """
    refuse_other_partition(assemblage, partition)
    wall, body = assemblage.wall, partition.body_of_block
    remaining = np.setdiff1d(np.arange(assemblage.joints.count), partition.vanished_joints)
    polygons = [block.polygon for block in wall.blocks]
    title = f"{counted(partition.count, 'macroblock')}, {len(remaining)} of {assemblage.joints.count} joints remain"
    figure, axes = wall_figure(np.vstack(polygons), title, wall.name)
    free = np.flatnonzero([not block.fixed for block in wall.blocks])
    colours = body_colours(assemblage, partition)
    fill = [colours[body[block]] for block in free]
    draw_polygons(axes, [polygons[block] for block in free], fill, INK, 0.3)
    draw_supports(axes, [block.polygon for block in wall.blocks if block.fixed])
    segments = np.stack([assemblage.joints.start, assemblage.joints.end], axis=1)[remaining]
    draw_segments(axes, segments, "black", 2.0, "interface")
    for number in range(partition.count):
        members = [wall.blocks[block] for block in np.flatnonzero(body == number)]
        write_number(axes, label_position(members), number, 9.0)
    legend_below(axes)
    return figure


def body_colours(assemblage: Assemblage, partition: Partition) -> list[str]:
    """Return the fill of every moving body, different from those of its neighbours."""
    body = partition.body_of_block
    pairs = np.column_stack([body[assemblage.joints.i], body[assemblage.joints.j]])
    apart = (pairs[:, 0] != pairs[:, 1]) & np.all(pairs < partition.count, axis=1)
    return [BODY_COLOURS[k % len(BODY_COLOURS)] for k in colours_of_bodies(pairs[apart], partition.count)]


def _displaced_tie(wall: Wall, tie: Tie, velocities: FloatArray) -> FloatArray:
    """Return both ends (2, 2) in m of a tie; an anchor stays."""
    place = wall.place_of
    ends = [np.array(end, float) for end in (tie.start, tie.end)]
    for end, block in zip(ends, tie.blocks, strict=False):
        position = place[block]
        end += rigid_displacement(wall.blocks[position], velocities[position], end[None])[0]
    return np.array(ends)


def displaced_blocks(assemblage: Assemblage, mechanism: Mechanism, part: float) -> list[FloatArray]:
    """Return the corners of all blocks, displaced so that the largest displacement is `part` of the wall's height."""
    wall = assemblage.wall
    height = float(np.ptp([y for block in wall.blocks for y in block.polygon[:, 1]]))
    velocities = part * height / mechanism.largest_displacement * mechanism.velocities
    return [b.polygon + rigid_displacement(b, v, b.polygon) for b, v in zip(wall.blocks, velocities, strict=True)]


def rigid_displacement(block: Block, velocity: FloatArray, points: FloatArray) -> FloatArray:
    """Return the displacement (p, 2) of `points` (p, 2) moving with a block that turns about its centroid."""
    return velocity_of_points(velocity, points - polygon_centroid(block.polygon))


def hinge_ends(opening: FloatArray, threshold: float) -> IntArray:
    """Return for each joint the end it hinges about (0 start, 1 end) or -1; `opening` (k, 2) as in Mechanism."""
    one_opens = (opening.max(axis=1) > threshold) & (np.abs(opening.min(axis=1)) <= threshold)
    return np.where(one_opens, opening.argmin(axis=1), -1)


def colours_of_bodies(pairs: IntArray, count: int) -> IntArray:
    """Return a colour number (count,) per body so that bodies in a pair (p, 2) differ, spread over all colours.

    Bodies are coloured in order with the least used colour that no coloured neighbour has.
    """
    chosen = np.full(count, -1)
    used = np.zeros(max(len(BODY_COLOURS), count), dtype=int)
    for body in range(count):
        neighbours = pairs[np.any(pairs == body, axis=1)]
        taken = {int(chosen[other]) for other in np.unique(neighbours)} - {-1}
        free = [colour for colour in range(len(used)) if colour not in taken]
        within = [colour for colour in free if colour < len(BODY_COLOURS)] or free
        chosen[body] = min(within, key=lambda colour: (used[colour], colour))
        used[chosen[body]] += 1
    return chosen


def label_position(members: list[Block]) -> FloatArray:
    """Return where a body's number goes (2,): the centroid of its block nearest to the centroid of them all."""
    centres = np.array([polygon_centroid(block.polygon) for block in members])
    return centres[np.argmin(np.linalg.norm(centres - centres.mean(axis=0), axis=1))]


def _draw_thrust(axes: Axes, assemblage: Assemblage, state: LimitState, displacements: FloatArray) -> None:
    """Draw the struts between joints as wide as the resultants are large, moved with the blocks."""
    drawn = thrust(assemblage, state.joint_forces)
    largest = float(drawn.resultant.max())
    widest_first = np.argsort(-drawn.resultant)  # the legend shows the first
    segments = moved(assemblage, drawn, displacements)[widest_first]
    lines = draw_segments(axes, segments, GREEN, WIDEST_THRUST, f"thrust (widest: {largest / 1e3:.3g} kN)")
    lines.set_linewidth(np.maximum(THINNEST_THRUST, WIDEST_THRUST * drawn.resultant[widest_first] / largest).tolist())


def _mark_joints(axes: Axes, assemblage: Assemblage, state: LimitState, velocities: FloatArray) -> None:
    """Mark hinges and sliding joints in the displaced wall, midway between the two faces."""
    threshold = MARKED_DISPLACEMENT * state.mechanism.largest_displacement
    points = (assemblage.joints.start, assemblage.joints.end)
    ends = np.stack([_displaced(assemblage, point, velocities) for point in points], axis=1)
    sliding = (np.abs(state.mechanism.slip) > threshold) & carrying(state.joint_forces)
    if sliding.any():
        draw_segments(axes, ends[sliding], BLUE, 2.0, "sliding joint")
    end = hinge_ends(state.mechanism.opening, threshold)
    hinges = ends[end >= 0, end[end >= 0]]
    if len(hinges):
        axes.plot(*hinges.T, "o", color="white", markeredgecolor=INK, markersize=5.5, zorder=4, label="hinge", mew=1.2)


def _displaced(assemblage: Assemblage, points: FloatArray, velocities: FloatArray) -> npt.NDArray[np.float64]:
    """Return one point (k, 2) per joint, moved by the mean of the two blocks that meet there."""
    centres, moved = block_centroids(assemblage.wall), points.copy()
    for side in (assemblage.joints.i, assemblage.joints.j):
        moved += 0.5 * velocity_of_points(velocities[side], points - centres[side])
    return moved

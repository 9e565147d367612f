"""PNG of a wall in space: blocks, joints and supports; the mechanism from the usual sides; multiplier by direction."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.atomic_files import write_bytes
from orchestrator.geometry.polyhedra import Polyhedron
from orchestrator.geometry.rigid import velocity_of_points
from orchestrator.present.in_space.raster import Line, Picture, View, drawn, places_of_numbers, view_towards
from orchestrator.present.phrases import phrases
from orchestrator.settings.project import Language
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.displaced_blocks import moved
from orchestrator.space.loads import plan_axes
from orchestrator.space.mechanism import AT_REST, SpaceMechanism, corner_speeds

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STONE = (0.93, 0.89, 0.80)
"""colour of stones at rest; red, green and blue from 0 to 1"""
SUPPORT = (0.80, 0.80, 0.80)
"""colour of supports"""
BODIES = (
    (0.94, 0.66, 0.45), (0.55, 0.75, 0.92), (0.62, 0.83, 0.66), (0.93, 0.83, 0.48), (0.85, 0.68, 0.84),
    (0.70, 0.74, 0.62), (0.96, 0.72, 0.72), (0.62, 0.72, 0.72),
)  # fmt: skip
"""colours of stones that move as one body; after the last the first comes again"""
KINDS = {
    "hinges": ((0.84, 0.37, 0.0), 3.0, "hinge"),
    "opens": ((0.90, 0.62, 0.0), 1.0, "opens"),
    "slides": ((0.0, 0.45, 0.70), 2.0, "slides"),
    "twists": ((0.80, 0.47, 0.65), 2.0, "twists"),
}
"""colour, width and name of joints that move"""
TIE = ((0.0, 0.62, 0.45), 5.0, "tie")
"""colour, width and name of ties, which show through the stones that they run in"""
PIXELS = 900
"""on the longer side of a view"""
PANEL = (5.2, 4.1)
"""inches; about what a view has in a picture"""
NUMBERS = (3.5, 9.0)
"""points; smallest numbers of blocks that can be read, others are left out, and largest"""
AMPLITUDE = 0.12
"""largest displacement of the mechanism in pictures, as a part of the wall's height"""


def views_of(up: FloatArray, direction: FloatArray) -> dict[str, View]:
    """Return the usual views: from the side the wall falls to (or the front), from its side, from above, and aslant."""
    _, second = plan_axes(up)
    flat = direction - (direction @ up) * up
    ahead = flat / np.linalg.norm(flat) if np.linalg.norm(flat) > 1e-6 else -second
    beside = np.cross(up, ahead)
    return {
        "aslant": view_towards("aslant", ahead + 0.75 * beside + 0.6 * up, up),
        "front": view_towards("from where it is pushed to", ahead, up),
        "side": view_towards("from the side", beside, up),
        "plan": view_towards("from above", up, ahead * -1.0),
    }


def save_wall(assemblage: SpaceAssemblage, direction: FloatArray, path: Path, language: Language = "en") -> Path:
    """Draw blocks with their ids, joints (blue), ties (green) and supports (grey), aslant from both sides, in a
    language; return `path`."""
    wall, joints = assemblage.wall, assemblage.joints
    bodies = [block.shape for block in wall.blocks]
    colours = np.array([SUPPORT if block.fixed else STONE for block in wall.blocks])
    edges = (joints.outlines[k] for k in np.flatnonzero(~joints.is_tie))
    ties = tie_lines(assemblage, bodies)
    lines = [Line(np.vstack([outline, outline[:1]]), (0.0, 0.45, 0.70), 0.5) for outline in edges] + ties
    both = [view for name, view in views_of(wall.up, direction).items() if name == "aslant"]
    both.append(_opposite(both[0], wall.up))
    supports, tied = int(wall.fixed.sum()), f"ties: {len(ties)} (green), " if ties else ""
    text = f"blocks: {len(bodies) - supports}, joints: {joints.count - len(ties)} (blue where they are seen), {tied}"
    text += f"supports: {supports} (grey)"
    panels = [(bodies, colours, lines, view) for view in both]
    return _save(path, wall.name, text, panels, phrases(language), ids=[block.id for block in wall.blocks])


def _opposite(view: View, up: FloatArray) -> View:
    eye = view.axes[2]
    height = (eye @ up) * up
    return view_towards("from the other side", 2.0 * height - eye, up)


def save_mechanism(
    assemblage: SpaceAssemblage,
    velocities: FloatArray,
    mechanism: SpaceMechanism,
    direction: FloatArray,
    text: str,
    path: Path,
    language: Language = "en",
) -> Path:
    """Draw a mechanism with velocities (n, 6) of all blocks from the usual sides, every body in a colour of its own and
    joints by how they move, in a language; return `path`."""
    wall = assemblage.wall
    scale = amplitude(assemblage, velocities)
    bodies = moved(wall, scale * velocities)
    colours = np.array(
        [
            SUPPORT if block.fixed else STONE if body == 0 else BODIES[(int(body) - 1) % len(BODIES)]
            for block, body in zip(wall.blocks, mechanism.body, strict=True)
        ]
    )
    lines, ties = joint_lines(assemblage, bodies, velocities, mechanism), tie_lines(assemblage, bodies)
    panels = [(bodies, colours, lines + ties, view) for view in views_of(wall.up, direction).values()]
    legend = [KINDS[kind] for kind in sorted({*mechanism.motion} - {"rests", "opens"})]
    return _save(path, wall.name, text, panels, phrases(language), legend + [TIE] * bool(ties))


def amplitude(assemblage: SpaceAssemblage, velocities: FloatArray) -> float:
    """Return the factor on velocities that makes the largest displacement AMPLITUDE of the wall's height."""
    wall = assemblage.wall
    heights = np.concatenate([b.shape.vertices @ wall.up for b in wall.blocks if not b.fixed])
    largest = float(corner_speeds(assemblage, velocities).max())
    return AMPLITUDE * float(np.ptp(heights)) / largest if largest else 0.0


def joint_lines(
    assemblage: SpaceAssemblage, bodies: Sequence[Polyhedron], velocities: FloatArray, mechanism: SpaceMechanism
) -> list[Line]:
    """Return the outlines of joints that slide or twist and the closed edge of those that hinge, on the moved
    blocks."""
    joints, wall = assemblage.joints, assemblage.wall
    centroids, limit = wall.centroids, AT_REST * float(corner_speeds(assemblage, velocities).max())
    lines = []
    for k, kind in enumerate(mechanism.motion):
        if kind not in ("hinges", "slides", "twists"):
            continue
        corners, i, j = joints.corners(k), joints.i[k], joints.j[k]
        if kind == "hinges":
            of_i, of_j = (velocity_of_points(velocities[block], corners - centroids[block]) for block in (i, j))
            opening = (of_j - of_i) @ joints.normal[k]
            shut = corners[opening <= limit + max(float(opening.min()), 0.0)]
            line = shut if len(shut) > 1 else np.repeat(shut, 2, axis=0)
        else:
            line = np.vstack([corners, corners[:1]])
        colour, width, _ = KINDS[kind]
        lines.append(Line(_carried(line, wall.blocks[i].shape, bodies[i]), colour, width))
    return lines


def tie_lines(assemblage: SpaceAssemblage, bodies: Sequence[Polyhedron]) -> list[Line]:
    """Return the ties between the blocks as they are or have moved to."""
    joints, blocks = assemblage.joints, assemblage.wall.blocks
    lines = []
    for k in np.flatnonzero(joints.is_tie).tolist():
        ends = zip(joints.outlines[k], (joints.i[k], joints.j[k]), strict=True)
        moved_ends = [_carried(end[None], blocks[block].shape, bodies[block]) for end, block in ends]
        lines.append(Line(np.vstack(moved_ends), *TIE[:2], through=True))
    return lines


def _carried(points: FloatArray, before: Polyhedron, after: Polyhedron) -> FloatArray:
    """Return points of a block after its motion, found from its corners."""
    origin, moved_origin = before.vertices.mean(axis=0), after.vertices.mean(axis=0)
    turn, *_ = np.linalg.lstsq(before.vertices - origin, after.vertices - moved_origin, rcond=None)
    return np.asarray(moved_origin + (points - origin) @ turn)


def save_polar(
    angles: FloatArray, multipliers: dict[str, FloatArray], name: str, path: Path, language: Language = "en"
) -> Path:
    """Draw multipliers (d,) against the angle in plan (d,) in rad, in a language; return `path`."""
    from matplotlib.figure import Figure

    say = phrases(language)
    figure = Figure(figsize=(6.0, 6.0))
    axes = figure.add_subplot(projection="polar")
    for (label, values), style in zip(multipliers.items(), ("-o", "--s"), strict=False):
        closed = np.append(values, values[:1])
        axes.plot(np.append(angles, angles[:1]), closed, style, markersize=4, label=say(label))
    axes.set_title(f"{name}\n{say('load multiplier by direction in plan')}", fontsize=10, parse_math=False)
    axes.set_ylim(0.0, None)
    axes.legend(loc="lower left", bbox_to_anchor=(-0.1, -0.12), fontsize=8)
    return _written(figure, path)


Key = tuple[tuple[float, float, float], float, str]
Panel = tuple[Sequence[Polyhedron], FloatArray, Sequence[Line], View]


def _save(
    path: Path,
    name: str,
    text: str,
    panels: Sequence[Panel],
    say: Callable[[str], str],
    legend: Sequence[Key] = (),
    ids: Sequence[int] = (),
) -> Path:
    """Draw panels in two columns, all to one scale, with a title, a legend of joints and ties, and on the blocks ids
    that are given."""
    from matplotlib.figure import Figure  # 0.3 s that other commands need not wait for
    from matplotlib.lines import Line2D

    rows = -(-len(panels) // 2)
    figure = Figure(figsize=(11.0, 0.8 + 4.4 * rows))
    figure.set_layout_engine("constrained")
    boxes = [_box(*panel) for panel in panels]
    for number, ((bodies, colours, lines, view), box) in enumerate(zip(panels, boxes, strict=True), 1):
        axes = figure.add_subplot(rows, 2, number)
        picture = drawn(bodies, colours, lines, view, box, PIXELS)
        axes.imshow(picture.pixels, interpolation="antialiased")
        if ids:
            _write_ids(axes, picture, ids)
        axes.set_title(say(view.name), fontsize=9)
        axes.axis("off")
    figure.suptitle(f"{name}\n{say(text)}", fontsize=10, parse_math=False)
    handles = [Line2D([], [], color=colour, linewidth=width, label=say(name)) for colour, width, name in legend]
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), fontsize=9, frameon=False)
    return _written(figure, path)


def _write_ids(axes: Axes, picture: Picture, ids: Sequence[int]) -> None:
    """Write the ids of blocks on the faces that are seen, as large as they fit, where they can be read."""
    from matplotlib.patheffects import withStroke

    height, width = picture.face.shape
    points = 72.0 * min(PANEL[0] / width, PANEL[1] / height)
    halo = [withStroke(linewidth=1.5, foreground="white", alpha=0.8)]
    for body, (column, row, across, along) in places_of_numbers(picture).items():
        number = str(ids[body])
        size = points * min(0.9 * along, across / (0.7 * len(number)))
        if size >= NUMBERS[0]:
            text = axes.text(column, row, number, ha="center", va="center", fontsize=min(size, NUMBERS[1]))
            text.set(path_effects=halo, in_layout=False)


def _box(
    bodies: Sequence[Polyhedron], colours: FloatArray, lines: Sequence[Line], view: View
) -> tuple[FloatArray, FloatArray]:
    """Return the corners in the view of what is no support, ties among it, with a margin: a large ground is cut."""
    free = [body.vertices for body, colour in zip(bodies, colours, strict=True) if tuple(colour) != SUPPORT]
    flat = np.vstack([*free, *(line.points for line in lines if line.through)]) @ view.axes[:2].T
    low, high = flat.min(axis=0), flat.max(axis=0)
    margin = 0.08 * float((high - low).max())
    return low - margin, high + margin


def _written(figure: Figure, path: Path) -> Path:
    buffer = BytesIO()
    figure.savefig(buffer, format="png", dpi=150)
    write_bytes(path, buffer.getvalue())
    return path

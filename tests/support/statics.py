"""Limit analysis of joints that crush by another road: N, V and M of every joint, fine polygons, HiGHS (SciPy)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from scipy.optimize import linprog

from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.ties import Tie

CORNERS = 500
"""Of a polygon: sin^2 of equal steps, which lose (pi/1000)^2 = 1e-5 of every moment."""
PARTS = np.sin(np.linspace(0.0, np.pi / 2, CORNERS + 1)) ** 2
LOST = (np.pi / (2 * CORNERS)) ** 2


def by_statics(
    assemblage: Assemblage, ties: Sequence[Tie], direction: tuple[float, float], moment: float = 1.0
) -> float | None:
    """Return the greatest multiplier of every block's weight along `direction`, None where the dead load falls.

    |M| <= moment (N + N_t)/2 (L - (N + N_t)/((f_c + f_t) t)), |V| <= mu N + c; a tie pulls with 0 to its strength. The
    ties are the last joints of the assemblage.
    """
    joints, count = assemblage.joints, assemblage.joints.count - len(ties)
    A, b = equilibrium(assemblage, ties, direction)
    area = joints.area[:count]
    pulled, slope_of_moment = joints.tensile_strength[:count] * area, 0.5 * moment * joints.length[:count]
    both = pulled + joints.compressive_strength[:count] * area
    rows, most = [], []
    before, after = PARTS[:-1], PARTS[1:]
    for k in range(count):
        slope = slope_of_moment[k] * (1.0 - before - after)
        there = slope_of_moment[k] * before * after * both[k] + slope * pulled[k]
        for sign in (1.0, -1.0):
            row = np.zeros((CORNERS + 1, A.shape[1]))
            row[:-1, 3 * k], row[:-1, 3 * k + 2] = -slope, sign
            row[-1, 3 * k], row[-1, 3 * k + 1] = -joints.friction[k], sign
            rows.append(row)
            most += [*there, joints.cohesion[k] * area[k]]
    force = float(np.mean(b[1::3]))
    bounds = [(None, None)] * (3 * count) + [(0.0, tie.strength / force) for tie in ties]
    program = np.concatenate(rows), np.array(most) / force, A, b / force
    stands, found = (linprog(-np.eye(A.shape[1])[-1], *program, [*bounds, (0.0, end)]) for end in (0.0, None))
    assert {stands.status, found.status} <= {0, 2}, found.message
    return None if stands.status else float(found.x[-1] * force)


def equilibrium(
    assemblage: Assemblage, ties: Sequence[Tie], direction: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Return what N, V, M of joints, the forces of ties and lambda do to the free blocks, and what must come of it.

    Three rows a block: forces, and moments about the origin.
    """
    wall, joints = assemblage.wall, assemblage.joints
    row = {block: 3 * n for n, block in enumerate(k for k, one in enumerate(wall.blocks) if not one.fixed)}
    count = joints.count - len(ties)
    A, b = np.zeros((3 * len(row), 3 * count + len(ties) + 1)), np.zeros(3 * len(row))

    def push(block: int, column: int, point, force, couple: float = 0.0) -> None:
        if block in row:
            moment = point[0] * force[1] - point[1] * force[0] + couple
            A[row[block] : row[block] + 3, column] += (*force, moment)

    for k in range(count):
        middle = 0.5 * (joints.start[k] + joints.end[k])
        for block, sign in ((joints.j[k], 1.0), (joints.i[k], -1.0)):
            push(block, 3 * k, middle, sign * joints.normal[k])
            push(block, 3 * k + 1, middle, sign * joints.tangent[k])
            push(block, 3 * k + 2, middle, (0.0, 0.0), sign)
    place = {one.id: n for n, one in enumerate(wall.blocks)}
    for number, tie in enumerate(ties):
        start, end = np.array(tie.start), np.array(tie.end)
        pull = (end - start) / np.linalg.norm(end - start)
        for name, point, force in zip(tie.blocks, (start, end), (pull, -pull), strict=False):
            push(place[name], 3 * count + number, point, force)
    for block, first in row.items():
        outline = shapely.Polygon(wall.blocks[block].polygon)
        weight, (x, y) = wall.blocks[block].unit_weight * outline.area * wall.thickness, outline.centroid.coords[0]
        push(block, -1, (x, y), weight * np.array(direction))
        b[first : first + 3] = (0.0, weight, x * weight)
    return A, b

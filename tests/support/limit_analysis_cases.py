"""Walls for the verification of micro limit analysis, and an audit of its states that shares no code with it.

The audit knows only the written conventions (masonry/joints.py, limit_analysis/paper/limit_state.py): it takes areas
and centroids from shapely, adds up forces joint by joint in Python, and moments about the origin instead of centroids.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import hypot

import numpy as np
from shapely.geometry import Polygon
from shapely.geometry.polygon import orient

from orchestrator.basis.arrays import read_only
from orchestrator.limit_analysis import LimitAnalysis, LimitState, analyse
from orchestrator.loads import Loads, LoadSettings, loads_on
from orchestrator.masonry.joints import Assemblage, JointSettings, find_joints
from orchestrator.masonry.wall import Block, Wall
from tests.support.paths import DATA, PROJECT
from tests.support.seconds import shared

FOLDERS = (DATA, PROJECT / "meshes")


def description(name: str) -> dict:
    """Return the JSON of a block file, with the values it carries under "expected"."""
    (path,) = (folder / f"{name}.json" for folder in FOLDERS if (folder / f"{name}.json").exists())
    return json.loads(path.read_text())


@shared
def case(name: str) -> Assemblage:
    """Return the assemblage of a block file (unit weights in kN/m3)."""
    data = description(name)
    polygons = [block["polygon"] for block in data["blocks"]]
    fixed = [number for number, block in enumerate(data["blocks"]) if block["fixed"]]
    return assemblage_of(polygons, fixed, data["friction"], data["thickness"], 1e3 * data["unit_weight"])


def weight_along(assemblage: Assemblage, direction: int) -> Loads:
    """Return a wall's weight, and the same forces along +x (1) or -x (-1)."""
    return loads_on(assemblage.wall, LoadSettings("+x" if direction > 0 else "-x"))


def analysed(assemblage: Assemblage, direction: int) -> LimitAnalysis:
    """Analyse a wall under its weight, pushed along +x (1) or -x (-1)."""
    return analyse(assemblage, loads=weight_along(assemblage, direction))


@shared
def answers(name: str, load_direction: int = 1) -> LimitAnalysis:
    """Analyse a block file with default settings."""
    return analysed(case(name), load_direction)


def assemblage_of(polygons, fixed=(0,), friction=0.65, thickness=1.0, unit_weight=20e3) -> Assemblage:
    """Return the assemblage of polygons; `fixed` lists the supports."""
    blocks = tuple(
        Block(number, read_only(orient(Polygon(polygon)).exterior.coords[:-1]), number in fixed, unit_weight)
        for number, polygon in enumerate(polygons)
    )
    return find_joints(Wall("test", blocks, thickness, friction), JointSettings())


def box(x: float, y: float, width: float, height: float) -> list[tuple[float, float]]:
    """Rectangle with its lower left corner at (x, y)."""
    return [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]


FLOOR = box(-3.0, -0.5, 6.0, 0.5)


def tower(width, height, blocks=1, friction=0.65):
    """Equal blocks of 20 kN/m3 on a floor, 1 m thick."""
    stones = [box(-width / 2, height * level, width, height) for level in range(blocks)]
    return assemblage_of([FLOOR, *stones], friction=friction)


def transformed(assemblage: Assemblage, change) -> Assemblage:
    """Return the wall with every corner (n, 2) changed by a function that may mirror, and its joints found anew."""
    wall = assemblage.wall
    polygons = [change(np.array(block.polygon)) for block in wall.blocks]
    fixed = [number for number, block in enumerate(wall.blocks) if block.fixed]
    return assemblage_of(polygons, fixed, wall.friction, wall.thickness, wall.blocks[0].unit_weight)


def mirrored(assemblage: Assemblage) -> Assemblage:
    """Return the wall seen from behind."""
    return transformed(assemblage, lambda polygon: polygon * [-1.0, 1.0])


@dataclass
class Audit:
    """What a state does wrong, relative to the total weight, the mean block weight (mbw) or the largest displacement.

    unbalanced: largest unbalanced force of any block (moments over its size), relative to the total weight.
    tension, excess_shear: beyond Coulomb's law, mbw. wrong_rates: difference between stated openings and slips and
    those of the block velocities. penetration: largest closing of a joint. power: live + dead power, friction_power:
    sum (c + mu N) |slip|, backward: largest power that friction gives instead of takes, all relative to the live load's
    power. loaded_gap: largest opening or closing where a joint carries load. idle: motion in joints that carry load
    well inside their friction lines.
    """

    unbalanced: float
    tension: float
    excess_shear: float
    wrong_rates: float
    penetration: float
    power: float
    friction_power: float
    backward: float
    loaded_gap: float
    idle: float


def audit(assemblage: Assemblage, state: LimitState, load_direction: int = 1) -> Audit:
    """Check a state against statics, Coulomb's law and kinematics, block by block and joint by joint."""
    blocks, thickness = assemblage.wall.blocks, assemblage.wall.thickness
    shapes = [Polygon(block.polygon) for block in blocks]
    weights = [shape.area * thickness * block.unit_weight for shape, block in zip(shapes, blocks, strict=True)]
    free = [number for number, block in enumerate(blocks) if not block.fixed]
    total, mean = sum(weights[k] for k in free), sum(weights[k] for k in free) / len(free)
    velocities, largest = state.mechanism.velocities, 0.0
    loads = {}
    for k in free:
        x, y = shapes[k].centroid.coords[0]
        horizontal = state.load_multiplier * load_direction * weights[k]
        loads[k] = np.array([horizontal, -weights[k], -weights[k] * x - horizontal * y])
        for corner in blocks[k].polygon:
            largest = max(largest, hypot(*_point_velocity(velocities[k], (x, y), corner)))
    worst = Audit(*[0.0] * 10)
    friction_power = 0.0
    for k, (i, j) in enumerate(assemblage.joints.pairs):
        start, end = assemblage.joints.start[k], assemblage.joints.end[k]
        length = hypot(*(end - start))
        tx, ty = (end - start) / length
        normal, tangent, middle = np.array([ty, -tx]), np.array([tx, ty]), (start + end) / 2
        n_start, n_end, shear = state.joint_forces[k]
        for point, force in ((start, n_start * normal), (end, n_end * normal), (middle, shear * tangent)):
            push = np.array([*force, point[0] * force[1] - point[1] * force[0]])
            if j in loads:
                loads[j] = loads[j] + push
            if i in loads:
                loads[i] = loads[i] - push
        mu, cohesion = assemblage.joints.friction[k], assemblage.joints.cohesion[k] * length * thickness
        resistance = cohesion + mu * (n_start + n_end)
        apart = [
            _point_velocity(velocities[j], shapes[j].centroid.coords[0], point)
            - _point_velocity(velocities[i], shapes[i].centroid.coords[0], point)
            for point in (start, end)
        ]
        opening, slip = [float(rate @ normal) for rate in apart], float(apart[0] @ tangent)
        stated = [*state.mechanism.opening[k], state.mechanism.slip[k]]
        worst.tension = max(worst.tension, -min(n_start, n_end) / mean)
        worst.excess_shear = max(worst.excess_shear, (abs(shear) - resistance) / mean)
        worst.wrong_rates = max(worst.wrong_rates, *np.abs(np.subtract([*opening, slip], stated)) / largest)
        worst.penetration = max(worst.penetration, -min(opening) / largest)
        worst.backward = max(worst.backward, shear * slip)
        friction_power += resistance * abs(slip)
        for n, gap in ((n_start, opening[0]), (n_end, opening[1])):
            if n > 1e-4 * mean:
                worst.loaded_gap = max(worst.loaded_gap, abs(gap) / largest)
        if min(n_start, n_end) > 1e-3 * mean and resistance - abs(shear) > 1e-3 * mean:
            worst.idle = max(worst.idle, *np.abs([*opening, slip]) / largest)
    size = np.sqrt(sum(shapes[k].area for k in free) / len(free))
    for k, load in loads.items():
        x, y = shapes[k].centroid.coords[0]
        moment = load[2] - x * load[1] + y * load[0]
        worst.unbalanced = max(worst.unbalanced, *np.abs([load[0], load[1], moment / size]) / total)
    live = sum(state.load_multiplier * load_direction * weights[k] * velocities[k][0] for k in free)
    dead = sum(-weights[k] * velocities[k][1] for k in free)
    worst.power, worst.friction_power = (live + dead) / abs(live), friction_power / abs(live)
    worst.backward /= abs(live)
    return worst


def _point_velocity(velocity, centroid, point) -> np.ndarray:
    """Velocity of a point of a rigid block."""
    u, v, omega = velocity
    return np.array([u - omega * (point[1] - centroid[1]), v + omega * (point[0] - centroid[0])])


def with_resultants(name):
    """Eq. (1) again with resultants N, V, M of each joint (|M| <= N length/2), moments about the origin, kN and m.

    Returns equality rows and right side, inequality rows (<= 0); unknowns N, V, M joint by joint, lambda last.
    """
    wall = case(name)
    free = [number for number, block in enumerate(wall.wall.blocks) if not block.fixed]
    shapes = [Polygon(block.polygon) for block in wall.wall.blocks]
    joints = wall.joints.count
    balance, right_side = np.zeros((3 * len(free), 3 * joints + 1)), np.zeros(3 * len(free))
    for row, number in enumerate(free):
        weight = shapes[number].area * wall.wall.thickness * wall.wall.blocks[number].unit_weight / 1e3
        x, y = shapes[number].centroid.coords[0]
        right_side[3 * row : 3 * row + 3] = 0.0, weight, weight * x
        balance[3 * row : 3 * row + 3, -1] = weight, 0.0, -weight * y
    for k in range(joints):
        x, y = wall.joints.centroid[k]
        for number, sign in ((wall.joints.j[k], 1.0), (wall.joints.i[k], -1.0)):
            if number in free:
                rows = slice(3 * free.index(number), 3 * free.index(number) + 3)
                for column, (fx, fy) in enumerate((wall.joints.normal[k], wall.joints.tangent[k])):
                    balance[rows, 3 * k + column] = sign * np.array([fx, fy, x * fy - y * fx])
                balance[rows, 3 * k + 2] = 0.0, 0.0, sign
    yields = np.zeros((4 * joints, 3 * joints + 1))
    for k in range(joints):
        mu, lever = wall.joints.friction[k], wall.joints.length[k] / 2
        yields[4 * k : 4 * k + 4, 3 * k : 3 * k + 3] = [[-mu, 1, 0], [-mu, -1, 0], [-lever, 0, 1], [-lever, 0, -1]]
    return balance, right_side, yields

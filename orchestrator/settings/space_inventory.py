"""What a case in space holds, counted: loads, materials, joints; and what is unusual about it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from math import degrees

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.printed import counted
from orchestrator.masonry.wall import PLAUSIBLE
from orchestrator.settings.inventory import ExtraLoad, LoadSums, Range
from orchestrator.settings.space_case import SpaceCase
from orchestrator.settings.unusual import FRICTION, UNIT_WEIGHT, unusual_loads
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.loads import SpaceDeadLoad, SpaceLoadSettings, angles_of, loads_on
from orchestrator.space.wall import SpaceWall


@dataclass(frozen=True, slots=True)
class SpaceMaterialSums:
    """Blocks of one material: how many, volume (m3), weight (N), and the range of each of their values (SI)."""

    name: str
    blocks: int
    volume: float
    weight: float
    unit_weight: Range
    friction: Range


@dataclass(frozen=True, slots=True)
class SpaceJointSums:
    """Joints between two materials ("support" is one) of the same friction: how many, and their area in m2."""

    between: tuple[str, str]
    joints: int
    area: float
    friction: float


def load_sums(wall: SpaceWall, load: SpaceLoadSettings) -> LoadSums:
    """Return the loads of a case. Raises CaseError (key only)."""
    free = ~wall.fixed
    loads = loads_on(wall, load)
    return LoadSums(
        direction=vector_words(loads.direction),
        distribution=load.distribution,
        weight=float(wall.weights[free].sum()),
        extra=tuple(_extra(wall, load, one) for one in load.dead),
        vertical_load=-float((loads.dead[free, :3] @ wall.up).sum()),
        horizontal_load=loads.base_shear(wall.up),
        upright_load=loads.upright(wall.up),
    )


def vector_words(vector: Iterable[float]) -> str:
    """Return a unit vector (3,) as it is told."""
    return f"({', '.join(f'{round(x, 4) + 0.0:g}' for x in vector)})"


def direction_words(direction: FloatArray, up: FloatArray) -> str:
    """Return the direction of a load: unit vector (3,), and in degrees its angle in plan and above the horizontal."""
    plan, rise = angles_of(direction, up)
    said = [vector_words(direction)]
    if plan is None:
        return f"{said[0]}, {'up' if rise > 0 else 'down'}wards"
    said.append(f"{round(degrees(plan), 2) + 0.0:g} degrees in plan")
    if above := round(degrees(rise), 2):
        said.append(f"{above:g} degrees above the horizontal")
    return ", ".join(said)


def _extra(wall: SpaceWall, load: SpaceLoadSettings, one: SpaceDeadLoad) -> ExtraLoad:
    placed = loads_on(wall, replace(load, dead=(one,))).dead - loads_on(wall, replace(load, dead=())).dead
    sizes = np.linalg.norm(placed[:, :3], axis=1)
    size = f"{one.line_load / 1e3:g} kN/m" if one.line_load is not None else f"{(one.force or 0.0) / 1e3:g} kN"
    size += " each" * (one.force is not None and np.count_nonzero(sizes) > 1)
    ids = ", ".join(map(str, one.blocks[:4])) + ", ..." * (len(one.blocks) > 4)
    place = f"level {one.level:g} m" if one.level is not None else f"block{'s' * (len(one.blocks) > 1)} {ids}"
    along = f", along ({', '.join(f'{x:g}' for x in one.direction)})" if one.direction else ""
    return ExtraLoad(f"{size} on {place}{along}", int(np.count_nonzero(sizes)), float(sizes.sum()), one.inertia)


def materials(wall: SpaceWall) -> list[SpaceMaterialSums]:
    """Return the materials of the blocks that can move, the one of most blocks first."""
    members: dict[str, list[int]] = defaultdict(list)
    for position, block in enumerate(wall.blocks):
        if not block.fixed:
            members[block.material].append(position)
    weights = wall.weights
    sums = []
    for name, inside in members.items():
        unit_weight = np.array([wall.blocks[k].unit_weight for k in inside])
        friction = [wall.friction if (own := wall.blocks[k].friction) is None else own for k in inside]
        sums.append(
            SpaceMaterialSums(
                name=name,
                blocks=len(inside),
                volume=float((weights[inside] / unit_weight).sum()),
                weight=float(weights[inside].sum()),
                unit_weight=(float(unit_weight.min()), float(unit_weight.max())),
                friction=(min(friction), max(friction)),
            )
        )
    return sorted(sums, key=lambda material: (-material.blocks, material.name))


def joint_classes(assemblage: SpaceAssemblage) -> list[SpaceJointSums]:
    """Return the joints, ties left out, by the two materials that meet and by friction, those of most area first."""
    joints, blocks = assemblage.joints, assemblage.wall.blocks
    members: dict[tuple[tuple[str, str], float], list[int]] = defaultdict(list)
    names = ["support" if block.fixed else block.material or "block" for block in blocks]
    for k in np.flatnonzero(~joints.is_tie).tolist():
        one, other = sorted((names[joints.i[k]], names[joints.j[k]]))
        members[(one, other), float(f"{joints.friction[k]:.3g}")].append(k)
    classes = [
        SpaceJointSums(between, len(inside), float(joints.area[inside].sum()), friction)
        for (between, friction), inside in members.items()
    ]
    return sorted(classes, key=lambda one: (-one.area, one.between))


def unusual(
    loads: LoadSums, sums: list[SpaceMaterialSums], classes: list[SpaceJointSums], case: SpaceCase
) -> list[str]:
    """Return what is unusual about a case in space, in sentences that begin with UNUSUAL."""
    return list(dict.fromkeys([*_of_values(sums, classes), *_of_size(case.wall), *unusual_loads(loads)]))


def _of_values(sums: list[SpaceMaterialSums], classes: list[SpaceJointSums]) -> Iterator[str]:
    for one in sums:
        name = f"unit weight of {one.name}" if one.name else "unit weight"
        yield from filter(None, (UNIT_WEIGHT.complaint(name, value) for value in dict.fromkeys(one.unit_weight)))
    for value in dict.fromkeys(one.friction for one in classes):
        count = sum(one.joints for one in classes if one.friction == value)
        yield from filter(None, [FRICTION.complaint(f"friction of {counted(count, 'joint')}", value)])


def _of_size(wall: SpaceWall) -> Iterator[str]:
    corners = np.concatenate([block.shape.vertices for block in wall.blocks if not block.fixed])
    size = float(np.ptp(corners, axis=0).max())
    low, high = PLAUSIBLE
    if not low <= size <= high:
        yield f"UNUSUAL: the wall is {size:.3g} m large, usual are {low:g} to {high:g} m; is its unit of length right?"

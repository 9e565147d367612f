"""What a case holds, counted: loads with their resultants, materials and classes of joints with all their values.

Weights are sums over the blocks that can move. The base shear at a load multiplier of 1 is the horizontal resultant of
the live load: every base shear of this program is the load multiplier times it.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from math import dist, inf, isinf

import numpy as np

from orchestrator.assessment.seismic.control import candidates, named_point
from orchestrator.assessment.seismic.settings import limit_states
from orchestrator.basis.arrays import FloatArray
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.loads.block_loads import LiveLoad, upright_resultant
from orchestrator.loads.dead_loads import DeadLoad, extra_dead_loads
from orchestrator.masonry.block_properties import block_areas, block_weights
from orchestrator.masonry.interfaces import Interfaces
from orchestrator.masonry.joints import Assemblage, is_bed
from orchestrator.masonry.wall import Block, Wall
from orchestrator.settings.case import Case

Range = tuple[float, float]
"""lowest and highest value"""


@dataclass(frozen=True, slots=True)
class ExtraLoad:
    """One extra dead load, or one live load on named blocks: what it is, on how many blocks, resultant in N (of a live
    load along its direction), and whether the live load acts on it too."""

    name: str
    blocks: int
    resultant: float
    inertia: bool


@dataclass(frozen=True, slots=True)
class LoadSums:
    """Loads of one load case in N. weight: of the blocks; vertical_load: with the extra loads; horizontal_load: at a
    load multiplier of 1; upright_load: the live load then, upwards, where none of it is horizontal;
    live: what it is made of, where it is given on named blocks."""

    direction: str
    distribution: str
    weight: float
    extra: tuple[ExtraLoad, ...]
    vertical_load: float
    horizontal_load: float
    upright_load: float | None = None
    live: tuple[ExtraLoad, ...] = ()


@dataclass(frozen=True, slots=True)
class MaterialSums:
    """Blocks of one material: how many, area (m2), weight (N), and the range of each of their values (SI)."""

    name: str
    blocks: int
    area: float
    weight: float
    unit_weight: Range
    thickness: Range
    friction: Range
    elastic_modulus: Range
    poisson_ratio: Range


@dataclass(frozen=True, slots=True)
class JointSums:
    """Joints between two materials ("support" is one) that have the same values to three significant digits: how many,
    total length (m), the range of their stiffness (drawn joints of mortar may have as many thicknesses as joints)."""

    between: tuple[str, str]
    orientation: str
    joints: int
    length: float
    friction: float
    cohesion: float
    tensile_strength: float
    compressive_strength: float
    normal_stiffness: Range
    shear_stiffness: Range


def load_sums(wall: Wall, load: LoadSettings) -> LoadSums:
    """Return the loads of one load case. Raises CaseError (key only)."""
    free = np.array([not block.fixed for block in wall.blocks])
    loads = loads_on(wall, load)
    return LoadSums(
        direction=load.direction,
        distribution=load.distribution,
        weight=float(block_weights(wall)[free].sum()),
        extra=tuple(_extra(wall, one) for one in load.dead),
        vertical_load=-float(loads.dead[free, 1].sum()),
        horizontal_load=abs(float(loads.live[free, 0].sum())),
        upright_load=upright_resultant(loads.live),
        live=tuple(_live(one) for one in load.live),
    )


def _live(load: LiveLoad) -> ExtraLoad:
    blocks = len(load.blocks)
    name = f"{load.force / 1e3:.4g} kN{' each' * (blocks > 1)} on {_numbers(load.blocks)}"
    return ExtraLoad(name, blocks, blocks * load.force, False)


def _numbers(blocks: tuple[int, ...]) -> str:
    """Return "block 7", or "blocks 1, 2, 3, 4, ..."."""
    return f"block{'s' * (len(blocks) > 1)} {', '.join(map(str, blocks[:4]))}{', ...' * (len(blocks) > 4)}"


def _extra(wall: Wall, load: DeadLoad) -> ExtraLoad:
    placed = extra_dead_loads(wall, (load,))
    size = f"{load.line_load / 1e3:g} kN/m" if load.line_load is not None else f"{(load.force or 0.0) / 1e3:g} kN"
    size += " each" * (len(load.blocks) > 1 and load.force is not None)
    place = f"level {load.level:g} m" if load.level is not None else _numbers(load.blocks)
    if load.stretch:
        place += f", x = {load.stretch[0]:g} to {load.stretch[1]:g} m"
    if load.at:
        place += f" at ({load.at[0]:g}, {load.at[1]:g}) m"
    return ExtraLoad(f"{size} on {place}", len(np.unique(placed.block)), float(placed.size.sum()), load.inertia)


def materials(case: Case, wall: Wall) -> list[MaterialSums]:
    """Return the materials of the blocks that can move, the one of most blocks first."""
    area, weight = block_areas(wall), block_weights(wall)
    members: dict[str, list[int]] = defaultdict(list)
    for position, block in enumerate(wall.blocks):
        if not block.fixed:
            members[block.material].append(position)
    sums = [
        MaterialSums(
            name=name,
            blocks=len(inside),
            area=float(area[inside].sum()),
            weight=float(weight[inside].sum()),
            unit_weight=_range(wall, inside, "unit_weight", 0.0),
            thickness=_range(wall, inside, "thickness", wall.thickness),
            friction=_range(wall, inside, "friction", wall.friction),
            elastic_modulus=_range(wall, inside, "elastic_modulus", case.elastic.elastic_modulus),
            poisson_ratio=_range(wall, inside, "poisson_ratio", case.elastic.poisson_ratio),
        )
        for name, inside in members.items()
    ]
    return sorted(sums, key=lambda material: (-material.blocks, material.name))


def _range(wall: Wall, positions: list[int], name: str, otherwise: float) -> Range:
    of_blocks = [getattr(wall.blocks[position], name) for position in positions]
    values = [otherwise if value is None else value for value in of_blocks]
    return min(values), max(values)


def joint_classes(assemblage: Assemblage) -> list[JointSums]:
    """Return the joints by the two materials that meet and by their values, those of most length first."""
    return sorted(_grouped(assemblage).values(), key=lambda one: (-one.length, one.between))


def class_of_joint(assemblage: Assemblage) -> list[JointSums]:
    """Return for each joint (k,) the class that it is of."""
    of_key = _grouped(assemblage)
    return [of_key[key] for key in _keys(assemblage)]


def class_words(assemblage: Assemblage) -> list[str]:
    """Return for each joint (k,) its class in words, for a legend; none where the values of all are alike."""
    classes = class_of_joint(assemblage)
    if len({value_words(one) for one in classes}) < 2:
        return []
    return [f"{one.between[0]}-{one.between[1]}: {value_words(one)}" for one in classes]


def value_words(one: JointSums) -> str:
    """Return the values of a class of joints in a few words, for a legend."""
    strengths = (("c", one.cohesion), ("ft", one.tensile_strength), ("fc", one.compressive_strength))
    strengths_said = [f"{name} {in_megapascals(value)} MPa" for name, value in strengths if 0.0 < value < inf]
    stiffness = (("kn", one.normal_stiffness), ("ks", one.shear_stiffness))
    strengths_said += [f"{name} {stiffness_words(values)} N/mm3" for name, values in stiffness if values[0] < inf]
    return ", ".join([f"μ {one.friction:.4g}", *strengths_said])


def in_megapascals(strength: float) -> str:
    """Return a strength (Pa) in MPa; none where there is none, or no bound."""
    return "none" if strength in (0.0, inf) else f"{strength / 1e6:.4g}"


def stiffness_words(values: Range) -> str:
    """Return a range of stiffness (N/m3) in N/mm3."""
    return "rigid" if values[0] == inf else between(values, 1e-9, 3)


def between(values: Range, factor: float = 1.0, digits: int = 4) -> str:
    """Return a range, one value where both are printed alike."""
    low, high = (f"{factor * value:.{digits}g}" for value in values)
    return low if low == high else f"{low} to {high}"


STRENGTHS = "friction", "cohesion", "tensile_strength", "compressive_strength"
"""fields of Interfaces by which joints are classed"""
STIFFNESS = "normal_stiffness", "shear_stiffness"
"""fields of Interfaces that join a class where there are few values"""
MANY = 4
"""stiffnesses of joints that are alike but for them; more become one class of each orientation, with their range"""
Alike = tuple[tuple[str, str], tuple[float, ...], tuple[bool, ...]]
"""the materials, their strengths to three digits, and whether a joint is rigid along normal and shear"""
Key = tuple[tuple[str, str], tuple[float, ...], tuple[float, ...] | str]
"""materials, strengths to three digits, and stiffness likewise, or the orientation where that is a range"""


def _grouped(assemblage: Assemblage) -> dict[Key, JointSums]:
    joints = assemblage.joints
    members: dict[Key, list[int]] = defaultdict(list)
    oriented = np.where(is_bed(joints), "bed", "head")
    for k, key in enumerate(_keys(assemblage)):
        members[key].append(k)
    return {
        key: JointSums(
            between=key[0],
            orientation=" and ".join(np.unique(oriented[inside])),
            joints=len(inside),
            length=float(joints.length[inside].sum()),
            friction=float(joints.friction[inside[0]]),
            cohesion=float(joints.cohesion[inside[0]]),
            tensile_strength=float(joints.tensile_strength[inside[0]]),
            compressive_strength=float(joints.compressive_strength[inside[0]]),
            normal_stiffness=_extremes(joints.normal_stiffness[inside]),
            shear_stiffness=_extremes(joints.shear_stiffness[inside]),
        )
        for key, inside in members.items()
    }


def _extremes(values: FloatArray) -> Range:
    return float(values.min()), float(values.max())


def _keys(assemblage: Assemblage) -> list[Key]:
    """Return for each joint (k,) what makes its class."""
    blocks, joints = assemblage.wall.blocks, assemblage.joints
    oriented = np.where(is_bed(joints), "bed", "head")
    strengths = [_rounded(joints, k, STRENGTHS) for k in range(joints.count)]
    stiffness = [_rounded(joints, k, STIFFNESS) for k in range(joints.count)]
    alike: list[Alike] = []
    stiffnesses: dict[Alike, set[tuple[float, ...]]] = defaultdict(set)
    for (i, j), strong, stiff in zip(joints.pairs, strengths, stiffness, strict=True):
        one, other = sorted((_named(blocks[i]), _named(blocks[j])))
        alike.append(((one, other), strong, tuple(map(isinf, stiff))))
        stiffnesses[alike[-1]].add(stiff)
    return [
        (*like[:2], stiff if len(stiffnesses[like]) <= MANY else f"{oriented[k]} {like[2]}")
        for k, (like, stiff) in enumerate(zip(alike, stiffness, strict=True))
    ]


def _rounded(joints: Interfaces, joint: int, names: tuple[str, ...]) -> tuple[float, ...]:
    return tuple(float(f"{getattr(joints, name)[joint]:.3g}") for name in names)


def _named(block: Block) -> str:
    return "support" if block.fixed else block.material or "block"


def control_words(case: Case, assemblage: Assemblage) -> list[str]:
    """Return, in words, where the abscissa of the curves is measured, and that of N2 where a verification is asked."""
    top = max(float(block.polygon[:, 1].max()) for block in assemblage.wall.blocks if not block.fixed)
    said = [f"control displacement of the curves: mean of the top edge, y = {top:.4g} m"]
    if limit_states(case.seismic):
        named = named_point(case.seismic, assemblage.wall)
        places = "; ".join(point.name for point in candidates(assemblage, case.load))
        name = named.name if named else f"what moves most in the mechanism, of: {places}"
        said.append(f"control point of N2: {name}")
    return said


def tie_words(case: Case) -> list[str]:
    """Return every tie in words."""
    said = []
    for number, tie in enumerate(case.reinforcement.ties, 1):
        x, y = tie.end
        other = f"block {tie.blocks[1]}" if len(tie.blocks) > 1 else f"an anchor at ({x:g}, {y:g}) m"
        long = f"{dist(tie.start, tie.end):.4g} m long, yields at {tie.strength / 1e3:.3f} kN"
        long += "" if tie.stiffness is None else f", stiffness {tie.stiffness / 1e6:.4g} kN/mm"
        long += f", pretension {tie.pretension / 1e3:.3f} kN" if tie.pretension else ""
        long += ", pushes too" if tie.pushes else ""
        said.append(f"tie {number}: block {tie.blocks[0]} to {other}, {long}")
    return said

"""Joints: the straight edges of the planar map that two blocks share."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
import shapely
from annotated_types import Ge, Gt, Le

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, fingerprint, read_only
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError, require_kinds
from orchestrator.basis.printed import as_place, millimetres
from orchestrator.basis.units import Unit
from orchestrator.geometry.healing import VISIBLE
from orchestrator.geometry.planar_map import NO_BLOCK, OverlapError, PlanarMap, planar_map
from orchestrator.masonry.block_properties import (
    block_areas,
    fingerprint_of_blocks,
    outlines_of,
    refuse_beyond_weight,
    rounded_up,
    thinner,
    weights_that_move,
)
from orchestrator.masonry.interfaces import STRENGTHS, Interfaces, straight_interfaces
from orchestrator.masonry.wall import (
    LARGEST_MORTAR,
    LARGEST_TOLERANCE,
    ROUNDING,
    Friction,
    Wall,
    check_wall,
    doubted_size,
    rounding_of,
)

SHORTEST = 100.0 * ROUNDING
"""part of the smaller stone's size (root of its area) that a joint is long: where ends may lie off by the rounding of a
drawing, a shorter one has a direction that is not known to 0.01 rad"""
AS_STEEP = 1e-3
"""part by which a joint may rise more than it goes across and be as near to the horizontal as to the vertical"""


@dataclass(frozen=True, slots=True)
class JointClass(Checked):
    """Joints of one kind and what they can carry; a value that is left out stays as it was."""

    orientation: Literal["any", "bed", "head"] = "any"
    """bed joints are nearer to the horizontal, head joints to the vertical; at 45 degrees joints are bed joints"""
    between: tuple[str, ...] = ()
    """the two materials that meet, in either order (materials are those of the block file); none: all"""
    friction: Friction | None = None
    """coefficient of friction"""
    cohesion: Annotated[float, Ge(0), Unit("Pa")] | None = None
    """shear strength without normal force, over the whole joint"""
    tensile_strength: Annotated[float, Ge(0), Unit("Pa")] | None = None
    """over the whole joint; Coulomb's cone ends at cohesion / friction where that is less. Plastic in limit analysis,
    softening in the FE pushover, as cohesion (contact.softening_displacement)"""
    compressive_strength: Annotated[float, Gt(0), Unit("Pa")] | None = None
    """of a rectangular stress block; none: no crushing"""
    normal_stiffness: Annotated[float, Gt(0), Unit("N/m3")] | None = None
    """pressure over what the joint closes, in the FE pushover and on the path of loading; none: rigid"""
    shear_stiffness: Annotated[float, Gt(0), Unit("N/m3")] | None = None
    """shear stress over slip while the joint sticks, in the FE pushover alone; none: contact.slip_tolerance"""
    mortar_modulus: Annotated[float, Gt(0), Unit("Pa")] | None = None
    """instead of normal_stiffness: Young's modulus of the mortar, divided by mortar_thickness"""
    mortar_shear_modulus: Annotated[float, Gt(0), Unit("Pa")] | None = None
    """instead of shear_stiffness: shear modulus of the mortar, divided by mortar_thickness"""
    mortar_thickness: Annotated[float, Gt(0), Unit("m")] | None = None
    """of the joint, beside a modulus of its mortar; none: as drawn (block file), where the joint was drawn as a gap"""


MODULI = {"mortar_modulus": "normal_stiffness", "mortar_shear_modulus": "shear_stiffness"}
"""of the mortar of a joint class, and what they give"""
NO_MODULUS = "is read beside mortar_modulus or mortar_shear_modulus alone"


@dataclass(frozen=True, slots=True)
class JointSettings(Checked):
    """How near two edges must lie to share a joint; what joints can carry besides the wall's friction."""

    tolerance: Annotated[float, Gt(0), Le(0.01), Unit("m")] | None = None
    """largest distance over which outlines are joined: corners that become one vertex, vertices beside an edge; also
    the overlap of two blocks that passes as rounding; none: 1/40000 of a stone's size (root of the median area)"""
    minimum_length: Annotated[float, Gt(0), Unit("m")] | None = None
    """shorter shared segments are no joint; none: 1/400 of the smaller stone's size (root of its area)"""
    classes: tuple[JointClass, ...] = ()
    """applied one after the other: of those that fit a joint, the last that gives a value counts"""


@dataclass(frozen=True, eq=False, slots=True)
class Assemblage:
    """A wall and its k joints. outlines: the planar map of the wall; edge (k,): the edge of it that each joint is
    (neither is needed for limit analysis)."""

    wall: Wall
    joints: Interfaces
    outlines: PlanarMap | None = None
    edge: IntArray | None = None


def find_joints(wall: Wall, settings: JointSettings) -> Assemblage:
    """Return the assemblage of `wall`: every edge of its planar map that has a block on both sides is a joint.

    Joints are sorted by block i, block j and position along block i's outline; two supports have none. Raises CaseError
    for what is no wall (`check_wall`).
    """
    remedy = "write find_joints(wall, JointSettings()), with a wall as read_blocks(path) returns it"
    require_kinds(remedy, wall=(wall, Wall), settings=(settings, JointSettings))
    check_wall(wall, settings.tolerance)
    try:
        outlines = planar_map([block.polygon for block in wall.blocks], joined_over(wall, settings))
    except OverlapError as error:
        one, other = (wall.blocks[block].id for block in error.blocks)
        problem = f"lies on block {other} near {as_place(error.point[0], error.point[1])} m"
        raise CaseError(f"block {one}", problem, "move one of them or correct its polygon") from None
    edge, _ = contacts_of(wall, outlines, settings)
    pair = outlines.left[edge], outlines.right[edge]
    friction = np.array([wall.friction if block.friction is None else block.friction for block in wall.blocks])
    ends = outlines.vertex[outlines.start[edge]], outlines.vertex[outlines.end[edge]]
    joints = straight_interfaces(*pair, *ends, thinner(wall, *pair), np.minimum(*(friction[side] for side in pair)))
    assemblage = Assemblage(_with_outlines(wall, outlines), joints, outlines, read_only(edge, np.int64))
    for number, joint_class in enumerate(settings.classes):
        assemblage = with_class(assemblage, joint_class, f"joints.classes.{number}")
    return replace(assemblage, joints=_within_cone(assemblage.joints))


def _within_cone(joints: Interfaces) -> Interfaces:
    """Return joints that open where Coulomb's cone ends, at cohesion over friction, if their bond is stronger."""
    friction = joints.friction
    ends = np.divide(joints.cohesion, friction, out=np.full(joints.count, np.inf), where=friction > 0.0)
    return replace(joints, tensile_strength=read_only(np.minimum(joints.tensile_strength, ends)))


def _with_outlines(wall: Wall, outlines: PlanarMap) -> Wall:
    """Return the wall with the outlines of its planar map; the same wall where nothing was joined over a distance."""
    if outlines.error == 0.0:
        return wall
    polygons = [read_only(outlines.vertex[outlines.ring(number)]) for number in range(len(wall.blocks))]
    blocks = [replace(block, polygon=polygon) for block, polygon in zip(wall.blocks, polygons, strict=True)]
    return replace(wall, blocks=tuple(blocks))


def joined_over(wall: Wall, settings: JointSettings) -> float:
    """Return the largest distance (m) over which outlines are joined where joints are found."""
    return rounding_of(wall) if settings.tolerance is None else settings.tolerance


def contacts_of(wall: Wall, outlines: PlanarMap, settings: JointSettings) -> tuple[IntArray, IntArray]:
    """Return the edges (k,) that are joints, in their order, and those between two blocks too short for one."""
    edge = outlines.ring_edge[outlines.ring_forward]  # along the outline of the left block, which is block i
    edge = edge[outlines.right[edge] != NO_BLOCK]
    i, j = outlines.left[edge], outlines.right[edge]
    fixed, size = np.array([block.fixed for block in wall.blocks]), np.sqrt(block_areas(wall))
    length = np.linalg.norm(outlines.vertex[outlines.end[edge]] - outlines.vertex[outlines.start[edge]], axis=1)
    shortest = SHORTEST * np.minimum(size[i], size[j]) if settings.minimum_length is None else settings.minimum_length
    order = np.lexsort((np.arange(len(edge)), j, i))
    contact, long = ~(fixed[i] & fixed[j])[order], (length > shortest)[order]
    return edge[order][contact & long], edge[order][contact & ~long]


def with_class(assemblage: Assemblage, joint_class: JointClass, key: str) -> Assemblage:
    """Return the assemblage with the values of a joint class in the joints that fit it. Raises CaseError for `key`."""
    material = np.array([block.material for block in assemblage.wall.blocks])
    known = sorted({*material.tolist()} - {""})
    if joint_class.between and (len(joint_class.between) != 2 or not {*joint_class.between} <= {*known}):
        listed = ", ".join(known) or 'none yet: give blocks a "material" in the block file'
        raise CaseError(
            f"{key}.between", f"{list(joint_class.between)} are not two materials", f"materials are {listed}"
        )
    if joint_class.mortar_thickness is not None and not values_of(joint_class) & MODULI.keys():
        raise CaseError(f"{key}.mortar_thickness", NO_MODULUS, "give one of the two, or leave it out")
    joints, fits = assemblage.joints, fitting(assemblage, joint_class)
    for name in ("cohesion", "tensile_strength"):
        force = (getattr(joint_class, name) or 0.0) * float(joints.area[fits].max(initial=0.0))
        refuse_beyond_weight(weights_that_move(assemblage.wall), force, f"{key}.{name}")

    def changed(value: float | FloatArray | None, before: FloatArray) -> FloatArray:
        return before if value is None else read_only(np.where(fits, value, before))

    joints = replace(
        joints,
        friction=changed(joint_class.friction, joints.friction),
        cohesion=changed(joint_class.cohesion, joints.cohesion),
        tensile_strength=changed(joint_class.tensile_strength, joints.tensile_strength),
        compressive_strength=changed(joint_class.compressive_strength, joints.compressive_strength),
        normal_stiffness=changed(_stiffness(assemblage, joint_class, fits, key, "normal"), joints.normal_stiffness),
        shear_stiffness=changed(_stiffness(assemblage, joint_class, fits, key, "shear"), joints.shear_stiffness),
    )
    return replace(assemblage, joints=joints)


def fitting(assemblage: Assemblage, joint_class: JointClass) -> BoolArray:
    """Return which joints (k,) a class fits."""
    joints = assemblage.joints
    if joint_class.orientation == "any":
        fits = np.ones(joints.count, np.bool_)
    else:
        fits = is_bed(joints) == (joint_class.orientation == "bed")
    if not joint_class.between:
        return fits
    material = np.array([block.material for block in assemblage.wall.blocks])
    one, other = joint_class.between
    i, j = material[joints.i], material[joints.j]
    return fits & (((i == one) & (j == other)) | ((i == other) & (j == one)))


def is_bed(joints: Interfaces) -> BoolArray:
    """Return which joints (k,) are nearer to the horizontal, or as near to it as to the vertical but for AS_STEEP."""
    across, up = np.abs(joints.end - joints.start).T
    return across > (1.0 - AS_STEEP) * up


def values_of(joint_class: JointClass) -> dict[str, float]:
    """Return the values that a class gives, by their keys."""
    names = [one.name for one in fields(joint_class) if one.name not in ("orientation", "between")]
    return {name: value for name in names if (value := getattr(joint_class, name)) is not None}


def _stiffness(
    assemblage: Assemblage,
    joint_class: JointClass,
    fits: BoolArray,
    key: str,
    which: Literal["normal", "shear"],
) -> float | FloatArray | None:
    """Return the stiffness in N/m3 that a class gives the joints (k,) that it fits, None where it gives none.

    Raises CaseError for `key` where it is given twice, or the thickness of mortar is not known.
    """
    name = f"{which}_stiffness"
    modulus_name = next(modulus for modulus, gives in MODULI.items() if gives == name)
    stiffness, modulus = getattr(joint_class, name), getattr(joint_class, modulus_name)
    if modulus is None:
        return stiffness
    if stiffness is not None:
        raise CaseError(f"{key}.{name}", f"is given by {modulus_name} too", "give one of the two")
    if joint_class.mortar_thickness is not None:
        return modulus / joint_class.mortar_thickness
    drawn = {(mortar.i, mortar.j): mortar.thickness for mortar in assemblage.wall.mortar}
    ids = [block.id for block in assemblage.wall.blocks]
    between = ((ids[i], ids[j]) for i, j in assemblage.joints.pairs)
    thickness = np.array([drawn.get((min(pair), max(pair)), np.nan) for pair in between])
    if (unknown := np.isnan(thickness) & fits).any():
        problem = f"the thickness of {np.count_nonzero(unknown)} of {np.count_nonzero(fits)} joints is not known"
        raise CaseError(f"{key}.mortar_thickness", problem, 'give it, as in "10 mm"')
    return np.divide(modulus, thickness, out=np.full(len(thickness), np.inf), where=fits)


@lru_cache(maxsize=4)
def fingerprint_of_wall(assemblage: Assemblage) -> str:
    """Return a text that only walls with the same blocks (`fingerprint_of_blocks`) and joints have, friction, strengths
    and stiffness of the joints too."""
    joints = assemblage.joints
    has = (getattr(joints, name) for name in STRENGTHS)
    return fingerprint(
        [fingerprint_of_blocks(assemblage.wall)], joints.i, joints.j, joints.point, joints.area, joints.friction, *has
    )


@lru_cache(maxsize=4)
def fingerprint_of_places(assemblage: Assemblage) -> str:
    """Return a text that only walls with the same ids and outlines of blocks, and joints of the same ones, have."""
    outlines = outlines_of(assemblage.wall)
    ids = [block.id for block in assemblage.wall.blocks]
    return fingerprint(ids, outlines.corner, outlines.first, assemblage.joints.i, assemblage.joints.j)


def blocks_without_support(assemblage: Assemblage) -> IntArray:
    """Return the blocks that no chain of joints connects to a support."""
    fixed = np.array([block.fixed for block in assemblage.wall.blocks])
    group = assemblage.joints.groups(len(fixed))
    return np.flatnonzero(~np.isin(group, group[fixed]))


def check_assemblage(assemblage: Assemblage) -> None:
    """Raise CaseError for a block that no chain of joints connects to a support, and say how far its neighbours are."""
    require_kinds("write check_assemblage(find_joints(wall, settings))", assemblage=(assemblage, Assemblage))
    blocks, apart = assemblage.wall.blocks, blocks_without_support(assemblage)
    if not len(apart):
        return
    group = assemblage.joints.groups(len(blocks))
    touching = {*assemblage.joints.i.tolist(), *assemblage.joints.j.tolist()}
    first = int(apart[0])
    problem = "is not connected to any support" if first in touching else "touches no other block"
    outlines = shapely.polygons([shapely.linearrings(block.polygon) for block in blocks])
    x, y = blocks[first].polygon.mean(axis=0)
    widest = 0.0
    for number in dict.fromkeys(group[apart].tolist()):
        others = outlines[group != number]
        nearest = float(shapely.distance(outlines[group == number][:, None], others).min()) if len(others) else np.inf
        widest = max(widest, nearest)
        if number == group[first]:
            problem += f": at {as_place(x, y)} m, "
            problem += f"{millimetres(nearest)} from the nearest" if nearest else "with a neighbour in a point at most"
    free = sum(not block.fixed for block in blocks)
    problem += f"; {len(apart)} of {free} blocks alike" if len(apart) > 1 else ""
    remedy = "move it until it shares a joint, or remove it"
    if 0 < widest < VISIBLE * np.sqrt(outlines[first].area):
        wide, largest = rounded_up(1e3 * widest), {"--tolerance": LARGEST_TOLERANCE, "--mortar": LARGEST_MORTAR}
        named = [f'{option} "{wide:g} mm"' for option, most in largest.items() if wide <= 1e3 * most]
        remedy = f"close such gaps: import the file with {', or '.join(named)}" if named else remedy
    raise CaseError(f"block {blocks[first].id}", problem, doubted_size(assemblage.wall) or remedy)

"""Section forces of piers and spandrels and reactions of supports, from the forces in the joints and in ties.

    F_i on j = (n_start + n_end) normal + s tangent       of every joint (limit_analysis/paper/equilibrium.py)
    N, V     of a pier: vertical, horizontal force of what is above on what is below; of a spandrel: horizontal,
             vertical force of what is right on what is left. N is positive in compression, V along +x, +y
    M        moment of the same forces about the middle of the section, counter-clockwise
    R        of a support: force that it exerts on the wall, and its moment about the middle of the support's joints

A section cuts joints, not stones: it is stepped where the bond is, and in exact balance with the loads beyond it. A
tie across it has a row of its own, and so has the reaction of an anchor or of a support at the end of a tie: piers and
spandrels carry what their joints do. Both are given where the tie runs, and so without moment.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orchestrator.assessment.panels import Panel, Section, beyond_line, cut, in_storeys, piers, spandrels
from orchestrator.assessment.tie_forces import TieForce
from orchestrator.basis.arrays import FloatArray
from orchestrator.geometry.rigid import cross
from orchestrator.masonry.joints import Assemblage


@dataclass(frozen=True, slots=True)
class SectionForce:
    """panel, and which of its sections (foot, middle, head; middle of a spandrel); x, y of its middle in m; N, V in N,
    M in N m; the panel's depth in m, 0 for a tie across the sections of all piers of a storey, or of a spandrel."""

    panel: str
    section: str
    x: float
    y: float
    normal: float
    shear: float
    moment: float
    depth: float


@dataclass(frozen=True, slots=True)
class Reaction:
    """Force (N) and moment (N m) that a support, named by its id, or the held end of a tie exerts on the wall; x, y in
    m where it acts on."""

    support: str
    x: float
    y: float
    horizontal: float
    vertical: float
    moment: float


def forces_on_j(assemblage: Assemblage, joint_forces: FloatArray) -> FloatArray:
    """Return the forces (k, 2) in N that block i exerts on block j in every joint; joint_forces (k, 3) in N."""
    normal = joint_forces[:, :2].sum(axis=1)[:, None]
    return np.asarray(normal * assemblage.joints.normal + joint_forces[:, 2:] * assemblage.joints.tangent)


def moments_on_j(assemblage: Assemblage, joint_forces: FloatArray, about: FloatArray) -> FloatArray:
    """Return the moments (k,) in N m of the same forces about a point (2,)."""
    at_start, at_end, along = (
        cross(point - about, size[:, None] * direction)
        for (point, direction), size in zip(assemblage.joints.acting, joint_forces.T, strict=True)
    )
    return at_start + at_end + along


def section_forces(
    assemblage: Assemblage, joint_forces: FloatArray, ties: Sequence[TieForce] = ()
) -> tuple[SectionForce, ...]:
    """Return N, V, M of every pier at foot, middle and head and of every spandrel in its middle, and what ties carry
    across the same sections.

    joint_forces (k, 3) in N, of the joints of the assemblage, which has no ties among them.
    """
    forces = []
    on_j = forces_on_j(assemblage, joint_forces)
    for row in in_storeys(piers(assemblage.wall)):
        heights = {"foot": row[0].bottom, "middle": 0.5 * (row[0].bottom + row[0].top), "head": row[0].top}
        forces += [
            _of(assemblage, joint_forces, on_j, cut(assemblage, pier, at), name)
            for pier in row
            for name, at in heights.items()
        ]
        named = f"piers {row[0].name.removeprefix('pier ').partition('.')[0]}"
        for name, at in heights.items():
            forces += _of_ties(assemblage, ties, row[0], at, named, name)
    not_held = [tie for tie in ties if tie.held is None]
    for spandrel in spandrels(assemblage.wall):
        at = 0.5 * (spandrel.left + spandrel.right)
        forces.append(_of(assemblage, joint_forces, on_j, cut(assemblage, spandrel, at), "middle"))
        forces += _of_ties(assemblage, not_held, spandrel, at, spandrel.name, "middle")
    return tuple(forces)


def _of(
    assemblage: Assemblage, joint_forces: FloatArray, on_j: FloatArray, section: Section, name: str
) -> SectionForce:
    """Return the forces of what is beyond a section on what is before it."""
    force = -(section.sign[:, None] * on_j[section.joints]).sum(axis=0)
    moment = -float(section.sign @ moments_on_j(assemblage, joint_forces, section.centre)[section.joints])
    normal, shear = (-force[0], force[1]) if section.panel.horizontal else (-force[1], force[0])
    x, y = section.centre.tolist()
    return SectionForce(section.panel.name, name, x, y, float(normal), float(shear), moment, section.panel.depth)


def _of_ties(
    assemblage: Assemblage, ties: Sequence[TieForce], panel: Panel, at: float, panels: str, section: str
) -> list[SectionForce]:
    """Return what ties carry across the cut of a panel at `at`: of a spandrel those that are nearest to it, of a pier
    all, as they cross its storey; panels: what they cross the cut with."""
    axis = 0 if panel.horizontal else 1
    beyond = beyond_line(assemblage.wall, axis, at)
    forces = []
    for tie in ties:
        found = tie.crossing(beyond, axis, at)
        if found is None or (panel.horizontal and not panel.owns(found[1][1:])[0]):
            continue
        force, (x, y) = found
        normal, shear = 0.0 - force[axis], force[1 - axis]
        name = f"tie {tie.number} with {panels}"
        forces.append(SectionForce(name, section, float(x), float(y), float(normal), float(shear), 0.0, 0.0))
    return forces


def reactions(assemblage: Assemblage, joint_forces: FloatArray, ties: Sequence[TieForce] = ()) -> tuple[Reaction, ...]:
    """Return what every support that carries anything exerts on the wall, by its joints, and then what every tie does
    that an anchor or a support holds."""
    on_j, between = forces_on_j(assemblage, joint_forces), assemblage.joints
    exerted = []
    for position, block in enumerate(assemblage.wall.blocks):
        as_i, as_j = (np.flatnonzero(side == position) for side in (between.i, between.j))
        if not block.fixed or not len(as_i) + len(as_j):
            continue
        joints, sign = np.concatenate([as_i, as_j]), np.repeat([1.0, -1.0], [len(as_i), len(as_j)])
        at = np.average(between.centroid[joints], axis=0, weights=between.length[joints])
        force = (sign[:, None] * on_j[joints]).sum(axis=0)
        moment = float(sign @ moments_on_j(assemblage, joint_forces, at)[joints])
        exerted.append(Reaction(str(block.id), float(at[0]), float(at[1]), float(force[0]), float(force[1]), moment))
    for tie in ties:
        if tie.held is not None:
            (x, y), (along, upwards) = tie.points[tie.held].tolist(), tie.on(1 - tie.held).tolist()
            exerted.append(Reaction(f"tie {tie.number}", x, y, along, upwards, 0.0))
    return tuple(exerted)

"""The same bodies and joints for other programs: meshes (vtu, msh), input decks (CalculiX, Abaqus).

A deck has all bodies as 4-node tetrahedra, supports too, held at every node; one contact pair for the joints in one
line between two bodies, with slave nodes only where these joints are; a step for gravity and one for the horizontal
load. SI. What CalculiX needed to follow a wall to its collapse, with figures: docs/other_programs.md.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from orchestrator.app.pushover_run import mesh_cache
from orchestrator.app.segmented import Segmented
from orchestrator.basis.arrays import IntArray
from orchestrator.basis.errors import CaseError
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.masonry.wall import GRAVITY
from orchestrator.pushover.contact.faces import find_touching
from orchestrator.pushover.meshing import BodyMeshes, mesh_bodies, volumes
from orchestrator.pushover.solids.elastic_constants import constants_of, slip_tolerance_of
from orchestrator.pushover.solids.nodal_loads import departures_from_mean
from orchestrator.settings.case import Case, ModelName
from orchestrator.storage import write_text
from orchestrator.storage.mesh_files import write_mesh

Dialect = Literal["calculix", "abaqus"]
DECKS: tuple[Dialect, ...] = get_args(Dialect)
SUFFIX = {"vtu": ".vtu", "msh": ".msh", "calculix": ".inp", "abaqus": ".inp"}
FACES = ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))
"""nodes of faces S1 to S4 of C3D4, in both programs (CalculiX 2.20 manual, *SURFACE; Abaqus, solid elements)"""
NORMAL_PENALTY = 10.0
"""normal penalty of CalculiX times element size over elastic modulus; its manual (*SURFACE BEHAVIOR) advises 5 to 50"""
GROUND = 200.0
"""1/m; stiffness of all springs to the ground in a CalculiX deck over the weight: they hold loose stones, which have no
stiffness of their own in statics, and carry 1 % of the weight at 0.05 mm"""
A_LINE = 16
"""numbers on a line of a deck at most"""


def kind_of(output: Path | None) -> str:
    """Return what a file is to be written as by the end of its name, vtu without a file. Raises CaseError for an end
    that none or several have."""
    kinds = [kind for kind, suffix in SUFFIX.items() if output is None or suffix == output.suffix.lower()]
    if output is not None and len(kinds) != 1:
        of_it = " and ".join(kinds) or "none"
        raise CaseError("--output", f"{output.name}: its end does not say which format: {of_it}", "give --format too")
    return kinds[0]


@dataclass(frozen=True, eq=False, slots=True)
class ContactPair:
    """Slave nodes (s,) and the master's elements and faces (f,) (0 to 3), numbers of the mesh; friction coefficient."""

    slave: IntArray
    element: IntArray
    face: IntArray
    friction: float


def export(case: Case, segmented: Segmented, model: ModelName, kind: str, multiplier: float | None, path: Path) -> None:
    """Write `model` of a case to `path`: kind vtu or msh (moving bodies), calculix or abaqus.

    multiplier: horizontal load over weight at the end of the second step; None: that of micro limit analysis. Raises
    CaseError for loads that a deck would leave out.
    """
    if kind in DECKS and (key := case.load.beyond_default):
        problem = "decks carry weight and a horizontal load proportional to mass only"
        raise CaseError(key, problem, "leave it out, or export the mesh", str(case.file))
    joints = segmented.assemblage.joints
    compliances = (1.0 / joints.normal_stiffness, 1.0 / joints.shear_stiffness, 1.0 / joints.compressive_strength)
    if kind in DECKS and any(law.any() for law in (*compliances, joints.cohesion, joints.tensile_strength)):
        problem = "decks carry rigid joints of friction alone"
        raise CaseError("joints.classes", problem, "leave stiffness and strengths out", str(case.file))
    bodies = segmented.bodies_of(model)
    if model == "macro" and len(departures_from_mean(segmented.assemblage.wall, bodies).block) and kind in DECKS:
        problem = "a deck gives a body one density, and macroblocks join blocks of several"
        raise CaseError("wall", problem, "use --model micro, or export the mesh", str(case.file))
    if kind in ("vtu", "msh"):
        write_mesh(mesh_bodies(bodies, case.mesh, mesh_cache()), path, SUFFIX[kind])
        return
    dialect: Dialect = "calculix" if kind == "calculix" else "abaqus"
    load = segmented.analysis.headline.load_multiplier if multiplier is None else multiplier
    write_text(path, deck(bodies, case, float(case.load.vector[0]) * load, dialect))


def deck(bodies: Bodies, case: Case, multiplier: float, dialect: Dialect) -> str:
    """Return the input deck of `bodies`; `multiplier` (with the sign of the load) is reached at the end of step 2."""
    case = replace(case, mesh=replace(case.mesh, size=case.mesh.size_of(bodies)))
    everything = replace(bodies, moving=len(bodies.bodies))  # supports are meshed too: masters need faces
    meshes = mesh_bodies(everything, case.mesh, mesh_cache())
    pairs = list(contact_pairs(bodies, meshes))
    lines = [
        "*HEADING",
        f"{_ascii(case.name)}: {bodies.moving} bodies, {len(pairs)} contact pairs, {dialect}, N m kg s",
        *_mesh(bodies, meshes, case),
    ]
    for number, pair in enumerate(pairs):
        lines += _contact(number, pair, _interaction(pair, bodies, meshes, case, dialect))
    if dialect == "calculix":
        lines += _springs(meshes, bodies.moving)
    lines += _step("GRAVITY", 0.0, dialect)
    lines += _step("LATERAL", multiplier, dialect)
    return "\n".join(lines) + "\n"


def contact_pairs(bodies: Bodies, meshes: BodyMeshes) -> Iterator[ContactPair]:
    """Yield the contact pairs of all interfaces; those of the same two faces are one pair.

    meshes: of all bodies, supports last. A support is never a slave.
    """
    touching, sides = find_touching(bodies, meshes)
    face_of = _faces(meshes.tetrahedra)
    joined: dict[tuple[int, int, float], list[tuple[IntArray, IntArray]]] = {}
    for k in range(bodies.interfaces.count):
        key = int(touching.slave_face[k]), int(touching.master_face[k]), float(bodies.interfaces.friction[k])
        part = np.unique(sides[touching.slave_edge[k]]), sides[touching.master_edge[k]]
        joined.setdefault(key, []).append(part)
    for key, parts in joined.items():
        triangles = np.unique(np.sort(np.concatenate([part[1] for part in parts]), axis=1), axis=0)
        element, face = np.array([face_of[tuple(triangle)] for triangle in triangles.tolist()]).T
        yield ContactPair(np.unique(np.concatenate([part[0] for part in parts])), element, face, key[-1])


def _faces(tetrahedra: IntArray) -> dict[tuple[int, ...], tuple[int, int]]:
    """Return element and face by the face's sorted nodes."""
    return {
        tuple(nodes): (element, face)
        for face, corners in enumerate(FACES)
        for element, nodes in enumerate(np.sort(tetrahedra[:, corners], axis=1).tolist())
    }


def _mesh(bodies: Bodies, meshes: BodyMeshes, case: Case) -> Iterator[str]:
    """Yield nodes, elements and material of each body, the sets MOVING and LOADED, and the held SUPPORT."""
    constants = constants_of(bodies, case.elastic)
    yield "*NODE, NSET=ALL"
    for number, point in enumerate(meshes.nodes, 1):
        yield f"{number}, " + ", ".join(f"{x:.12g}" for x in point)
    for body in range(len(bodies.bodies)):
        yield f"*ELEMENT, TYPE=C3D4, ELSET=BODY{body}"
        for element in np.flatnonzero(meshes.body_of_tetrahedron == body):
            yield f"{element + 1}, " + ", ".join(str(node + 1) for node in meshes.tetrahedra[element])
        density = meshes.unit_weight[body] / GRAVITY
        elastic = f"{constants.elastic_modulus[body]:.12g}, {constants.poisson_ratio[body]:.12g}"
        yield from (f"*MATERIAL, NAME=STONE{body}", "*ELASTIC", elastic, "*DENSITY", f"{density:.12g}")
        yield f"*SOLID SECTION, ELSET=BODY{body}, MATERIAL=STONE{body}"
    for name in ("MOVING", "LOADED"):
        yield f"*ELSET, ELSET={name}"
        yield from _rows(f"BODY{body}" for body in range(bodies.moving))
    yield "*NSET, NSET=SUPPORT"
    yield from _rows(np.flatnonzero(meshes.body_of_node >= bodies.moving) + 1)
    yield from ("*BOUNDARY", "SUPPORT, 1, 3, 0.")


def _contact(number: int, pair: ContactPair, interaction: Iterable[str]) -> Iterator[str]:
    yield f"*SURFACE, NAME=SLAVE{number}, TYPE=NODE"
    yield from (f"{node + 1}," for node in pair.slave)
    yield f"*SURFACE, NAME=MASTER{number}, TYPE=ELEMENT"
    yield from (f"{element + 1}, S{face + 1}" for element, face in zip(pair.element, pair.face, strict=True))
    yield f"*SURFACE INTERACTION, NAME=JOINT{number}"
    yield from interaction
    yield f"*CONTACT PAIR, INTERACTION=JOINT{number}, TYPE=NODE TO SURFACE"
    yield f"SLAVE{number}, MASTER{number}"


def _interaction(pair: ContactPair, bodies: Bodies, meshes: BodyMeshes, case: Case, dialect: Dialect) -> list[str]:
    """Return no tension and Coulomb friction, which is reached at the elastic slip of the case.

    CalculiX has penalties (N/m3): the normal one follows the element size; the tangential one reaches friction times
    the mean pressure on the wall's bed at `contact.slip_tolerance`. The normal one is tabular because LINEAR pulls with
    up to a tension that must not be zero: CalculiX 2.20 puts the elastic modulus over 70000 for it, 50 kPa of stone.
    """
    slip = slip_tolerance_of(bodies, case.elastic, case.contact)
    if dialect == "abaqus":
        hard = "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD"
        return [hard, f"*FRICTION, ELASTIC SLIP={slip:.6g}", f"{pair.friction:.12g},"]
    normal = NORMAL_PENALTY * case.elastic.elastic_modulus / case.mesh.size_of(bodies)
    stick = min(pair.friction * _bed_pressure(bodies, meshes) / slip, 0.1 * normal)
    hard = "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR"
    return [hard, "0., 0.", f"{normal:.6g}, 1.", "*FRICTION", f"{pair.friction:.12g}, {stick:.6g}"]


def _springs(meshes: BodyMeshes, moving: int) -> Iterator[str]:
    """Yield soft springs from every moving node to the ground, alike in all directions."""
    nodes = np.flatnonzero(meshes.body_of_node < moving)
    stiffness = GROUND * _weight(meshes, moving) / len(nodes)
    number = len(meshes.tetrahedra)
    for direction in (1, 2, 3):
        yield f"*ELEMENT, TYPE=SPRING1, ELSET=GROUND{direction}"
        yield from (f"{number + k}, {node + 1}" for k, node in enumerate(nodes, 1))
        # CalculiX takes 5000 for no value, and 5000. for one
        yield from (f"*SPRING, ELSET=GROUND{direction}", f"{direction}", f"{stiffness:#.6g}")
        number += len(nodes)


def _weight(meshes: BodyMeshes, moving: int) -> float:
    """Return the weight of the moving bodies, N."""
    volume = volumes(meshes.nodes, meshes.tetrahedra)
    mine = meshes.body_of_tetrahedron < moving
    return float(volume[mine] @ meshes.unit_weight[meshes.body_of_tetrahedron[mine]])


def _bed_pressure(bodies: Bodies, meshes: BodyMeshes) -> float:
    """Return weight over the area of the joints on the supports, N/m2."""
    on_support = np.maximum(bodies.interfaces.i, bodies.interfaces.j) >= bodies.moving
    length = bodies.interfaces.length[on_support].sum()
    return _weight(meshes, bodies.moving) / (float(length) * bodies.thickness)


def _step(name: str, multiplier: float, dialect: Dialect) -> Iterator[str]:
    """Yield a step with both loads, each on its own set of the same elements, so that neither replaces the other.

    The horizontal load stands in the first step too, as zero: CalculiX 2.20 mixes up the values that loads had before
    when one comes in at a later step, ramps gravity from zero again, and the wall flies off.
    """
    yield from (f"** {name}", "*STEP, NLGEOM, INC=1000", "*STATIC", "0.1, 1., 1e-5, 0.1")
    yield from ("*DLOAD", f"MOVING, GRAV, {GRAVITY:.12g}, 0., -1., 0.")
    yield f"LOADED, GRAV, {multiplier * GRAVITY:.12g}, 1., 0., 0."
    if dialect == "calculix":
        yield from ("*NODE PRINT, NSET=SUPPORT, TOTALS=ONLY", "RF", "*NODE FILE", "U, RF", "*EL FILE", "S")
        yield from ("*CONTACT FILE", "CDIS, CSTR")
    else:
        yield from ("*NODE PRINT, NSET=SUPPORT, TOTALS=YES", "RF", "*OUTPUT, FIELD, VARIABLE=PRESELECT")
    yield "*END STEP"


def _rows(items: Iterable[object]) -> Iterator[str]:
    words = [str(item) for item in items]
    for first in range(0, len(words), A_LINE):
        yield ", ".join(words[first : first + A_LINE]) + ","


def _ascii(name: str) -> str:
    """Return a name that a deck can hold: one line, no comma."""
    return "".join(c if c.isascii() and c.isprintable() and c != "," else "_" for c in name)[:60]

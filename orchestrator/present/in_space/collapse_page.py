"""One HTML file with the collapse of a wall in space: to turn with the mouse, to move with a slider; no network."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.atomic_files import read_written, write_bytes
from orchestrator.geometry.polyhedra import Polyhedron, face_normals, triangles
from orchestrator.present.environment import environment_of
from orchestrator.present.in_space.space_pictures import BODIES, KINDS, STONE, SUPPORT, TIE, amplitude
from orchestrator.present.phrases import in_language, phrases
from orchestrator.settings.project import ProjectSettings
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.loads import plan_axes
from orchestrator.space.mechanism import SpaceMechanism

NO_PROJECT = ProjectSettings()
SLIDER_END = 3.0
"""The slider's end, times the displacement of the pictures."""


def write(
    path: Path,
    assemblage: SpaceAssemblage,
    rows: list[tuple[str, str]],
    remarks: list[str],
    answer: Sequence[str] = (),
    velocities: FloatArray | None = None,
    mechanism: SpaceMechanism | None = None,
    direction: FloatArray | None = None,
    pictures: dict[str, Path] | None = None,
    project: ProjectSettings = NO_PROJECT,
) -> Path:
    """Write the page of a wall, with the collapse where velocities (n, 6) and mechanism are given; return `path`.

    rows: what the table says; answer: the sentences on which number counts; pictures: title -> PNG to put in; project:
    its data stand on top, in its language.
    """
    say = phrases(project.language)
    data = scene(assemblage, velocities, mechanism, direction)
    images = {
        title: "data:image/png;base64," + base64.b64encode(read_written(file)).decode()
        for title, file in (pictures or {}).items()
    }
    text = (
        environment_of("orchestrator.present.in_space")
        .get_template("space.html.j2")
        .render(
            title=assemblage.wall.name,
            project=project,
            t=say,
            value_of=lambda text: in_language(say(text), project.language),
            rows=rows,
            remarks=remarks,
            answer=answer,
            data=data,
            images=images,
            moving=mechanism is not None,
            tied=bool(data["ties"]),
        )
    )
    write_bytes(path, text.encode())
    return path


def scene(
    assemblage: SpaceAssemblage,
    velocities: FloatArray | None,
    mechanism: SpaceMechanism | None,
    direction: FloatArray | None,
) -> dict[str, Any]:
    """Return blocks, joints, ties and motions as plain values: lengths over the wall's size, rounded to 1e-5 of it."""
    wall = assemblage.wall
    corners = np.vstack([block.shape.vertices for block in wall.blocks if not block.fixed])
    low, high = corners.min(axis=0), corners.max(axis=0)
    centre, size = 0.5 * (low + high), float(np.linalg.norm(high - low))
    count, centroids = len(wall.blocks), wall.centroids
    scale = 0.0 if velocities is None else SLIDER_END * amplitude(assemblage, velocities)
    motion = np.zeros((count, 6)) if velocities is None else scale * velocities
    body = np.zeros(count, dtype=np.int64) if mechanism is None else mechanism.body
    tied = assemblage.joints.is_tie
    kinds = ("rests",) * len(tied) if mechanism is None else mechanism.motion
    eye = None if direction is None else direction - (direction @ wall.up) * wall.up
    if eye is None or np.linalg.norm(eye) < 1e-6:
        eye = -plan_axes(wall.up)[1]
    blocks = [
        _block(block.shape, centre, size)
        | {
            "id": block.id,
            "colour": SUPPORT if block.fixed else STONE if not own else BODIES[(int(own) - 1) % len(BODIES)],
            "centre": np.round((centroids[k] - centre) / size, 5),
            "move": np.round(np.concatenate([motion[k, :3] / size, motion[k, 3:]]), 6),
            "fixed": block.fixed,
        }
        for k, (block, own) in enumerate(zip(wall.blocks, body, strict=True))
    ]
    joints = [_joint(assemblage, k, kind, centre, size) for k, kind in enumerate(kinds) if not tied[k]]
    ties = [_tie(assemblage, k, centre, size) for k in np.flatnonzero(tied)]
    ahead = eye / np.linalg.norm(eye)
    views = {"up": wall.up, "ahead": ahead, "height": float(high @ wall.up)}
    return {"blocks": blocks, "joints": joints, "ties": ties} | views


def _joint(assemblage: SpaceAssemblage, number: int, kind: str, centre: FloatArray, size: float) -> dict[str, Any]:
    """Return the block that a joint moves with, its colour by its kind of motion, and its outline."""
    return {
        "block": int(assemblage.joints.i[number]),
        "colour": KINDS[kind][0] if kind in KINDS else (0.25, 0.45, 0.65),
        "moves": kind != "rests",
        "at": np.round((assemblage.joints.outlines[number] - centre) / size, 5),
    }


def _tie(assemblage: SpaceAssemblage, number: int, centre: FloatArray, size: float) -> dict[str, Any]:
    """Return the blocks that the ends of a tie move with, its colour, and its ends."""
    joints = assemblage.joints
    ends = np.round((joints.outlines[number] - centre) / size, 5)
    return {"blocks": [int(joints.i[number]), int(joints.j[number])], "colour": TIE[0], "at": ends}


def _block(body: Polyhedron, centre: FloatArray, size: float) -> dict[str, Any]:
    """Return corners, triangles with the number of their face, normals of faces, and visible edges of a body."""
    normal = face_normals(body)
    of_edge: dict[tuple[int, int], list[int]] = {}
    for k, face in enumerate(body.faces):
        for start, end in zip(face, (*face[1:], face[0]), strict=True):
            of_edge.setdefault((min(start, end), max(start, end)), []).append(k)
    edges = [edge for edge, faces in of_edge.items() if len(faces) < 2 or normal[faces[0]] @ normal[faces[1]] < 0.999]
    return {
        "vertices": np.round((body.vertices - centre) / size, 5),
        "triangles": triangles(body),
        "faces": np.repeat(np.arange(len(body.faces)), [len(face) - 2 for face in body.faces]),
        "normals": np.round(normal, 3),
        "edges": edges,
    }

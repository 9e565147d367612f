"""The collapse as data for the page: outlines of the bodies, displacements and joint states by increment.

Displacements are 16-bit integers in base64, scaled by the largest of their increment; joint states are one digit a
piece of joint (0 open, 1 stick, 2 slip, 3 open by a hair, 4 of a stone that has fallen: not drawn), and so are degrees
of damage (0 to 9 for 0 to 1; the empty word where nothing is damaged). Increments are thinned out evenly to fit `room`;
peak and ends stay.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.present.joint_pieces import (
    DAMAGED,
    front_loops,
    interface_pieces,
    shown_displacement,
    status_of_pieces,
)
from orchestrator.present.tie_states import ShownTies
from orchestrator.pushover.increments import Increment, PushoverCurve
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.storage import ContactPlaces, StateStore

MOST_FRAMES = 150
"""increments of a model that the slider shows, at most"""
LARGEST_INTEGER = 32767
"""displacements on the page are integers of 16 bits"""


def collapse(
    store: StateStore,
    bodies: Bodies,
    meshes: BodyMeshes,
    contacts: ContactPlaces,
    curve: PushoverCurve,
    room: int,
    ties: ShownTies | None = None,
) -> dict[str, Any]:
    """Return outlines, pieces of joints, ties and frames of at most about `room` bytes as JSON."""
    loops = [front_loops(meshes, body) for body in range(bodies.moving)]
    contact, before, after = interface_pieces(bodies, meshes, contacts)
    used = [node for body in loops for loop in body for node in loop]
    nodes, place = np.unique(np.concatenate([used, contacts.slave_node]).astype(np.int64), return_inverse=True)
    number = dict(zip(nodes.tolist(), range(len(nodes)), strict=True))
    at_contact = place[len(used) :]
    frame_size = len(nodes) * 16 // 3 + len(contact) + 150 + 100 * (0 if ties is None else len(ties.ends))
    rows = chosen_rows(
        len(curve.step), int(np.where(curve.moving == 0, curve.base_shear_N, -np.inf).argmax()), room // frame_size
    )
    return {
        "nodes": np.round(meshes.nodes[nodes, :2], 5),
        "bodies": [[[number[node] for node in loop] for loop in body] for body in loops],
        "supports": [np.round(body.exterior, 5) for body in bodies.bodies[bodies.moving :]],
        "ties": [] if ties is None else ties.ends,
        "pieces": np.column_stack([at_contact[before], at_contact[contact], at_contact[after]]),
        "frames": [
            _frame(row, increment, curve)
            | _drawn(increment, meshes, nodes, status_of_pieces(bodies, contacts, contact, increment), contact)
            | {"ties": _tied(ties, increment)}
            for row, increment in zip(rows.tolist(), store.these(curve.step[rows].tolist()), strict=True)
        ],
        "increments": len(curve.step),
    }


def chosen_rows(rows: int, peak: int, most: int) -> IntArray:
    """Return which of the `rows` of a curve are shown: first, last, peak, and others evenly, some `most` in all."""
    wanted = np.linspace(0, rows - 1, min(rows, max(2, min(most, MOST_FRAMES)))).round().astype(np.int64)
    return np.unique(np.append(wanted, peak))


def _frame(row: int, increment: Increment, curve: PushoverCurve) -> dict[str, Any]:
    return {
        "row": row,
        "increment": increment.number,
        "phase": increment.phase,
        "multiplier": increment.load_multiplier,
        "shear": increment.base_shear,
        "moved": float(curve.control_displacement_m[row] - curve.control_displacement_m[0]),
    }


def _drawn(
    increment: Increment, meshes: BodyMeshes, nodes: IntArray, status: IntArray, contact: IntArray
) -> dict[str, Any]:
    """Return displacements of the nodes that are drawn, status (p,) and damage of the pieces of joints, and the bodies
    that have fallen: these stay where they stood."""
    scale, text = packed(shown_displacement(meshes, increment)[nodes])
    return {
        "fallen": np.flatnonzero(increment.fallen).tolist(),
        "scale": scale,
        "displacements": text,
        "status": "".join(map(str, status.tolist())),
        "damage": ninths(increment.damage[contact]),
    }


def _tied(ties: ShownTies | None, increment: Increment) -> list[dict[str, Any]]:
    """Return what each tie does: displacements (2, 2) of its ends in m, force in N, state."""
    if ties is None:
        return []
    columns = zip(np.round(ties.moved(increment), 6), increment.tie_force.tolist(), ties.states(increment), strict=True)
    return [{"moved": moved, "force": force, "state": state} for moved, force, state in columns]


def ninths(degree: FloatArray) -> str:
    """Return degrees from 0 to 1 as one digit each, 0 for up to DAMAGED and 9 for 1; the empty word for all 0."""
    digits = np.where(degree >= 1.0, 9, np.where(degree > DAMAGED, np.ceil(8.0 * degree), 0)).astype(int)
    return "".join(map(str, digits.tolist())) if digits.any() else ""


def packed(values: FloatArray) -> tuple[float, str]:
    """Return the unit in m and base64 of 16-bit little-endian integers: values = unit x integers."""
    unit = float(np.abs(values).max(initial=0.0)) / LARGEST_INTEGER or 1.0
    return unit, base64.b64encode(np.round(values / unit).astype("<i2").tobytes()).decode()

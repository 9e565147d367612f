"""Whether two runs are the same: wall, case, loads and program. Only with the same one --resume and studies go on."""

from __future__ import annotations

import hashlib
from dataclasses import fields, replace

from orchestrator.basis.program import sources
from orchestrator.masonry.wall import Wall
from orchestrator.settings.case import Case


def identity(case: Case, wall: Wall) -> str:
    """Return a hash of everything that a pushover of a wall's bodies depends on, except how far it is followed.

    Of the case: loads, joints, ties, mesh, elasticity, contact, Newton's method, stepping. Of the wall: every block's
    outline, unit weight, material and constants. Of the program: its sources.
    """
    stepping = replace(case.stepping, final_displacement=1.0, final_drop=1.0, largest_increments=1)
    settings = (case.load, case.joints, case.reinforcement, case.mesh, case.elastic, case.contact, case.newton)
    total = hashlib.sha256(repr((sources(), settings, stepping, wall.thickness, wall.friction)).encode())
    total.update(repr(wall.mortar).encode())
    for block in wall.blocks:
        total.update(repr([getattr(block, one.name) for one in fields(block) if one.name != "polygon"]).encode())
        total.update(block.polygon.tobytes())
    return total.hexdigest()

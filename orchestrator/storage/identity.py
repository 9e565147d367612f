"""Whether two runs are the same: wall, case, loads and program. Only with the same one --resume and studies go on."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import fields, replace
from typing import Any

from orchestrator.basis.program import sources
from orchestrator.masonry.wall import Wall
from orchestrator.settings.case import Case, as_record

SECTIONS = ("load", "joints", "reinforcement", "mesh", "elastic", "contact", "newton", "stepping")
"""of a case file, on which the increments of a pushover depend"""


def identity(case: Case, wall: Wall) -> str:
    """Return a hash of everything that a pushover of a wall's bodies depends on, except how far it is followed.

    Of the case: SECTIONS. Of the wall: every block's outline, unit weight, material and constants. Of the program: its
    sources.
    """
    settings = [getattr(_endless(case), section) for section in SECTIONS]
    total = hashlib.sha256(repr((sources(), settings, wall.thickness, wall.friction)).encode())
    total.update(repr(wall.mortar).encode())
    for block in wall.blocks:
        total.update(repr([getattr(block, one.name) for one in fields(block) if one.name != "polygon"]).encode())
        total.update(block.polygon.tobytes())
    return total.hexdigest()


def settings_that_differ(case: Case, other: Case) -> Iterator[tuple[str, Any, Any]]:
    """Yield key, value and the other case's value (None: left out) of every setting on which `identity` depends."""
    one, another = (as_record(_endless(each), "") for each in (case, other))
    for section in SECTIONS:
        here, there = one[section], another[section]
        for key in dict.fromkeys([*here, *there]):
            if here.get(key) != there.get(key):
                yield f"{section}.{key}", here.get(key), there.get(key)


def _endless(case: Case) -> Case:
    """Return a case without how far its curve is followed."""
    return replace(case, stepping=replace(case.stepping, final_displacement=1.0, final_drop=1.0, largest_increments=1))

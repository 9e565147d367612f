"""What is to be said of the joints that were found: gaps that are none, contacts too short for one, idle classes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from orchestrator.basis.arrays import BoolArray
from orchestrator.basis.errors import CaseError, FallsError
from orchestrator.basis.printed import as_place, counted, few, millimetres, printed
from orchestrator.geometry.healing import open_gaps
from orchestrator.masonry.joints import (
    MODULI,
    Assemblage,
    JointClass,
    JointSettings,
    contacts_of,
    fitting,
    joined_over,
    values_of,
)

ROUNDING = 1e-9
"""part of a tensile strength that is rounding"""


def lost_joints(assemblage: Assemblage, settings: JointSettings) -> list[str]:
    """Return a warning about blocks that lie close without a joint, or none."""
    assert assemblage.outlines is not None, "joints come from a planar map"
    gaps, blocks = open_gaps(assemblage.outlines), assemblage.wall.blocks
    if not gaps:
        return []
    width = [1e3 * abs(gap.width) for gap in gaps]
    between = " to ".join(dict.fromkeys(f"{one:.2g}" for one in (min(width), max(width))))
    first = min(gaps, key=lambda gap: abs(gap.width))
    place = f"the first between blocks {blocks[first.i].id} and {blocks[first.j].id} at "
    place += f"{as_place(first.at[0], first.at[1])} m"
    joined = millimetres(joined_over(assemblage.wall, settings))
    many = f"{len(gaps)} pairs of blocks lie" if len(gaps) > 1 else "1 pair of blocks lies"
    return [
        f"WARNING: {many} {between} mm apart or over each other, without a joint there, "
        f"{place}; joints.tolerance is {joined}: if these are errors of the drawing, import the "
        "file with a larger --tolerance, or --mortar"
    ]


def naming_gaps(error: CaseError, assemblage: Assemblage, settings: JointSettings) -> CaseError:
    """Return the error of a wall that falls with the gaps between its blocks, which may be why; any other as it is."""
    gaps = lost_joints(assemblage, settings) if isinstance(error, FallsError) else []
    if not gaps:
        return error
    why = f"gaps may be why: {gaps[0].removeprefix('WARNING: ')}; else {error.remedy}"
    return FallsError(error.key, error.problem, why, error.file)


def short_contacts(assemblage: Assemblage, settings: JointSettings) -> list[str]:
    """Return a warning about contacts of two stones that are too short for a joint, with their places, or none."""
    outlines, blocks = assemblage.outlines, assemblage.wall.blocks
    if outlines is None:
        return []
    _, short = contacts_of(assemblage.wall, outlines, settings)
    if not len(short):
        return []
    start, end = outlines.vertex[outlines.start[short]], outlines.vertex[outlines.end[short]]
    length, middle = np.linalg.norm(end - start, axis=1), 0.5 * (start + end)
    named = [
        f"blocks {blocks[i].id} and {blocks[j].id} at {as_place(x, y)} m, {millimetres(long)}"
        for i, j, (x, y), long in zip(outlines.left[short], outlines.right[short], middle, length, strict=True)
    ]
    many = f"{counted(len(short), 'contact')} of stones {'are' if len(short) > 1 else 'is'} too short for a joint"
    return [f"WARNING: {many}: {few(named, '; ')}; joints.minimum_length says what is long enough"]


def idle_classes(assemblage: Assemblage, classes: Sequence[JointClass]) -> list[str]:
    """Return a warning of every class with values that no joint has: it fits none, or later ones replace them."""
    said, fits = list[str](), [fitting(assemblage, one) for one in classes]
    for number, (one, here) in enumerate(zip(classes, fits, strict=True)):
        key, given = f"WARNING: joints.classes.{number}", values_of(one)
        kind = {"any": "joint", "bed": "bed joint", "head": "head joint"}[one.orientation]
        kind += f" between {one.between[0]} and {one.between[1]}" if one.between else ""
        if not given:
            said.append(f"{key} acts on no joint: it gives no value")
        elif not here.any():
            said.append(f"{key} acts on no joint: the wall has no {kind}; not used: {', '.join(given)}")
        else:
            replaced = [name for name in given if not (here & ~_replaced(name, classes, fits, number)).any()]
            if replaced:
                said.append(f"{key}: later classes replace it in all its joints; not used: {', '.join(replaced)}")
    return said


def strengths_beyond_the_cone(assemblage: Assemblage, classes: Sequence[JointClass]) -> list[str]:
    """Return a warning of every class whose tensile strength is more than cohesion over friction in some joint."""
    said, fits = [], [fitting(assemblage, one) for one in classes]
    for number, (one, fit) in enumerate(zip(classes, fits, strict=True)):
        here = fit & ~_replaced("tensile_strength", classes, fits, number)
        least = float(assemblage.joints.tensile_strength[here].min(initial=np.inf))
        if one.tensile_strength is not None and least < (1.0 - ROUNDING) * one.tensile_strength:
            given, counts = (f"{printed('stress', stress)} MPa" for stress in (one.tensile_strength, least))
            said.append(
                f"WARNING: joints.classes.{number}.tensile_strength: {given} is more than cohesion over friction, "
                f"where joints open at the latest: it counts as {counts} there"
            )
    return said


def _replaced(name: str, classes: Sequence[JointClass], fits: Sequence[BoolArray], number: int) -> BoolArray:
    """Return in which joints (k,) classes after one of a number give its value `name` anew; of a thickness, all that it
    gives by it."""
    if name == "mortar_thickness":
        own = [_replaced(modulus, classes, fits, number) for modulus in values_of(classes[number]) if modulus in MODULI]
        return np.all([np.ones_like(fits[number]), *own], axis=0) if own else np.zeros_like(fits[number])
    value, after = MODULI.get(name, name), range(number + 1, len(classes))
    later = [fits[k] for k in after if value in {MODULI.get(given, given) for given in values_of(classes[k])}]
    return np.any([np.zeros_like(fits[number]), *later], axis=0)

"""`check`, the first page of a case: what was given, its sums, what is unusual, whether the wall stands, a picture."""

from __future__ import annotations

import math
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from orchestrator.app import load_cases
from orchestrator.app.terminal import shown
from orchestrator.basis.printed import counted, printed
from orchestrator.present.report import write_given
from orchestrator.present.weights import way_of
from orchestrator.settings.case import Case
from orchestrator.settings.inventory import (
    JointSums,
    LoadSums,
    MaterialSums,
    between,
    control_words,
    in_megapascals,
    joint_classes,
    load_sums,
    materials,
    stiffness_words,
    tie_words,
)
from orchestrator.settings.unusual import unusual

STANDS = "Joint forces can balance its dead load, and the live load brings it down."
RANGES = "kn\nN/mm3", "ks\nN/mm3"
"""columns of joints whose values may be ranges: these and words are wrapped where a terminal is narrow, no others"""


def check(case: Case, place: str, picture: Path, console: Console) -> int:
    """Print what a case holds, under the name `place`, and draw it as `picture`; return the exit code. Raises CaseError
    for whatever `limit` would refuse, and for a verification that `run` would."""
    with shown(console, "check", "joints, and whether the wall stands"):
        assemblage, said = load_cases.examine(case)
    wall, cases = assemblage.wall, load_cases.each(case)
    loads = {name: load_sums(wall, one.load) for name, one in cases.items()}
    of_materials, classes = materials(case, wall), joint_classes(assemblage)
    for name, sums in loads.items():
        console.print(loads_table(sums, name))
    console.print(materials_table(of_materials))
    console.print(joints_table(classes))
    for line in [*tie_words(case), *control_words(case, assemblage)]:
        console.print(line, soft_wrap=True)
    console.print(STANDS, soft_wrap=True)
    warnings = [*said, *unusual(case, wall, list(loads.values()), of_materials, classes)]
    for remark in warnings:
        console.print(f"{place}: {remark}", soft_wrap=True)
    names = {name: "_".join(filter(None, [picture.name, name])) for name in cases}
    with shown(console, "check", "picture"):
        pictures = ", ".join(
            str(write_given(picture.parent, one, assemblage, names[name])[0]) for name, one in cases.items()
        )
    free = sum(not block.fixed for block in wall.blocks)
    counts = f"{counted(free, 'block')}, {counted(assemblage.joints.count, 'joint')}"
    counts += f", {len(cases)} load cases" if case.load.several else ""
    verdict = "see the warnings above" if warnings else "nothing to complain about"
    console.print(f"{place}: {counts}, {verdict}; {pictures}", soft_wrap=True)
    return 0


def loads_table(sums: LoadSums, name: str = "") -> Table:
    """Return the loads of one load case: weight, extra dead loads, all of them, and the base shear at multiplier 1."""
    table = plain_table(f"Loads{', ' * bool(name)}{name}", ("", "blocks", "kN", "live load\nacts on it"))
    own = {"mass": "yes", "mass_height": "x height", "per_block": "no"}[sums.distribution]
    table.add_row("weight of the blocks", "all", kilonewtons(sums.weight), own)
    for one in sums.extra:
        acts = own if one.inertia else "no"
        table.add_row(f"extra: {one.name}", str(one.blocks), kilonewtons(one.resultant), acts)
    if sums.extra:
        table.add_row("all dead load, vertical resultant", "", kilonewtons(sums.vertical_load), "")
    for one in sums.live:
        table.add_row(f"live at λ = 1: {one.name}", str(one.blocks), kilonewtons(one.resultant), "")
    if sums.upright_load is None:
        table.add_row(f"base shear at λ = 1, {sums.direction}", "", kilonewtons(sums.horizontal_load), "")
    else:
        size, way = kilonewtons(abs(sums.upright_load)), way_of(sums.upright_load)
        table.add_row(f"live load at λ = 1, {way}", "", size, "")
    return table


def materials_table(sums: list[MaterialSums]) -> Table:
    """Return the materials with the values of their blocks."""
    columns = ("material", "blocks", "weight\nkN", "unit weight\nkN/m3", "thickness\nm", "friction", "E\nGPa", "ν")
    table = plain_table("Materials", columns)
    for one in sums:
        table.add_row(
            one.name or "(none)",
            str(one.blocks),
            kilonewtons(one.weight),
            between(one.unit_weight, 1e-3),
            between(one.thickness),
            between(one.friction),
            between(one.elastic_modulus, 1e-9),
            between(one.poisson_ratio),
        )
    return table


def joints_table(classes: list[JointSums]) -> Table:
    """Return the joints by the materials that meet and by their values."""
    strengths: tuple[str, ...] = ("cohesion\nMPa", "tension\nMPa", "crushing\nMPa")
    elastic = any(math.isfinite(least) for one in classes for least, _ in (one.normal_stiffness, one.shear_stiffness))
    strengths += RANGES if elastic else ()
    table = plain_table("Joints", ("joints between", "", "number", "length\nm", "friction", *strengths))
    for one in classes:
        table.add_row(
            ", ".join(one.between),
            one.orientation,
            str(one.joints),
            f"{one.length:.4g}",
            f"{one.friction:.4g}",
            *(in_megapascals(value) for value in (one.cohesion, one.tensile_strength, one.compressive_strength)),
            *(stiffness_words(value) for value in (one.normal_stiffness, one.shear_stiffness)[: 2 * elastic]),
        )
    return table


def plain_table(title: str, columns: tuple[str, ...]) -> Table:
    """Return a table without rows: numbers on the right, words on the left and wrapped."""
    table = Table(box=SIMPLE_HEAD, padding=0, title=title)
    for column in columns:
        words = column in ("", "material", "joints between")
        wraps = words or column in RANGES
        table.add_column(column, justify="left" if words else "right", no_wrap=not wraps, overflow="fold")
    return table


def kilonewtons(force: float) -> str:
    """Return a force as tables show it."""
    return printed("weight", force)

"""`check`, the first page of a case: what was given, its sums, what is unusual, whether the wall stands, a picture."""

from __future__ import annotations

import math
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from orchestrator.app import load_case_runs
from orchestrator.app.terminal import shown
from orchestrator.masonry.joints import Assemblage
from orchestrator.present import plots
from orchestrator.settings.case import Case
from orchestrator.settings.inventory import (
    JointSums,
    LoadSums,
    MaterialSums,
    Range,
    class_of_joint,
    control_words,
    joint_classes,
    load_sums,
    materials,
    tie_words,
)
from orchestrator.settings.unusual import unusual

STANDS = "It stands under its dead load, and the live load brings it down."
RANGES = "kn\nN/mm3", "ks\nN/mm3"
"""columns of joints whose values may be ranges: these and words are wrapped where a terminal is narrow, no others"""


def check(case: Case, place: str, figures: Path, console: Console) -> int:
    """Print and draw what a case holds, under the name `place`; return the exit code. Raises CaseError for whatever
    `limit` would refuse."""
    with shown(console, "check", "joints, and whether the wall stands"):
        assemblage, said = load_case_runs.examine(case)
    wall, cases = assemblage.wall, load_case_runs.each(case)
    loads = {name: load_sums(wall, one.load) for name, one in cases.items()}
    found, classes = materials(case, wall), joint_classes(assemblage)
    for name, sums in loads.items():
        console.print(loads_table(sums, name))
    console.print(materials_table(found))
    console.print(joints_table(classes))
    for line in [*tie_words(case), *control_words(case, assemblage)]:
        console.print(line, soft_wrap=True, markup=False)
    console.print(STANDS, soft_wrap=True)
    warnings = [*said, *unusual(case, wall, list(loads.values()), found, classes)]
    for remark in warnings:
        console.print(f"{place}: {remark}", soft_wrap=True, markup=False)
    with shown(console, "check", "picture"):
        pictures = ", ".join(str(_draw(one, assemblage, name, figures)) for name, one in cases.items())
    free = sum(not block.fixed for block in wall.blocks)
    counted = f"{free} blocks, {assemblage.joints.count} joints"
    counted += f", {len(cases)} load cases" if case.load.cases else ""
    verdict = "see the warnings above" if warnings else "nothing to complain about"
    console.print(f"{place}: {counted}, {verdict}; {pictures}", soft_wrap=True, markup=False)
    return 0


def _draw(case: Case, assemblage: Assemblage, name: str, figures: Path) -> Path:
    classes = class_of_joint(assemblage)
    several = len({value_words(one) for one in classes}) > 1
    words = [f"{one.between[0]}-{one.between[1]}: {value_words(one)}" for one in classes] if several else []
    picture = plots.given(assemblage, case.load, words, case.reinforcement.ties)
    return plots.save(picture, figures, f"blocks{'_' * bool(name)}{name}", case.project.language)[0]


def loads_table(sums: LoadSums, name: str = "") -> Table:
    """Return the loads of one load case: weight, extra dead loads, all of them, and the base shear at multiplier 1."""
    table = _table(f"Loads{', ' * bool(name)}{escape(name)}", ("", "blocks", "kN", "live load\nacts on it"))
    own = {"mass": "yes", "mass_height": "x height", "per_block": "no"}[sums.distribution]
    table.add_row("weight of the blocks", "all", _kilonewtons(sums.weight), own)
    for one in sums.extra:
        acts = own if one.inertia else "no"
        table.add_row(f"extra: {one.name}", str(one.blocks), _kilonewtons(one.resultant), acts)
    if sums.extra:
        table.add_row("all dead load", "", _kilonewtons(sums.dead), "")
    table.add_row(f"base shear at λ = 1, {sums.direction}", "", _kilonewtons(sums.base_shear), "")
    return table


def materials_table(found: list[MaterialSums]) -> Table:
    """Return the materials with the values of their blocks."""
    columns = ("material", "blocks", "weight\nkN", "unit weight\nkN/m3", "thickness\nm", "friction", "E\nGPa", "ν")
    table = _table("Materials", columns)
    for one in found:
        table.add_row(
            escape(one.name) or "(none)",
            str(one.blocks),
            _kilonewtons(one.weight),
            _between(one.unit_weight, 1e-3),
            _between(one.thickness),
            _between(one.friction),
            _between(one.elastic_modulus, 1e-9),
            _between(one.poisson_ratio),
        )
    return table


def joints_table(classes: list[JointSums]) -> Table:
    """Return the joints by the materials that meet and by their values."""
    strengths: tuple[str, ...] = ("cohesion\nMPa", "tension\nMPa", "crushing\nMPa")
    elastic = any(math.isfinite(least) for one in classes for least, _ in (one.normal_stiffness, one.shear_stiffness))
    strengths += RANGES if elastic else ()
    table = _table("Joints", ("joints between", "", "number", "length\nm", "friction", *strengths))
    for one in classes:
        table.add_row(
            escape(f"{one.between[0]}, {one.between[1]}"),
            one.orientation,
            str(one.joints),
            f"{one.length:.4g}",
            f"{one.friction:.4g}",
            *(_megapascals(value) for value in (one.cohesion, one.tensile_strength, one.compressive_strength)),
            *(_stiffness(value) for value in (one.normal_stiffness, one.shear_stiffness)[: 2 * elastic]),
        )
    return table


def value_words(one: JointSums) -> str:
    """Return the values of a class of joints in a few words, for a legend."""
    strengths = (("c", one.cohesion), ("ft", one.tensile_strength), ("fc", one.compressive_strength))
    given = [f"{name} {_megapascals(value)} MPa" for name, value in strengths if 0.0 < value < math.inf]
    stiffness = (("kn", one.normal_stiffness), ("ks", one.shear_stiffness))
    given += [f"{name} {_stiffness(values)} N/mm3" for name, values in stiffness if values[0] < math.inf]
    return ", ".join([f"μ {one.friction:.4g}", *given])


def _table(title: str, columns: tuple[str, ...]) -> Table:
    table = Table(box=SIMPLE_HEAD, padding=0, title=title)
    for column in columns:
        words = column in ("", "material", "joints between")
        wraps = words or column in RANGES
        table.add_column(column, justify="left" if words else "right", no_wrap=not wraps, overflow="fold")
    return table


def _kilonewtons(force: float) -> str:
    return f"{force / 1e3:.3f}"


def _megapascals(strength: float) -> str:
    return "none" if strength in (0.0, math.inf) else f"{strength / 1e6:.4g}"


def _stiffness(values: Range) -> str:
    return "rigid" if values[0] == math.inf else _between(values, 1e-9, 3)


def _between(values: Range, factor: float = 1.0, digits: int = 4) -> str:
    low, high = (f"{factor * value:.{digits}g}" for value in values)
    return low if low == high else f"{low} to {high}"

"""`check` of a wall in space: its loads, materials and joints, what is unusual about it, and whether it stands."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.table import Table

from orchestrator.app.case_check import STANDS, kilonewtons, loads_table, plain_table
from orchestrator.app.space_commands import assemblage_of, corner_words, doubtful_joints
from orchestrator.app.space_rows import load_words, wall_rows, without_mass
from orchestrator.app.terminal import shown
from orchestrator.basis.atomic_files import together
from orchestrator.basis.errors import naming
from orchestrator.basis.printed import counted
from orchestrator.present.in_space import collapse_page, space_pictures
from orchestrator.settings.inventory import between
from orchestrator.settings.space_case import SpaceCase, read
from orchestrator.settings.space_inventory import (
    SpaceJointSums,
    SpaceMaterialSums,
    joint_classes,
    load_sums,
    materials,
    unusual,
)
from orchestrator.space.analysis import analyse
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.loads import loads_on
from orchestrator.space.ties import counted_joints, shown_point


def check(path: Path, overrides: list[str], output: Path, console: Console) -> int:
    """Print and draw what a case holds; return the exit code. Raises CaseError for whatever `limit` would refuse."""
    case = read(path, overrides)
    assemblage = assemblage_of(case)
    wall = assemblage.wall
    with naming(case.file):
        loads, sums = loads_on(wall, case.load), load_sums(wall, case.load)
        with shown(console, "check", "whether the wall stands"):
            found = analyse(assemblage, loads, replace(case.limit_analysis, states="none"))
    of_materials, classes = materials(wall), joint_classes(assemblage)
    for table in (loads_table(sums), materials_table(of_materials), joints_table(classes)):
        console.print(table)
    for line in [load_words(assemblage, loads), *corner_words(case, assemblage), *tie_words(case)]:
        console.print(line, soft_wrap=True)
    console.print(STANDS, soft_wrap=True)
    said = [*doubtful_joints(case, assemblage), *without_mass(case), *found.remarks]
    said += unusual(sums, of_materials, classes, case)
    for remark in said:
        console.print(f"{path}: {remark}", soft_wrap=True)
    _draw(case, assemblage, said, output, console)
    return 0


def _draw(case: SpaceCase, assemblage: SpaceAssemblage, said: list[str], output: Path, console: Console) -> None:
    """Draw the wall, and say where that is and how many blocks and joints there are."""
    direction = loads_on(assemblage.wall, case.load).direction
    with together():
        png = space_pictures.save_wall(assemblage, direction, output / "figures" / "blocks.png", case.project.language)
        html = collapse_page.write(
            output / "blocks.html",
            assemblage,
            wall_rows(case, assemblage),
            said,
            direction=direction,
            project=case.project,
        )
    free = int((~case.wall.fixed).sum())
    verdict = "see the warnings above" if said else "nothing to complain about"
    counts = f"{counted(free, 'block')} in space, {counted_joints(assemblage)}"
    console.print(f"{case.file}: {counts}, {verdict}; {png}; to turn: {html}", soft_wrap=True)


def materials_table(sums: list[SpaceMaterialSums]) -> Table:
    """Return the materials with the values of their blocks."""
    table = plain_table(
        "Materials", ("material", "blocks", "volume\nm3", "weight\nkN", "unit weight\nkN/m3", "friction")
    )
    for one in sums:
        table.add_row(
            one.name or "(none)",
            str(one.blocks),
            f"{one.volume:.4g}",
            kilonewtons(one.weight),
            between(one.unit_weight, 1e-3),
            between(one.friction),
        )
    return table


def joints_table(classes: list[SpaceJointSums]) -> Table:
    """Return the joints by the materials that meet and by friction."""
    table = plain_table("Joints", ("joints between", "number", "area\nm2", "friction"))
    for one in classes:
        table.add_row(", ".join(one.between), str(one.joints), f"{one.area:.4g}", f"{one.friction:.4g}")
    return table


def tie_words(case: SpaceCase) -> list[str]:
    """Return every tie in words, with where its ends are."""
    said = []
    for number, tie in enumerate(case.reinforcement.ties, 1):
        ends = zip(tie.blocks, (tie.start, tie.end), strict=True)
        blocks = " to ".join(f"block {block} at {shown_point(point)}" for block, point in ends)
        said.append(f"tie {number}: {blocks}, yields at {kilonewtons(tie.strength)} kN")
    return said

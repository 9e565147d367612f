"""limit of walls in space: what it prints, and what it leaves in the folder."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from orchestrator.app.space_rows import (
    HELD,
    bound_words,
    figures,
    kinematic_rows,
    load_words,
    mechanism_rows,
    torsions_differ,
    wall_rows,
    without_mass,
)
from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import ConvergenceError, FallsError, naming
from orchestrator.basis.printed import counted, millimetres, printed
from orchestrator.geometry.polyhedra import volume_of
from orchestrator.present.answer import answer_in_space
from orchestrator.present.in_space import collapse_page, space_pictures
from orchestrator.settings.space_case import SpaceCase, read
from orchestrator.space.alignment import aligned, moved_by
from orchestrator.space.analysis import analyse
from orchestrator.space.contacts import LARGEST_GAP, SpaceAssemblage, find_joints, gaping
from orchestrator.space.found import PUSHES, SpaceAnalysis
from orchestrator.space.loads import SpaceLoads, loads_on
from orchestrator.space.mechanism import mechanism_of
from orchestrator.space.resistance import UnresistedError
from orchestrator.space.states import SpaceState
from orchestrator.space.ties import counted_joints, tie_forces, with_ties
from orchestrator.storage.files import plain, write_json

LISTED_JOINTS = 5
"""ignored joints that are named"""
NOTHING_OF_GAP = 1e-3
"""part of the largest block's gap below which it is not told that corners were moved"""
WIDER = 4.0
"""times the gap with which it is tried whether a drawing is less exact than that"""
CLEARLY = 0.25
"""gaps by which corners of most blocks move then where it is (2.4 of them in an L wall turned and rounded to 1 mm), and
do not with a gap that is wider still"""


def assemblage_of(case: SpaceCase) -> SpaceAssemblage:
    """Return the wall of a case with its joints and ties. Raises CaseError."""
    with naming(case.file):
        return with_ties(find_joints(case.wall, case.contact), case.reinforcement.ties)


def doubtful_joints(case: SpaceCase, assemblage: SpaceAssemblage) -> list[str]:
    """Return warnings that list common areas too small to be a joint, blocks that lie a little too far apart, and that
    a drawing is less exact than contact.gap."""
    said, small, apart = [], assemblage.ignored, gaping(assemblage, case.contact)
    if small:
        listed = _listed([f"{one.i} | {one.j} ({1e6 * one.area:.3g} mm2)" for one in small])
        many = counted(len(small), "common area")
        said.append(f"WARNING: {many} too small for a joint (contact.smallest), between blocks {listed}")
    if apart:
        listed = _listed([f"{i} | {j}" for i, j in apart])
        said.append(f"WARNING: no joint where blocks lie a little more than contact.gap apart: {listed}")
    return [*said, *inexact_words(case, assemblage)]


def inexact_words(case: SpaceCase, assemblage: SpaceAssemblage) -> list[str]:
    """Return how far off a drawing is of which most free blocks have corners off levels that a gap of WIDER makes one,
    and a still wider one no others: levels of stones that are cut at all angles go on to merge."""
    gap, wall = case.contact.gap, assemblage.wall
    if wall is case.wall or WIDER * gap > LARGEST_GAP:
        return []
    free, gaps = ~wall.fixed, _gaps(case)
    wider, widest = aligned(wall, WIDER * gap), aligned(wall, WIDER**2 * gap)
    off, more = moved_by(wall, wider)[free], moved_by(wider, widest)[free]
    if not np.median(more / gaps[free]) <= CLEARLY < np.median(off / gaps[free]):
        return []
    return [
        f"WARNING: corners lie up to {millimetres(off.max())} off planes that they seem to have in common, and "
        f"contact.gap = {gap:g} leaves them there: {WIDER * gap:g} puts them in"
    ]


def _gaps(case: SpaceCase) -> FloatArray:
    """Return what contact.gap is at each block (n,), m."""
    return case.contact.gap * np.cbrt([volume_of(block.shape) for block in case.wall.blocks])


def corner_words(case: SpaceCase, assemblage: SpaceAssemblage) -> list[str]:
    """Return how far corners of the drawing were moved to where they are meant to lie, where they were."""
    far = float(moved_by(case.wall, assemblage.wall).max())
    if far < NOTHING_OF_GAP * _gaps(case).max():
        return []
    return [
        f"corners lie up to {millimetres(far)} off planes that they have in common, and were put there (contact.gap)"
    ]


def _listed(names: list[str]) -> str:
    return ", ".join(names[:LISTED_JOINTS]) + ", ..." * (len(names) > LISTED_JOINTS)


def limit(path: Path, overrides: list[str], output: Path, as_json: bool, console: Console) -> int:
    """Run the limit analysis of a wall in space; print it, draw its mechanism; return the exit code."""
    case = read(path, overrides)
    assemblage = assemblage_of(case)
    free = int((~case.wall.fixed).sum())

    def say(text: str) -> None:
        if not as_json:
            console.print(text, soft_wrap=True)

    say(f"{case.name}: {counted(free, 'block')} in space, {counted_joints(assemblage)}")
    with naming(case.file):
        loads = loads_on(assemblage.wall, case.load)
        say(load_words(assemblage, loads))
        analysis = analyse(assemblage, loads, case.limit_analysis, _sparse(say))
    if as_json:
        print(json.dumps(plain(record(analysis)), indent=1))
        return 0
    console.print(table(analysis))
    _show_mechanism(case, assemblage, loads, analysis, output, say)
    return 0


def _show_mechanism(
    case: SpaceCase,
    assemblage: SpaceAssemblage,
    loads: SpaceLoads,
    analysis: SpaceAnalysis,
    output: Path,
    say: Callable[[str], None],
) -> None:
    """Say what the mechanism is, draw it, and write it down."""
    mechanism = mechanism_of(assemblage, analysis.shown.velocities, analysis.shown.forces)
    remarks = [*corner_words(case, assemblage), *doubtful_joints(case, assemblage), *without_mass(case)]
    remarks += analysis.remarks
    for remark in remarks:
        say(remark)
    rows = [*mechanism_rows(analysis, mechanism), *kinematic_rows(case, analysis)]
    for name, text in rows:
        say(f"{name}: {text}")
    say(" ".join(answer_in_space(analysis)))
    write_json(output / "limit_analysis.json", record(analysis) | {"mechanism": dict(rows)})
    text = f"{analysis.shown.name}, λ = {analysis.shown.load_multiplier:.4f}; displacements enlarged"
    language = case.project.language
    drawn = (assemblage, analysis.shown.velocities, mechanism, loads.direction, text)
    pictures = {"Mechanism": space_pictures.save_mechanism(*drawn, output / "figures" / "mechanism.png", language)}
    if case.load.directions:
        pictures["Multiplier by direction"] = _polar(case, assemblage, output, say)
    html = collapse_page.write(
        output / "collapse.html",
        assemblage,
        [*wall_rows(case, assemblage), *figures(analysis), *rows],
        remarks,
        answer_in_space(analysis),
        analysis.shown.velocities,
        mechanism,
        loads.direction,
        pictures,
        case.project,
    )
    say(f"mechanism: {pictures['Mechanism']}; to turn, under a slider: {html}")


def _sparse(say: Callable[[str], None]) -> Callable[[str], None]:
    """Say at once what is begun, by its name, and how a push gets on every few seconds."""
    from time import perf_counter

    last: dict[str, Any] = {"kind": "", "at": 0.0}

    def report(text: str) -> None:
        kind, now = text.partition(":")[0], perf_counter()
        if kind != last["kind"] or now - last["at"] > 5.0:
            say(text if kind == last["kind"] else kind)
            last.update(kind=kind, at=now)

    return report


def record(analysis: SpaceAnalysis) -> dict[str, Any]:
    """Return the limit_analysis part of a summary: the keys of a plane wall's, the direction of the live load, both
    torsions, and what ties do."""
    headline, interval = analysis.headline, analysis.range
    shown, is_none = analysis.shown, headline is None and analysis.looked_for != "none"
    ties = tie_forces(analysis.assemblage, shown.forces)
    corners, uniform = analysis.bound, analysis.other_torsion
    if analysis.torsion == "uniform":
        corners, uniform = uniform, corners
    return {
        "direction": analysis.loads.direction,
        "associative": analysis.bound if math.isfinite(analysis.bound) else None,
        "non_associative": headline.load_multiplier if headline else None,
        "non_associative_range": list(interval) if interval else None,
        "iterations": len(analysis.states),
        "converged": headline is not None and headline.valid and analysis.not_at_rest is None,
        "equilibrium_residual": shown.validation.equilibrium,
        "base_shear": None if is_none else shown.load_multiplier * analysis.horizontal_load,
        "seconds": analysis.seconds,
        "lowest": interval[0] if interval else None,
        "highest": interval[1] if interval else None,
        "going_down": list(analysis.going_down),
        "torsion": {"corners": corners, "uniform": uniform},
        "tie_forces_N": [tie.pull for tie in ties],
        "tie_strengths_N": [tie.strength for tie in ties],
        "tie_states": [tie.state for tie in ties],
    }


def table(analysis: SpaceAnalysis) -> Table:
    """Return multipliers, base shears and residuals of the associative optimum and of all that was found.

    In place of the base shear stands a live load that has none: an upright one.
    """
    weight, base_shear = analysis.weight, analysis.horizontal_load
    weighs = f"weight {weight / 1e3:.3f} kN"
    if analysis.upright_load is None and abs(base_shear - weight) > 1e-9 * weight:  # floors, or forces that are given
        weighs = f"weight of the blocks {weight / 1e3:.3f} kN, base shear {base_shear / 1e3:.3f} kN at λ = 1"
    title = f"Limit analysis in space, {weighs}, {analysis.seconds:.1f} s"
    result = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), title=title)
    load = "base shear\nkN" if analysis.upright_load is None else "live load\nkN"
    for column in ("", "multiplier", load, "time\ns", "residuals:\nbalance", "\nflow", "\npower"):
        result.add_column(column, justify="right" if column else "left", no_wrap=True)
    lowest = min(analysis.counted, key=lambda s: s.load_multiplier, default=None)
    highest = max(analysis.counted, key=lambda s: s.load_multiplier, default=None)
    named = dict[str, SpaceState]()
    other = "uniform" if analysis.torsion == "corners" else "corners"
    for state in analysis.states:
        if state.name in PUSHES:
            named[state.name.removeprefix(f"{PUSHES[0]}, ")] = state
    named |= {"lowest found": lowest, "highest found": highest} if lowest and highest else {}
    result.add_row("associative (bound)", *(_row(analysis.associative, analysis) if analysis.associative else [HELD]))
    if torsions_differ(analysis):
        result.add_row(f"  torsion {other}", bound_words(analysis.other_torsion, 5))
    for name, state in named.items():
        result.add_row(name, *_row(state, analysis))
    return result


def _row(state: SpaceState, analysis: SpaceAnalysis) -> list[str]:
    associative = state is analysis.associative
    shown = f"{state.load_multiplier:.5f}" if state.valid or associative else f"({state.load_multiplier:.5f})"
    checks = state.validation
    residuals = ["" if associative else f"{value:.0e}" for value in (checks.flow, checks.power)]
    upright = analysis.upright_load
    load = printed("force", state.load_multiplier * (analysis.horizontal_load if upright is None else abs(upright)))
    return [shown, load, f"{state.seconds:.2f}", f"{checks.equilibrium:.0e}", *residuals]


@dataclass(frozen=True, slots=True)
class InDirection:
    """A direction in plan (angle in rad) with its multipliers; nearly: whether the headline is of what is nearly a
    state; gap: why it has none, "" where it has."""

    angle: float
    associative: float = math.nan
    headline: float = math.nan
    nearly: bool = False
    gap: str = ""

    def __str__(self) -> str:
        said = f"direction {math.degrees(self.angle):.0f} degrees: "
        if self.gap:
            return said + self.gap
        without = "no state found" if math.isnan(self.headline) else f"{self.headline:.4f}"
        without = f"({without})" if self.nearly else without
        bound = HELD if math.isnan(self.associative) else f"{self.associative:.4f}"
        return f"{said}associative {bound}, without dilation {without}"


def _in_direction(case: SpaceCase, assemblage: SpaceAssemblage, angle: float) -> InDirection:
    """Analyse the load in a direction in plan (rad); one that holds the wall, or has no answer, is a gap."""
    loads = loads_on(assemblage.wall, replace(case.load, direction=None, angle=angle))
    try:
        found = analyse(assemblage, loads, replace(case.limit_analysis, states="headline"))
    except UnresistedError as error:
        return InDirection(angle, gap=f"{HELD}, {error.problem}")
    except (ConvergenceError, FallsError) as error:
        return InDirection(angle, gap=f"not found, {error}")
    headline, nearly = math.nan, False
    if found.headline is not None and found.not_at_rest is None:
        headline, nearly = found.headline.load_multiplier, found.headline.nearly
    return InDirection(angle, found.bound if math.isfinite(found.bound) else math.nan, headline, nearly)


def _polar(case: SpaceCase, assemblage: SpaceAssemblage, output: Path, say: Callable[[str], None]) -> Path:
    """Run the directions in plan, draw and store them; return the picture."""
    count, found = case.load.directions, list[InDirection]()
    for k in range(count):
        found.append(_in_direction(case, assemblage, 2.0 * math.pi * k / count))
        say(str(found[-1]))
    angles, associative, headline = (
        np.array([getattr(one, name) for one in found]) for name in ("angle", "associative", "headline")
    )
    if known := [one for one in found if not math.isnan(one.headline)]:
        say(f"least of those that have an answer: {min(known, key=lambda one: one.headline)}")
    stored = {"angle_degrees": np.degrees(angles), "associative": associative, "non_associative": headline}
    write_json(output / "directions.json", stored | {"gap": [one.gap.partition(",")[0] for one in found]})
    curves = {"associative": associative, "without dilation": headline}
    picture = output / "figures" / "directions.png"
    return space_pictures.save_polar(angles, curves, case.name, picture, case.project.language)

"""Tables of what limit analysis finds, in SI units.

Forces of a collapse state in joints, in sections of piers and spandrels, and reactions; the curve of rigid blocks in
large displacements.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple
from pathlib import Path

from orchestrator.assessment.section_forces import forces_on_j, reactions, section_forces
from orchestrator.assessment.tie_forces import TieForce, tie_forces
from orchestrator.limit_analysis.paper.limit_state import LimitAnalysis, LimitState
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.ties import Tie
from orchestrator.storage.files import write_csv

JOINT_FORCE_COLUMNS = (
    "joint", "block_i", "block_j", "start_x_m", "start_y_m", "end_x_m", "end_y_m", "normal_start_N", "normal_end_N",
    "normal_N", "shear_N", "force_on_j_x_N", "force_on_j_y_N", "opening_rate_start", "opening_rate_end", "slip_rate",
)  # fmt: skip
SECTION_COLUMNS = ("panel", "section", "x_m", "y_m", "depth_m", "N_N", "V_N", "M_Nm")
RIGID_CURVE_COLUMNS = ("mean_displacement_m", "load_multiplier")
REACTION_COLUMNS = ("support", "x_m", "y_m", "horizontal_N", "vertical_N", "moment_Nm")
TIE_COLUMNS = ("tie", "block", "other_block", "start_x_m", "start_y_m", "end_x_m", "end_y_m", "pull_N", "strength_N")


def write_forces(folder: Path, assemblage: Assemblage, state: LimitState, ties: Sequence[Tie] = ()) -> list[Path]:
    """Write joint_forces.csv, section_forces.csv and reactions.csv of a state, and tie_forces.csv of one with ties;
    return their paths.

    Rates are over the largest displacement of the mechanism; compression is positive, and so is what a tie pulls with.
    """
    pulls = tie_forces(assemblage.wall, ties, state.tie_forces)
    ids = [block.id for block in assemblage.wall.blocks]
    names = ("joint_forces.csv", "section_forces.csv", "reactions.csv")
    paths = [folder / name for name in names]
    write_csv(paths[0], JOINT_FORCE_COLUMNS, _joints(ids, assemblage, state))
    sections = (
        (one.panel, one.section, one.x, one.y, one.depth, one.normal, one.shear, one.moment)
        for one in section_forces(assemblage, state.joint_forces, pulls)
    )
    write_csv(paths[1], SECTION_COLUMNS, sections)
    write_csv(paths[2], REACTION_COLUMNS, map(astuple, reactions(assemblage, state.joint_forces, pulls)))
    return paths + _written_ties(folder / "tie_forces.csv", ties, pulls)


def _written_ties(path: Path, ties: Sequence[Tie], pulls: Sequence[TieForce]) -> list[Path]:
    """Write tie_forces.csv and return its path; nothing without ties."""
    if not ties:
        return []
    rows = (
        (pull.number, *(*tie.blocks, "")[:2], *tie.start, *tie.end, pull.pull, tie.strength)
        for tie, pull in zip(ties, pulls, strict=True)
    )
    write_csv(path, TIE_COLUMNS, rows)
    return [path]


def write_rigid_curve(folder: Path, analysis: LimitAnalysis) -> Path | None:
    """Write rigid_pushover.csv: displacement of the loads along the live load, on average over its forces, load
    multiplier and base shear, or live load where it is upright, of rigid blocks in large displacements; return its
    path, None without such a curve."""
    path = folder / "rigid_pushover.csv"
    if analysis.rigid_curve is None:
        return None
    upright, shear = analysis.upright_load, analysis.headline.horizontal_load
    force, size = ("base_shear_N", shear) if upright is None else ("live_load_N", abs(upright))
    rows = ((moved, load, load * size) for moved, load in analysis.rigid_curve.tolist())
    write_csv(path, (*RIGID_CURVE_COLUMNS, force), rows)
    return path


def _joints(ids: list[int], assemblage: Assemblage, state: LimitState) -> list[tuple[object, ...]]:
    forces, largest = state.joint_forces, state.mechanism.largest_displacement
    normal = forces[:, :2].sum(axis=1)
    on_j = forces_on_j(assemblage, forces)
    columns = [
        *assemblage.joints.start.T, *assemblage.joints.end.T,
        forces[:, 0], forces[:, 1], normal, forces[:, 2], on_j[:, 0], on_j[:, 1],
        state.mechanism.opening[:, 0] / largest, state.mechanism.opening[:, 1] / largest,
        state.mechanism.slip / largest,
    ]  # fmt: skip
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return [
        (k, ids[i], ids[j], *row) for k, ((i, j), row) in enumerate(zip(assemblage.joints.pairs, rows, strict=True))
    ]

"""One file of the run folder per value. Blocks are named by their id everywhere, never by their position."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.limit_analysis.paper.limit_state import LimitAnalysis, LimitState
from orchestrator.macroblocks.bodies import Bodies, Body
from orchestrator.macroblocks.criteria import Partition
from orchestrator.masonry.interfaces import STRENGTHS
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.wall import Wall
from orchestrator.pushover.increments import COLUMNS, WHOLE_NUMBERS, Increment, PushoverCurve
from orchestrator.storage.files import write_csv, write_json, write_text

JOINT_COLUMNS = (
    "joint", "block_i", "block_j", "start_x_m", "start_y_m", "end_x_m", "end_y_m", "length_m",
    "friction", "cohesion_N_per_m2", "tensile_strength_N_per_m2", "compressive_strength_N_per_m2",
    "normal_stiffness_N_per_m3", "shear_stiffness_N_per_m3",
)  # fmt: skip


def write_case(folder: Path, text: str) -> None:
    """Write case.toml as given."""
    write_text(folder / "case.toml", text)


def write_blocks(folder: Path, wall: Wall) -> None:
    """Write blocks.json, a block file that can be run again."""
    write_json(folder / "blocks.json", blocks_record(wall))


def write_joints(folder: Path, assemblage: Assemblage) -> None:
    """Write joints.csv, one row per joint; start -> end runs counter-clockwise round block_i."""
    ids, joints = _ids(assemblage.wall), assemblage.joints
    columns = zip(
        range(joints.count), ids[joints.i], ids[joints.j], *joints.start.T, *joints.end.T, joints.length,
        joints.friction, *(getattr(joints, name) for name in STRENGTHS), strict=True,
    )  # fmt: skip
    write_csv(folder / "joints.csv", JOINT_COLUMNS, columns)


def write_limit_analysis(folder: Path, wall: Wall, analysis: LimitAnalysis) -> None:
    """Write limit_analysis.json: every answer with its records, residuals, mechanism and joint forces."""
    write_json(folder / "limit_analysis.json", limit_analysis_record(wall, analysis))


def write_macroblocks(folder: Path, wall: Wall, partition: Partition, bodies: Bodies) -> None:
    """Write macroblocks.json: partition, tolerances, polygons and interfaces."""
    write_json(folder / "macroblocks.json", macroblocks_record(wall, partition, bodies))


def write_curve(folder: Path, curve: PushoverCurve) -> None:
    """Write curve.csv; the columns are the fields of PushoverCurve."""
    columns = [getattr(curve, name) for name in COLUMNS]
    write_csv(folder / "curve.csv", COLUMNS, zip(*columns, strict=True))


def write_ties(folder: Path, increments: Iterable[Increment], ties: int) -> None:
    """Write ties.csv, the force of every tie in N from increment to increment; nothing where there are none."""
    if ties:
        names = ("step", "load_multiplier", *(f"tie_{number}_N" for number in range(1, ties + 1)))
        rows = ((i.number, i.load_multiplier, *i.tie_force.tolist()) for i in increments)
        write_csv(folder / "ties.csv", names, rows)


def read_ties(folder: Path) -> dict[int, FloatArray]:
    """Return the force (m,) of every tie in N by increment, as `write_ties` wrote it; empty where there are none."""
    path = folder / "ties.csv"
    if not path.is_file():
        return {}
    table = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    return {int(row[0]): row[2:] for row in table}


def read_curve(folder: Path, stopped_because: str) -> PushoverCurve:
    """Return the curve that `write_curve` wrote."""
    with (folder / "curve.csv").open(encoding="utf-8") as file:
        table = np.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)
    arrays = {
        name: read_only(column, np.int64 if name in WHOLE_NUMBERS else np.float64)
        for name, column in zip(COLUMNS, table.T, strict=True)
    }
    return PushoverCurve(**arrays, stopped_because=stopped_because)


def blocks_record(wall: Wall) -> dict[str, Any]:
    """Return the wall in the block file format, SI units; every block states its own unit weight."""
    return {
        "name": wall.name,
        "units": {"length": "m", "unit_weight": "N/m3"},
        "thickness": wall.thickness,
        "unit_weight": wall.blocks[0].unit_weight,
        "friction": wall.friction,
        "blocks": [
            {"id": b.id, "polygon": b.polygon, "fixed": b.fixed, "unit_weight": b.unit_weight}
            | ({"material": b.material} if b.material else {})
            for b in wall.blocks
        ],
    } | ({"mortar": [[m.i, m.j, m.thickness] for m in wall.mortar]} if wall.mortar else {})


def limit_analysis_record(wall: Wall, analysis: LimitAnalysis) -> dict[str, Any]:
    """Return all limit states; velocities and loads (N, N m) are in the order of `blocks`, joint values
    in that of joints.csv. rigid_curve: pairs of displacement in m and multiplier."""
    names = ("associative", "associative_left", "sequence", "path", "lowest", "drawn")
    states = {name: getattr(analysis, name) for name in names}
    return {
        "loads": {"dead": analysis.loads.dead, "live": analysis.loads.live, "direction": analysis.loads.direction},
        "weight_N": analysis.weight,
        "vertical_load_N": analysis.vertical_load,
        "horizontal_load_N": analysis.horizontal_load,
        "tilting_table": analysis.tilting_table,
        "headline": analysis.headline.flow_rule,
        "non_associative_range": analysis.non_associative_range,
        "highest": analysis.highest,
        "last_rest": analysis.last_rest,
        "soft_from": analysis.soft_from,
        "interval": analysis.interval,
        "elastic_modulus_Pa": analysis.elastic_modulus,
        "rigid_curve": analysis.rigid_curve,
        "rigid_peak": analysis.rigid_peak,
        "pressed_peak": analysis.pressed_peak,
        "ways_out": analysis.ways_out,
        "is_bound": analysis.is_bound,
        "points_in_common": [{"stones": one.stones, "place": one.place} for one in analysis.points_in_common],
        "going_down": analysis.going_down,
        "factorisations": analysis.factorisations,
        "local_failures": [
            {
                "stones": failure.stones,
                "share": failure.share,
                "multipliers": failure.multipliers,
                "state": _state_record(failure.state),
            }
            for failure in analysis.local_failures
        ],
        "remarks": analysis.remarks,
        "seconds": analysis.seconds,
        "blocks": _ids(wall),
        **{name: state and _state_record(state) for name, state in states.items()},
    }


def macroblocks_record(wall: Wall, partition: Partition, bodies: Bodies) -> dict[str, Any]:
    """Return partition, tolerances (null = no condition), outlines with holes, and interfaces."""
    ids = _ids(wall)
    return {
        "count": partition.count,
        "body_of_block": [{"block": i, "body": b} for i, b in zip(ids, partition.body_of_block, strict=True)],
        "tolerances": partition.tolerances and asdict(partition.tolerances),
        "vanished_joints": partition.vanished_joints,
        "transitive_joints": partition.transitive_joints,
        "remarks": partition.remarks,
        "bodies": [_body_record(body, ids) for body in bodies.bodies],
        "interfaces": {
            "body_i": bodies.interfaces.i,
            "body_j": bodies.interfaces.j,
            "start_m": bodies.interfaces.start,
            "end_m": bodies.interfaces.end,
            "friction": bodies.interfaces.friction,
            "joint": bodies.joint,
        },
    }


def _state_record(state: LimitState) -> dict[str, Any]:
    return {
        "flow_rule": state.flow_rule,
        "load_multiplier": state.load_multiplier,
        "base_shear_N": state.base_shear,
        "converged": state.converged,
        "equilibrium_residual": state.equilibrium_residual,
        "yield_residual": state.yield_residual,
        "power_residual": state.power_residual,
        "dilation": state.dilation,
        "horizontal_load_N": state.horizontal_load,
        "live_total_N": state.live_total,
        "records": [asdict(record) for record in state.records],
        "joint_forces_N": state.joint_forces,
        "tie_forces_N": state.tie_forces,
        "mechanism": {
            "block_velocities": state.mechanism.velocities,
            "joint_opening": state.mechanism.opening,
            "joint_slip": state.mechanism.slip,
            "largest_displacement": state.mechanism.largest_displacement,
        },
    }


def _body_record(body: Body, ids: np.ndarray) -> dict[str, Any]:
    return {
        "number": body.number,
        "fixed": body.fixed,
        "unit_weight_N_per_m3": body.unit_weight,
        "blocks": ids[body.blocks],
        "exterior_m": body.exterior,
        "holes_m": body.holes,
    }


def _ids(wall: Wall) -> np.ndarray:
    return np.array([block.id for block in wall.blocks])

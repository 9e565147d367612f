"""Files of the run folder -> the values that `values.py` wrote, as far as pictures and the report need them."""

from __future__ import annotations

from math import inf
from pathlib import Path
from typing import Any

from orchestrator.basis.arrays import read_only
from orchestrator.limit_analysis.paper.limit_state import (
    LimitAnalysis,
    LimitState,
    LinearProgramRecord,
    LocalFailure,
    Mechanism,
)
from orchestrator.macroblocks.criteria import MacroblockSettings, Partition
from orchestrator.masonry.wall import Wall
from orchestrator.storage.files import read_json

STATES = ("associative", "associative_left", "sequence", "path", "lowest")


def read_limit_analysis(folder: Path) -> LimitAnalysis:
    """Return what `write_limit_analysis` wrote."""
    record = read_json(folder / "limit_analysis.json")
    return LimitAnalysis(
        load_direction=record["load_direction"],
        weight=record["weight_N"],
        horizontal_load=record["horizontal_load_N"],
        tilting_table=record["tilting_table"],
        remarks=tuple(record["remarks"]),
        seconds=record["seconds"],
        highest=record["highest"],
        last_rest=record["last_rest"],
        soft_from=record["soft_from"],
        interval=record["interval"] and tuple(record["interval"]),
        local_failures=tuple(
            LocalFailure(tuple(f["stones"]), f["share"], tuple(f["multipliers"]), _state(f["state"]))
            for f in record["local_failures"]
        ),
        **{name: record[name] and _state(record[name]) for name in STATES},
    )


def read_macroblocks(folder: Path, wall: Wall) -> Partition:
    """Return the partition that `write_macroblocks` wrote."""
    record = read_json(folder / "macroblocks.json")
    body = {entry["block"]: entry["body"] for entry in record["body_of_block"]}
    tolerances: dict[str, Any] = {k: inf if v is None else v for k, v in (record["tolerances"] or {}).items()}
    return Partition(
        body_of_block=read_only([body[block.id] for block in wall.blocks], int),
        count=record["count"],
        vanished_joints=read_only(record["vanished_joints"], int),
        transitive_joints=read_only(record["transitive_joints"], int),
        tolerances=MacroblockSettings(**tolerances) if tolerances else None,
        remarks=tuple(record["remarks"]),
    )


def _state(record: dict[str, Any]) -> LimitState:
    moves = record["mechanism"]
    return LimitState(
        flow_rule=record["flow_rule"],
        load_multiplier=record["load_multiplier"],
        joint_forces=read_only(record["joint_forces_N"]),
        mechanism=Mechanism(
            velocities=read_only(moves["block_velocities"]),
            opening=read_only(moves["joint_opening"]),
            slip=read_only(moves["joint_slip"]),
            largest_displacement=moves["largest_displacement"],
        ),
        records=tuple(LinearProgramRecord(**entry) for entry in record["records"]),
        converged=record["converged"],
        equilibrium_residual=record["equilibrium_residual"],
        yield_residual=record["yield_residual"],
        power_residual=record["power_residual"],
        dilation=record["dilation"],
    )

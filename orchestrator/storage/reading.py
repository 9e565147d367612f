"""Files of the run folder -> the values that `values.py` wrote, as far as pictures and the report need them."""

from __future__ import annotations

import json
from math import inf
from pathlib import Path
from typing import Any

from orchestrator.basis.arrays import read_only
from orchestrator.limit_analysis.paper.limit_state import LimitAnalysis
from orchestrator.macroblocks.criteria import MacroblockSettings, Partition
from orchestrator.masonry.wall import Wall
from orchestrator.storage.files import read_json

ARRAYS = {
    "joint_forces": "joint_forces_N",
    "tie_forces": "tie_forces_N",
    "velocities": "block_velocities",
    "opening": "joint_opening",
    "slip": "joint_slip",
    "dead": "dead",
    "live": "live",
    "direction": "direction",
    "rigid_curve": "rigid_curve",
}
SUMS = ("weight", "vertical_load", "horizontal_load", "live_total")
STORED_AS = {name: f"{name}_N" for name in SUMS} | {"elastic_modulus": "elastic_modulus_Pa"} | ARRAYS
"""keys of limit_analysis.json by the fields whose names they are not"""


def read_limit_analysis(folder: Path) -> LimitAnalysis:
    """Return what `write_limit_analysis` wrote. Raises OSError, and ValueError for a file that holds something else."""
    from pydantic import ConfigDict, TypeAdapter, ValidationError

    def with_arrays(record: dict[str, Any]) -> dict[str, Any]:
        return record | {key: read_only(record[key]) for key in ARRAYS.values() if record.get(key) is not None}

    rules = ConfigDict(alias_generator=lambda name: STORED_AS.get(name, name), arbitrary_types_allowed=True)
    record = json.loads((folder / "limit_analysis.json").read_text(encoding="utf-8"), object_hook=with_arrays)
    reader: TypeAdapter[Any] = TypeAdapter(LimitAnalysis | None, config=rules)
    try:
        analysis: LimitAnalysis = reader.validate_python(record)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise ValueError(f"limit_analysis.json: {place}: {first['msg']}") from error
    return analysis


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

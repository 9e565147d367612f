"""Macroblocks: blocks that move as one body in the collapse mechanism, merged by criteria (3) and (4)."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Annotated, Literal

from annotated_types import Ge

from orchestrator.limit_analysis.state import Scale
from orchestrator.masonry.wall import IntArray
from orchestrator.units import Unit


@dataclass(frozen=True, slots=True)
class MacroblockSettings:
    """Tolerances of criteria (3) and (4); `inf` means no condition. Velocities are those of the mechanism in `scale`."""

    scale: Scale = "unit_displacement"
    evaluate_at: Literal["midpoint", "ends"] = "midpoint"
    normal: Annotated[float, Ge(0)] = 1e-3
    """tol_n: largest relative normal displacement at the joint"""
    tangential: Annotated[float, Ge(0)] = inf
    """tol_s: largest relative tangential displacement at the joint"""
    rotation: Annotated[float, Ge(0)] = inf
    """tol_r: largest relative rotation"""
    centre_distance: Annotated[float, Unit("m"), Ge(0)] = 0.45
    """tol_D: largest distance between the centres of rotation"""


@dataclass(frozen=True, eq=False, slots=True)
class Partition:
    """Which body each block belongs to.

    body_of_block (n,): moving bodies are numbered 0 ... count-1 in the order of their first block; supports follow,
    one body each (count, count+1, ...), never merged.
    vanished_joints (v,): joints inside a body; of these, `transitive_joints` exceed a tolerance themselves: their blocks
    are joined through others. `tolerances` is None for partitions that come from no mechanism.
    """

    body_of_block: IntArray
    count: int
    vanished_joints: IntArray
    transitive_joints: IntArray
    tolerances: MacroblockSettings | None
    remarks: tuple[str, ...] = ()

"""The tolerance study: the partitions of a grid of tolerances tol_n x tol_D.

Szabo, Funari and Lourenco 2023, Table 1. Many cells of the grid share a partition: it is run once.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import inf
from typing import Annotated

from annotated_types import MinLen

from orchestrator.basis.checked import Checked
from orchestrator.limit_analysis import Mechanism
from orchestrator.limit_analysis.paper.limit_state import Scale
from orchestrator.macroblocks.criteria import CentreDistance, MacroblockSettings, Partition, RelativeTolerance, merged
from orchestrator.masonry.joints import Assemblage


@dataclass(frozen=True, slots=True)
class StudySettings(Checked):
    """The grid of `study`; tol_s, tol_r and where they are evaluated are those of [macroblocks].

    The default is the paper's grid in the scale that fits its numbers: the mechanism as the linear program returns it,
    f_L . u = 1 in N and m (`unit_power`). `unit_displacement` is what the paper's text says.
    """

    scale: Scale = "unit_power"
    """what tol_n is a part of, as in [macroblocks]"""
    tol_n: Annotated[tuple[RelativeTolerance, ...], MinLen(1)] = (2.5e-6, 3.75e-6, 7.5e-6, 22.5e-6, inf)
    """one row each"""
    tol_d: Annotated[tuple[CentreDistance, ...], MinLen(1)] = (0.0, 1e-3, 0.45, 0.9, inf)
    """tol_D of the paper, one column each"""


@dataclass(frozen=True, eq=False, slots=True)
class Cell:
    """One pair of tolerances (tol_n in the study's scale, tol_d in m) and the partition that it gives."""

    tol_n: float
    tol_d: float
    partition: Partition


def grid(
    assemblage: Assemblage, mechanism: Mechanism, criteria: MacroblockSettings, settings: StudySettings
) -> tuple[Cell, ...]:
    """Return the cells row by row (tol_n by tol_n). Raises CaseError for a tolerance below the mechanism's noise."""
    criteria, cells = replace(criteria, choose="tolerances", scale=settings.scale), []
    for tol_n in settings.tol_n:
        for tol_d in settings.tol_d:
            tolerances = replace(criteria, tol_n=tol_n, tol_d=tol_d)
            cells.append(Cell(tol_n, tol_d, merged(assemblage, mechanism, tolerances)))
    return tuple(cells)


def key(partition: Partition) -> bytes:
    """Return what two partitions share exactly if they put the same blocks together."""
    return partition.body_of_block.tobytes()


def distinct(partitions: Iterable[Partition]) -> tuple[Partition, ...]:
    """Return the different partitions, each as it first appears."""
    by_bodies: dict[bytes, Partition] = {}
    for partition in partitions:
        by_bodies.setdefault(key(partition), partition)
    return tuple(by_bodies.values())

"""Ties at a collapse state: what each pulls with, where it crosses a section of the wall, and what its anchor bears.

A tie pulls its start towards its end and its end towards its start, by the same force. An anchor, and a support that a
tie is fixed to, exert that force on the wall: it is a reaction of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.masonry.ties import Tie, ends_of
from orchestrator.masonry.wall import Wall


@dataclass(frozen=True, eq=False, slots=True)
class TieForce:
    """A tie, numbered from 1, and its pull in N (negative: it pushes). points (2, 2) in m: start and end; blocks: their
    positions, ANCHOR for none; held: which end cannot move, None between two blocks that can."""

    number: int
    points: FloatArray
    blocks: tuple[int, int]
    held: int | None
    pull: float

    def on(self, end: int) -> FloatArray:
        """Return the force (2,) in N on what is at its start (0) or at its end (1)."""
        along = self.points[1 - end] - self.points[end]
        return np.asarray(self.pull * along / np.linalg.norm(along))

    def crossing(self, beyond: FloatArray, axis: int, at: float) -> tuple[FloatArray, FloatArray] | None:
        """Return the force (2,) in N on what is before a cut across `axis` at `at` m, and the point (2,) between the
        ends that is nearest to the cut; None where both ends are on one side.

        beyond (n,): which part of each block is beyond the cut, for that part of the force; supports are not.
        """
        first, last = (0.0 if end == self.held else float(beyond[self.blocks[end]]) for end in (0, 1))
        if first == last:
            return None
        before, after = (self.points[1], self.points[0]) if first > last else (self.points[0], self.points[1])
        length = after[axis] - before[axis]
        part = np.clip((at - before[axis]) / length, 0.0, 1.0) if length else 1.0
        return abs(last - first) * self.on(int(first > last)), before + part * (after - before)


def tie_forces(wall: Wall, ties: Sequence[Tie], pull: FloatArray) -> tuple[TieForce, ...]:
    """Return the forces of all ties of a wall; pull (m,) in N as `LimitState.tie_forces`."""
    fixed = np.append([block.fixed for block in wall.blocks], True)  # the last for ANCHOR
    return tuple(
        TieForce(
            number=number,
            points=read_only([tie.start, tie.end]),
            blocks=(int(ends[0]), int(ends[1])),
            held=next((end for end in (0, 1) if fixed[ends[end]]), None),
            pull=force,
        )
        for number, (tie, ends, force) in enumerate(zip(ties, ends_of(wall, ties), pull.tolist(), strict=True), 1)
    )

"""Bodies: the outlines of a partition, with holes, and what remains of the joints between them."""

from __future__ import annotations

from dataclasses import dataclass

from orchestrator.masonry.wall import FloatArray, IntArray


@dataclass(frozen=True, eq=False, slots=True)
class Body:
    """One region of the wall. exterior (n, 2) counter-clockwise, holes (m, 2) clockwise, not closed, in m.

    Every end of a joint that lies on the outline is a vertex of it (imprinted), on both sides of the joint.
    """

    number: int
    exterior: FloatArray
    holes: tuple[FloatArray, ...]
    fixed: bool
    unit_weight: float
    """weight / volume of its blocks, N/m3"""
    blocks: IntArray


@dataclass(frozen=True, eq=False, slots=True)
class Bodies:
    """Bodies of one thickness (m), moving ones first, and their k interfaces, each a straight segment.

    body_i, body_j (k,), start, end (k, 2) in m (convention of joints.py: start -> end is counter-clockwise round i, the
    normal points from i to j), friction (k,), joint (k,): the joint of the assemblage it comes from.
    """

    bodies: tuple[Body, ...]
    moving: int
    thickness: float
    body_i: IntArray
    body_j: IntArray
    start: FloatArray
    end: FloatArray
    friction: FloatArray
    joint: IntArray

"""Outlines, blocks and stored walls that many tests need."""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import read_only
from orchestrator.masonry.interfaces import straight_interfaces
from orchestrator.masonry.joints import Assemblage, JointSettings, find_joints
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import Block, Wall
from tests.support.paths import DATA


def rectangle(x: float, y: float, width: float, height: float) -> np.ndarray:
    """Return the outline (4, 2), in m, with its lower left corner at (x, y)."""
    return between(x, y, x + width, y + height)


def between(left: float, bottom: float, right: float, top: float) -> np.ndarray:
    """Return the outline (4, 2), in m, of a rectangle between two x and two y."""
    return np.array([[left, bottom], [right, bottom], [right, top], [left, top]], float)


def upright(number, x, y, width, height, unit_weight=20e3, fixed=False) -> Block:
    """Return a rectangular block with its lower left corner at (x, y)."""
    return Block(number, read_only(rectangle(x, y, width, height)), fixed, unit_weight)


def of_file(name: str) -> Assemblage:
    """Return the assemblage of a block file of tests/data."""
    return find_joints(read_blocks(DATA / f"{name}.json"), JointSettings())


def four_blocks(name: str = "hand made") -> Assemblage:
    """Support 10, blocks 11 and 12 side by side on it, block 13 on both: 5 joints."""
    boxes = [(0, -0.2, 2, 0), (0, 0, 1, 0.5), (1, 0, 2, 0.5), (0.5, 0.5, 1.5, 1)]
    blocks = tuple(Block(10 + n, between(*box), n == 0, 25e3) for n, box in enumerate(boxes))
    i, j = np.array([[0, 0, 1, 1, 2], [1, 2, 2, 3, 3]])
    start = np.array([[1, 0], [2, 0], [1, 0], [1, 0.5], [1.5, 0.5]])
    end = np.array([[0, 0], [1, 0], [1, 0.5], [0.5, 0.5], [1, 0.5]])
    joints = straight_interfaces(i, j, start, end, 0.1, np.full(5, 0.65))
    return Assemblage(Wall(name, blocks, 0.1, 0.65), joints)

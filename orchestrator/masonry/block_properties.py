"""Areas, centroids and weights of blocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Ge, Le

from orchestrator.basis.arrays import FloatArray, IntArray, fingerprint
from orchestrator.basis.errors import CaseError
from orchestrator.basis.units import Unit
from orchestrator.geometry.rigid import cross
from orchestrator.masonry.wall import Wall

ElasticModulus = Annotated[float, Ge(1e3), Le(1e15), Unit("Pa")]
ELASTIC_MODULUS = 3.5e9
"""Young's modulus of stones of which nothing is known, Pa."""
MOST_OF_WEIGHT = 1e6
"""Times the mean weight of a block: larger forces and strengths leave no digits for the weights beside them."""


def block_areas(wall: Wall) -> FloatArray:
    """Areas (n,) in m2."""
    outlines = outlines_of(wall)
    arm = outlines.corner - outlines.corner[outlines.first][outlines.block]
    return 0.5 * np.add.reduceat(cross(arm, arm[outlines.following]), outlines.first)


def block_centroids(wall: Wall) -> FloatArray:
    """Centroids (n, 2) in m, as `polygon_centroid`."""
    outlines = outlines_of(wall)
    origin = outlines.corner[outlines.first]
    arm = outlines.corner - origin[outlines.block]
    twice_area = cross(arm, arm[outlines.following])
    first_moments = np.add.reduceat((arm + arm[outlines.following]) * twice_area[:, None], outlines.first)
    return origin + first_moments / (3.0 * np.add.reduceat(twice_area, outlines.first))[:, None]


@dataclass(frozen=True, eq=False, slots=True)
class Outlines:
    """The outlines of n blocks, one behind the other: corner (m, 2) in m, block (m,), following (m,) the number of the
    next corner of the same block, first (n,) that of each block's first corner."""

    corner: FloatArray
    block: IntArray
    following: IntArray
    first: IntArray


def outlines_of(wall: Wall) -> Outlines:
    """Return the corners of all blocks as arrays."""
    counts = np.array([len(block.polygon) for block in wall.blocks])
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    following = np.arange(1, counts.sum() + 1)
    following[first + counts - 1] = first
    corner = np.concatenate([block.polygon for block in wall.blocks])
    return Outlines(corner, np.repeat(np.arange(len(counts)), counts), following, first)


def fingerprint_of_blocks(wall: Wall) -> str:
    """Return a text that only blocks with the same ids, outlines, weights and supports have, in the same order."""
    outlines, blocks = outlines_of(wall), wall.blocks
    ids, fixed = [block.id for block in blocks], [block.fixed for block in blocks]
    return fingerprint(ids, fixed, outlines.corner, outlines.first, block_weights(wall))


def block_moduli(wall: Wall, elastic_modulus: float) -> FloatArray:
    """Young's moduli (n,) in Pa: the given one where a block has none of its own."""
    own = [block.elastic_modulus for block in wall.blocks]
    return np.array([elastic_modulus if modulus is None else modulus for modulus in own])


def block_thicknesses(wall: Wall) -> FloatArray:
    """Thicknesses (n,) in m: the wall's where a block has none of its own."""
    return np.array([wall.thickness if block.thickness is None else block.thickness for block in wall.blocks])


def thinner(wall: Wall, i: IntArray, j: IntArray) -> FloatArray:
    """Thicknesses (k,) in m of the thinner of blocks i and j (k,): widths of joints, out of the wall's plane."""
    thickness = block_thicknesses(wall)
    return np.minimum(thickness[i], thickness[j])


def block_weights(wall: Wall) -> FloatArray:
    """Weights (n,) in N, supports included."""
    return block_areas(wall) * block_thicknesses(wall) * np.array([block.unit_weight for block in wall.blocks])


def refuse_beyond_weight(weights: FloatArray, force: float, key: str) -> None:
    """Raise CaseError for a force or a strength (N) out of proportion with the weights (m,) of the blocks that move."""
    if len(weights) and not force <= MOST_OF_WEIGHT * float(weights.mean()):
        problem = f"comes to {force:.3g} N, more than {MOST_OF_WEIGHT:g} times the mean weight of a block"
        raise CaseError(key, problem, f"that is {weights.mean():.3g} N: is the unit right?")


def weights_that_move(wall: Wall) -> FloatArray:
    """Return the weights (m,) in N of the free blocks."""
    return block_weights(wall)[[not block.fixed for block in wall.blocks]]


def rounded_up(length: float) -> float:
    """Return a little more than `length` (mm), with one digit: a tolerance that somebody may try."""
    unit = 10.0 ** np.floor(np.log10(max(1.2 * length, 1e-6)))
    return float(np.ceil(1.2 * length / unit) * unit)

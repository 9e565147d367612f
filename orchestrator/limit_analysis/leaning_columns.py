"""Columns that lean: what their stones take from the multiplier as they give way at edges and bend.

Rigid blocks on elastic joints know little of either (`pytest tests/verification/test_leaning_columns.py`). What stands
on a column and on other stones too, as stones of a wall do whose head joints are open, holds its top: nothing is said
of it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from orchestrator.basis.arrays import BoolArray
from orchestrator.basis.printed import percent_of
from orchestrator.limit_analysis.paper.limit_state import LimitState
from orchestrator.loads.block_loads import Loads
from orchestrator.masonry.block_properties import block_centroids, block_weights
from orchestrator.masonry.interfaces import Interfaces
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.pressed_edges import Columns, columns_on, compliances, is_at_end, is_level, left_of_column

TOLD = 0.1
"""part of what it bears as drawn that a column has to lose to be told"""
ALL = 0.01
"""part of the force on a bed by which it may differ from the load on its column for that to be all"""


def column_words(assemblage: Assemblage, loads: Loads, state: LimitState, elastic_modulus: float) -> Iterator[str]:
    """Yield which column leans on an edge in a state, and about what it loses to that, of the one that loses most.

    elastic_modulus: of stones that have none of their own, Pa.
    """
    wall, joints = assemblage.wall, assemblage.joints
    normal = np.maximum(state.joint_forces[: joints.count, :2], 0.0)
    force = normal.sum(axis=1)
    columns = columns_on(wall, joints, force)
    leaning = np.flatnonzero(is_at_end(normal) & _under_free_columns(joints, columns))
    if not len(leaning):
        return
    beds, force, width = joints.part(leaning), force[leaning], columns.width[leaning]
    at_start = normal[leaning, 0] > normal[leaning, 1]
    end = np.where(at_start[:, None], beds.start, beds.end)
    height, lever = columns.height[leaning], 0.5 * width
    for k, column in enumerate(columns.of_joint[leaning]):
        arm = block_centroids(wall) - end[k]
        on_it = (columns.of_block == column) & (arm[:, 1] > 0.0)
        own = block_weights(wall)[on_it].sum()
        height[k] *= 1.0 - 0.5 * min(own / force[k], 1.0)
        dead = loads.dead[on_it]
        if abs(dead[:, 1].sum() + force[k]) < ALL * force[k]:
            lever[k] = abs((arm[on_it, 0] * dead[:, 1] + dead[:, 2]).sum()) / force[k]
    soft = compliances(wall, beds, elastic_modulus) * (beds.length / beds.area)[:, None]
    left = left_of_column(force, height, width, lever, soft)
    worst = int(np.argmin(left))
    if left[worst] > 1.0 - TOLD:
        return
    pair = " and ".join(str(wall.blocks[side[worst]].id) for side in (beds.i, beds.j))
    yield (
        f"WARNING: what leans on the joint of blocks {pair} loses about {percent_of(1.0 - left[worst])} of what it "
        "bears as drawn, as stones give way at the edge and bend: rigid blocks know little of it, finite elements do "
        "(`run`)"
    )


def _under_free_columns(joints: Interfaces, columns: Columns) -> BoolArray:
    """Return which joints (k,) are beds of a column on which nothing stands that stands on other stones too."""
    bed, up = is_level(joints), joints.normal[:, 1] > 0.0
    lower, upper = np.where(up, joints.i, joints.j), np.where(up, joints.j, joints.i)
    on_others = np.isin(upper, upper[bed & (columns.of_block[lower] < 0)])
    is_top = bed & (columns.of_block[lower] >= 0) & (columns.of_block[upper] != columns.of_block[lower])
    held = np.isin(columns.of_joint, columns.of_block[lower[is_top & on_others]])
    return np.asarray(bed & (columns.of_joint >= 0) & ~held)

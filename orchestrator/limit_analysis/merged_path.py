"""Whether macroblocks fail under the load under which every stone does: loaded from gravity as rigid bodies.

Bodies may have the state of the stones and yet not meet it: joints that are gone held the wall's self-stress together,
and loading leads the bodies on to another, higher one. Their path on elastic joints tells.
"""

from __future__ import annotations

from orchestrator.joints import Assemblage
from orchestrator.limit_analysis.direct_loading import agrees
from orchestrator.limit_analysis.elastic_contact import STIFFNESSES
from orchestrator.limit_analysis.loading import with_joints
from orchestrator.limit_analysis.loads import Loads
from orchestrator.limit_analysis.merged_blocks import merged_problem
from orchestrator.limit_analysis.problem import Problem
from orchestrator.masonry.wall import IntArray


def bodies_fail_between(
    assemblage: Assemblage,
    body_of_block: IntArray,
    load_direction: int,
    low: float,
    high: float,
    loads: Loads | None = None,
) -> bool:
    """Whether blocks held together (body_of_block (n,) as in Partition) rest at a multiplier and not at a higher one.

    Joints between bodies have the stiffness that they have between stones. On doubt the answer is no.
    """
    equilibrium, strength = merged_problem(assemblage, body_of_block, load_direction, loads)
    remains = body_of_block[assemblage.block_i] != body_of_block[assemblage.block_j]
    problem = Problem(with_joints(assemblage, remains), equilibrium, strength)
    return agrees(problem, low, high, STIFFNESSES[0])

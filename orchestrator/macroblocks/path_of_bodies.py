"""Whether bodies of several stones, loaded from gravity as rigid ones, fail where the wall fails stone by stone.

That bodies have a limit state near that of the stones does not say that loading leads to it: states of walls without
dilation are not unique. Four bodies of 47 stones (random rubble) had one at 0.370, the stones 0.368; loaded, they came
down at 0.208, the stack at the edge sliding by itself, in finite elements as well as here.
"""

from __future__ import annotations

import logging

import numpy as np

from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.limit_analysis.search.elastic_contact import STIFFNESSES, elastic_wall
from orchestrator.limit_analysis.search.loading import SAME_ANSWER
from orchestrator.limit_analysis.search.pushing import Pushing
from orchestrator.macroblocks.criteria import Partition
from orchestrator.macroblocks.merged_blocks import merged_problem
from orchestrator.masonry.joints import Assemblage

logger = logging.getLogger(__name__)

UNSHARP = 1e-2
"""part of the associative multiplier by which bodies may stop before a last rest that no state closed"""


def as_far_apart(margin: float) -> float:
    """Return by what part multipliers may differ: the margin, and what two paths of one wall may differ by."""
    return margin + SAME_ANSWER


def bodies_fail_alike(assemblage: Assemblage, analysis: LimitAnalysis, partition: Partition, margin: float) -> bool:
    """Whether bodies rest up to the headline less what it may differ by, and no longer above it."""
    return off_headline(assemblage, analysis, partition, as_far_apart(margin)) <= as_far_apart(margin)


def off_headline(assemblage: Assemblage, analysis: LimitAnalysis, partition: Partition, most: float) -> float:
    """Return by what part of the headline the last rests of bodies lie off it, with joints of both stiffnesses.

    Where the headline is an interval it is one for the bodies, too; before a last rest that no state closed bodies may
    stop UNSHARP earlier. What is off by more than `most` is not looked at any further.
    """
    equilibrium, friction = merged_problem(assemblage, partition.body_of_block, analysis.loads)
    low, high = analysis.interval or (analysis.headline.load_multiplier,) * 2
    low -= 0.0 if analysis.headline.converged else UNSHARP * analysis.associative.load_multiplier
    logger.info("macroblocks: loading %d bodies", partition.count)
    off = 0.0
    bodies, modulus = partition.body_of_block, analysis.elastic_modulus
    for stiffness in STIFFNESSES:
        pushing = Pushing(elastic_wall(assemblage, equilibrium, friction, stiffness, bodies, modulus))
        stands = pushing.gravity()
        if not stands.rests:
            return np.inf
        way = pushing.pushed(stands, analysis.associative.load_multiplier)
        last = way.peak.multiplier / pushing.wall.problem.per_multiplier
        off = max(off, 1.0 - last / low, last / high - 1.0)
        if off > most:
            break
    return off

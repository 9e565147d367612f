"""Whether bodies of several stones, loaded from gravity as rigid ones, fail where the wall fails stone by stone.

That bodies have a limit state near that of the stones does not say that loading leads to it: states of walls without
dilation are not unique. Four bodies of 47 stones (random rubble) had one at 0.370, the stones 0.368; loaded, they came
down at 0.208, the stack at the edge sliding by itself, in finite elements as well as here.
"""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np

from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.limit_analysis.search.elastic_contact import STIFFNESSES, ElasticWall, elastic_wall
from orchestrator.limit_analysis.search.loading_path import SAME_ANSWER
from orchestrator.limit_analysis.search.overdamped import Moved
from orchestrator.limit_analysis.search.pushing import Pushing
from orchestrator.macroblocks.criteria import Partition
from orchestrator.macroblocks.merged_blocks import merged_problem
from orchestrator.masonry.joints import Assemblage

logger = logging.getLogger(__name__)

UNSHARP = 1e-2
"""part of the associative multiplier by which bodies may stop before a last rest that no state closed"""

LEAST_WORK = 50
"""bodies whose factorisation costs twice what it costs however few they are (0.4 ms, and 8.5 us more each)"""


def work_of(bodies: int) -> int:
    """Return what a factorisation of so many bodies costs, in what each body adds."""
    return LEAST_WORK + bodies


def as_far_apart(margin: float) -> float:
    """Return by what part multipliers may differ: the margin, and what two paths of one wall may differ by."""
    return margin + SAME_ANSWER


class PushedBodies(Pushing):
    """Bodies that are pushed until they bear more than `enough` (scaled)."""

    def __init__(self, wall: ElasticWall, enough: float) -> None:
        """Nothing has moved yet."""
        super().__init__(wall)
        self.enough = enough

    def is_followed(self, here: Moved, peak: Moved) -> bool:
        """Whether bodies are pushed any further than where they are."""
        return peak.multiplier <= self.enough and super().is_followed(here, peak)

    def held(self, peak: Moved, last: Moved, more: float, fine: float) -> Moved:
        """Return the rest above a peak, or the motion there; where they bear enough nothing is held.

        From peak to peak in small steps: held at once under the load that bodies are to bear, some come to a rest that
        no growing load leads to (four bodies of 47 stones of rubble at 0.36, which slide at 0.25).
        """
        if peak.multiplier > self.enough:
            return replace(peak, rests=False)
        return super().held(peak, last, more, fine)


def off_headline(
    assemblage: Assemblage, analysis: LimitAnalysis, partition: Partition, most: float
) -> tuple[float, int]:
    """Return by what part of the headline the last rests of bodies lie off it, with joints of both stiffnesses, and
    what work that was (`work_of` times factorisations).

    Where the headline is an interval it is one for the bodies, too; before a last rest that no state closed bodies may
    stop UNSHARP earlier. What is off by more than `most` is not looked at any further.
    """
    equilibrium, friction = merged_problem(assemblage, partition.body_of_block, analysis.loads)
    equilibrium = equilibrium.measured_by_load(analysis.associative.load_multiplier)
    low, high = analysis.interval or (analysis.headline.load_multiplier,) * 2
    low -= 0.0 if analysis.headline.converged else UNSHARP * analysis.associative.load_multiplier
    logger.info("macroblocks: loading %d bodies", partition.count)
    off, spent = 0.0, 0
    bodies, modulus = partition.body_of_block, analysis.elastic_modulus
    for stiffness in STIFFNESSES:
        wall = elastic_wall(assemblage, equilibrium, friction, stiffness, bodies, modulus)
        scale = wall.problem.per_multiplier
        pushing = PushedBodies(wall, (1.0 + most) * high * scale)
        stands = pushing.gravity()
        last = 0.0
        if stands.rests:
            way = pushing.pushed(stands, analysis.associative.load_multiplier)
            last = way.peak.multiplier / scale
        spent += pushing.spent * work_of(partition.count)
        off = max(off, 1.0 - last / low if low > 0.0 else 0.0, last / high - 1.0)
        if off > most or not stands.rests:
            break
    return off if stands.rests else np.inf, spent

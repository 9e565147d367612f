"""A wall with everything that comes before its finite elements."""

from __future__ import annotations

from dataclasses import dataclass

from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.limit_analysis.turning_joints import pressed_at_hinges
from orchestrator.macroblocks.bodies import Bodies, make_bodies
from orchestrator.macroblocks.criteria import Partition, one_body_per_block
from orchestrator.masonry.joints import Assemblage
from orchestrator.settings.case import ModelName


@dataclass(frozen=True, eq=False, slots=True)
class Segmented:
    """Joints, limit analysis and macroblocks of a wall; bodies: of the macroblocks, as they are meshed.

    softening: opening at which bonds have gone, m.
    """

    assemblage: Assemblage
    analysis: LimitAnalysis
    partition: Partition
    bodies: Bodies
    softening: float

    @classmethod
    def into(cls, assemblage: Assemblage, analysis: LimitAnalysis, partition: Partition, softening: float) -> Segmented:
        """Return a wall with the bodies of a partition."""
        forces, modulus = analysis.headline.joint_forces, analysis.elastic_modulus
        hinges = pressed_at_hinges(assemblage, analysis)
        bodies = make_bodies(assemblage, partition, forces, modulus, softening, hinges)
        return cls(assemblage, analysis, partition, bodies, softening)

    def divided(self, partition: Partition) -> Segmented:
        """Return the wall with another partition."""
        return Segmented.into(self.assemblage, self.analysis, partition, self.softening)

    def bodies_of(self, model: ModelName) -> Bodies:
        """Return the bodies of a model: the macroblocks, or every stone."""
        return self.bodies if model == "macro" else self.divided(one_body_per_block(self.assemblage)).bodies

"""A wall with everything that comes before its finite elements."""

from __future__ import annotations

from dataclasses import dataclass

from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.macroblocks.bodies import Bodies, make_bodies
from orchestrator.macroblocks.criteria import Partition, one_body_per_block
from orchestrator.masonry.joints import Assemblage
from orchestrator.settings.case import ModelName


@dataclass(frozen=True, eq=False, slots=True)
class Segmented:
    """Joints, limit analysis and macroblocks of a wall; bodies: of the macroblocks, as they are meshed."""

    assemblage: Assemblage
    analysis: LimitAnalysis
    partition: Partition
    bodies: Bodies

    @classmethod
    def into(cls, assemblage: Assemblage, analysis: LimitAnalysis, partition: Partition) -> Segmented:
        """Return a wall with the bodies of a partition."""
        bodies = make_bodies(assemblage, partition, analysis.headline.joint_forces)
        return cls(assemblage, analysis, partition, bodies)

    def divided(self, partition: Partition) -> Segmented:
        """Return the wall with another partition."""
        return Segmented.into(self.assemblage, self.analysis, partition)

    def bodies_of(self, model: ModelName) -> Bodies:
        """Return the bodies of a model: the macroblocks, or every stone."""
        return self.bodies if model == "macro" else self.divided(one_body_per_block(self.assemblage)).bodies

"""One wall's limit analysis: what all flow rules share, and how a state is put together and checked."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.limit_analysis.paper.equilibrium import Equilibrium
from orchestrator.limit_analysis.paper.limit_state import FlowRule, LimitState, LinearProgramRecord
from orchestrator.limit_analysis.paper.linear_program import LimitSolution
from orchestrator.limit_analysis.paper.mechanism import dilation, mechanism_from, motion_of, power_residual
from orchestrator.limit_analysis.paper.yield_conditions import YieldConditions
from orchestrator.limit_analysis.validation import validate
from orchestrator.masonry.block_properties import ELASTIC_MODULUS
from orchestrator.masonry.joints import Assemblage


@dataclass(frozen=True, eq=False, slots=True)
class Problem:
    """What all flow rules share: the assemblage, its equilibrium and Coulomb's law in its joints.

    elastic_modulus: of stones that have none of their own, Pa. How far the wall moves depends on it, and so does what
    it bears in large displacements; in small ones only ratios of stiffness matter.
    """

    assemblage: Assemblage
    equilibrium: Equilibrium
    friction: YieldConditions
    elastic_modulus: float = ELASTIC_MODULUS

    @property
    def no_dilatancy(self) -> FloatArray:
        """Dilatancy (k,) of a non-associative mechanism."""
        return np.zeros_like(self.friction.slope)

    def measured_by_load(self, multiplier: float) -> Problem:
        """Return the same with forces measured by the live load at a multiplier where that is SMALL."""
        return replace(self, equilibrium=self.equilibrium.measured_by_load(multiplier))

    def complaints(self, state: LimitState) -> tuple[str, ...]:
        """What the check without the solver finds wrong with a non-associative state."""
        return validate(self.assemblage, self.equilibrium, self.friction, state).complaints

    def state(
        self,
        flow_rule: FlowRule,
        dilatancy: FloatArray,
        forces_of: LimitSolution,
        mechanism_of: LimitSolution,
        records: tuple[LinearProgramRecord, ...],
    ) -> LimitState:
        """Put a state together and check it; sliding joints of its mechanism open by dilatancy (k,) times |slip|."""
        equilibrium, friction = self.equilibrium, self.friction
        load_multiplier, forces = forces_of.load_multiplier, forces_of.joint_forces
        mechanism = mechanism_from(self.assemblage.wall, equilibrium, mechanism_of.velocities)
        return LimitState(
            flow_rule=flow_rule,
            load_multiplier=load_multiplier,
            joint_forces=read_only(forces),
            mechanism=mechanism,
            records=records,
            converged=True,
            equilibrium_residual=equilibrium.residual(forces, load_multiplier),
            yield_residual=friction.excess(forces) / equilibrium.unit_force,
            power_residual=power_residual(equilibrium, friction, dilatancy, load_multiplier, forces, mechanism),
            dilation=dilation(equilibrium, friction, forces, mechanism),
            horizontal_load=equilibrium.base_shear,
            live_total=equilibrium.live_total,
        )

    def falling(self, forces: FloatArray, velocities: FloatArray) -> LimitState:
        """Return forces (k, 3) in N with free-block velocities (3m,) under the dead load alone, whatever work the live
        load does in them, at a multiplier of 0: a motion and no state."""
        equilibrium = self.equilibrium
        return LimitState(
            flow_rule="path",
            load_multiplier=0.0,
            joint_forces=read_only(forces),
            mechanism=motion_of(self.assemblage.wall, equilibrium, velocities),
            records=(),
            converged=False,
            equilibrium_residual=equilibrium.residual(forces, 0.0),
            yield_residual=self.friction.excess(forces) / equilibrium.unit_force,
            power_residual=0.0,
            dilation=0.0,
            horizontal_load=equilibrium.base_shear,
            live_total=equilibrium.live_total,
        )

    def bound(self, optimum: LimitSolution) -> LimitState:
        """Return the associative optimum as a state."""
        return self.state("associative", self.friction.slope, optimum, optimum, (record_of(optimum, 0.0),))


def record_of(solution: LimitSolution, parameter: float) -> LinearProgramRecord:
    """Return what one linear program gave and cost."""
    return LinearProgramRecord(
        solution.load_multiplier, parameter, solution.iterations, solution.seconds, solution.status
    )

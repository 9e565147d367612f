"""What micro limit analysis returns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray, read_only
from orchestrator.basis.errors import CaseError
from orchestrator.loads.block_loads import Loads, upright_resultant
from orchestrator.masonry.block_properties import ELASTIC_MODULUS
from orchestrator.masonry.joints import Assemblage, fingerprint_of_wall
from orchestrator.masonry.points_in_common import PointInCommon

Scale = Literal["unit_power", "unit_displacement"]
FlowRule = Literal[
    "associative", "sequence", "path", "last_rest", "large_displacements", "smoothed", "descent", "unloaded"
]
NAMES: dict[FlowRule, str] = {
    "associative": "associative solution",
    "sequence": "the paper's sequence",
    "path": "collapse state met by loading",
    "last_rest": "last load at rest",
    "large_displacements": "peak in large displacements",
    "smoothed": "collapse state of smoothed conditions",
    "descent": "collapse state beside the last load at rest",
    "unloaded": "collapse state found without loading",
}
"""What a state is, by how it was found: the words of terminal, pictures and pages."""
SOFT = 10.0
"""Displacement over the elastic one from which on a wall is called soft, and geometry may decide."""
LESS = 0.01
"""Part of the multiplier in small displacements by which a peak in large ones lies below it for geometry to show."""


@dataclass(frozen=True, eq=False, slots=True)
class Mechanism:
    """Velocities of n blocks and relative rates at k joints, defined up to one positive factor.

    velocities (n, 3): u, v (m/s) of the centroid and rotation rate (rad/s, counter-clockwise); zero for supports.
    opening (k, 2): rate at the start and end of each joint, positive apart, m/s.
    slip (k,): tangential velocity of block j relative to block i along the joint's tangent, m/s.
    largest_displacement: largest velocity of any block corner, m/s (what `unit_displacement` sets to 1).
    """

    velocities: FloatArray
    opening: FloatArray
    slip: FloatArray
    largest_displacement: float

    def scaled(self, scale: Scale) -> Mechanism:
        """Return the mechanism in one of the two named scales.

        `unit_power` (as the LP returns it): live load power f_L . u = 1 in N and m. `unit_displacement`: the largest
        displacement of any block corner is 1.
        """
        if scale == "unit_power":
            return self
        factor = 1.0 / self.largest_displacement
        return replace(
            self,
            velocities=read_only(self.velocities * factor),
            opening=read_only(self.opening * factor),
            slip=read_only(self.slip * factor),
            largest_displacement=1.0,
        )


@dataclass(frozen=True, slots=True)
class LinearProgramRecord:
    """One linear program of a sequence: what it gave and what it cost."""

    load_multiplier: float
    parameter: float
    """seed cohesion in the sequence (mean block weights; 0 in the program that confirms it), else 0"""
    iterations: int
    seconds: float
    status: str


@dataclass(frozen=True, eq=False, slots=True)
class LimitState:
    """A collapse state. joint_forces (k, 3) in N: normal force at start, at end (compression positive), shear.

    Shear is the force along the joint's tangent that block i exerts on block j.
    Residuals are relative: equilibrium to the total weight, yield to the mean block weight, power to the live
    load's power (0 = exact balance); dilation is the largest |opening| at an end of a joint that carries load there,
    relative to the largest displacement (0 for a non-associative state, mu |slip| for an associative one).
    horizontal_load: horizontal resultant in N, at a multiplier of 1, of the live load on the blocks that it is a state
    of: those that have come loose before bear none. live_total: sum of the sizes of its forces, N.
    open_ends (k, 2): ends of joints that stand open when this state is met and may close in it, None where all joints
    are as drawn. tie_forces (m,): what ties pull with in N, once they are parted from the joints (`of_first_joints`).
    """

    flow_rule: FlowRule
    load_multiplier: float
    joint_forces: FloatArray
    mechanism: Mechanism
    records: tuple[LinearProgramRecord, ...]
    converged: bool
    equilibrium_residual: float
    yield_residual: float
    power_residual: float
    dilation: float
    horizontal_load: float
    live_total: float
    open_ends: BoolArray | None = None
    tie_forces: FloatArray = field(default_factory=lambda: read_only(np.zeros(0)))

    @property
    def base_shear(self) -> float:
        """Its base shear, N."""
        return self.load_multiplier * self.horizontal_load

    @property
    def name(self) -> str:
        """What the state is, in words."""
        return NAMES[self.flow_rule]


@dataclass(frozen=True, eq=False, slots=True)
class LocalFailure:
    """Stones (their ids) that come loose while the wall stands, and their share of the dead load.

    state: the wall as they move, less what came loose before. multipliers: that of this state and the last at which
    they rest, in order; the state's is lower where stones were wedged: it is a property of that wedge, and depends on
    the stiffness of its joints. Both are 0 of stones that go down under the dead load.
    """

    stones: tuple[int, ...]
    share: float
    multipliers: tuple[float, float]
    state: LimitState

    @property
    def under_dead_load(self) -> bool:
        """Whether they go down under the dead load alone, as nothing but a wedge holds them: the state is their motion,
        at a multiplier of 0."""
        return not self.state.converged and self.state.flow_rule == "path"

    def taking(self, stones: Sequence[int], share: float) -> LocalFailure:
        """Return the same with more stones, by their ids and their share of the dead load, that it takes along."""
        return replace(self, stones=tuple(sorted({*self.stones, *stones})), share=self.share + share)


def is_of_geometry(curve: FloatArray, drawn: float) -> bool:
    """Return whether geometry makes the peak of a curve (s, 2) of displacements and multipliers, and not the joints
    alone: it lies LESS below the multiplier `drawn` in small displacements, or the wall has moved further there than
    SOFT times its elastic displacement. The first row is that under the dead load, the second elastic."""
    moved, multiplier = curve.T
    top = int(multiplier.argmax())
    is_far = moved[top] * multiplier[1] > SOFT * moved[1] * multiplier[top]
    return bool(is_far or multiplier[top] < (1.0 - LESS) * drawn)


@dataclass(frozen=True, eq=False, slots=True)
class LimitAnalysis:
    """All answers for one direction of the load: associative always; the others or why there is none.

    `loads` are those of the wall as given; `weight` the weight of the free blocks in N; `vertical_load` all their
    dead load in N, extra loads too; `horizontal_load` the horizontal resultant of the live load at a multiplier of 1,
    in N (by default the weight), of the wall as given. tilting_table: whether tan(angle) of a table that tilts the
    wall is just another way to state the multiplier.

    associative: an upper bound to every state of the wall as drawn (a theorem) where `is_bound`: not where stones have
    `points_in_common`, or go into each other in a point, as such points bear nothing here. path: the state that loading
    from gravity meets, after the stones of `local_failures` have come loose: they are at rest and without forces in it.
    Not converged where no limit state passed the check, then it is the last load at which the wall was found at rest.
    associative_left: the associative state of the wall without these stones, None where there are none. sequence: the
    paper's value, of the wall as drawn. lowest, highest: multipliers of states found that loading could reach, without
    these stones too.
    interval: where the state met depends by more than 1 % on the stiffness of joints, or loading passes a limit state
    and finds rest beyond it: lowest and highest multiplier; the headline is the lower state then. The lowest may be a
    rest beyond which a path with joints of that stiffness found neither rest nor state.
    last_rest: the last load at which the wall was found at rest; soft_from: that from which on it moves so far that
    geometry decides, or None. rigid_curve (s, 2): displacement along the live load in m and multiplier of rigid blocks
    in large displacements, of what local failures leave, for stones of elastic_modulus (Pa); None where not asked for.
    rigid_peak: the multiplier of its peak, None where that was not passed; pressed_peak: about what is left of it, or
    of a wall that was not pushed so, as stones give way at edges that they turn about (turning_joints.py), 0 where
    these take all, or None.
    Where the peak is the answer, `path` is that peak, not converged, and `drawn` what the wall meets in small
    displacements, with which the interval ends, or a state of smoothed conditions, which it need not meet.
    going_down: ids of the blocks that go on moving where loading finds no rest under the dead load, or none in large
    displacements of stones so soft: no multiplier counts then, unless they are wedged. ways_out: how often the path of
    what is left, and the push, needed which: steps not found or not taken (`shorter`, `turned`, against a drag
    `slower`), taken after all (`elsewhere`), loads `held` above a peak. factorisations: of all loading. wall: which it
    is of (`fingerprint_of_wall`), "" where that is not known.
    """

    loads: Loads
    weight: float
    vertical_load: float
    horizontal_load: float
    tilting_table: bool
    associative: LimitState
    sequence: LimitState | None
    path: LimitState | None
    remarks: tuple[str, ...]
    seconds: float
    lowest: LimitState | None = None
    highest: float | None = None
    local_failures: tuple[LocalFailure, ...] = ()
    last_rest: float | None = None
    soft_from: float | None = None
    interval: tuple[float, float] | None = None
    associative_left: LimitState | None = None
    elastic_modulus: float = ELASTIC_MODULUS
    rigid_curve: FloatArray | None = None
    rigid_peak: float | None = None
    pressed_peak: float | None = None
    points_in_common: tuple[PointInCommon, ...] = ()
    is_bound: bool = True
    ways_out: dict[str, int] = field(default_factory=dict)
    drawn: LimitState | None = None
    going_down: tuple[int, ...] = ()
    factorisations: int = 0
    wall: str = ""

    def tilt_angle(self, state: LimitState) -> float | None:
        """Angle in rad at which a state is reached on a tilting table, None where the multiplier says nothing of it."""
        return float(np.arctan(state.load_multiplier)) if self.tilting_table else None

    @property
    def upright_load(self) -> float | None:
        """Vertical live load at a multiplier of 1, in N upwards, where none of it is horizontal; else None."""
        return upright_resultant(self.loads.live)

    @property
    def share_lost(self) -> float:
        """Share of the dead load that comes loose before the headline is met."""
        return sum(failure.share for failure in self.local_failures)

    @property
    def expected_multiplier(self) -> float:
        """The associative multiplier of what local failures leave to six digits, by which a pushover measures its load:
        further ones are the solver's, and a stone that comes loose early says nothing of the wall."""
        return float(f"{self.bound.load_multiplier:.6g}")

    @property
    def geometry_decides(self) -> bool:
        """Whether the headline is the peak in large displacements, and no limit state of the wall as drawn."""
        return self.path is not None and self.path.flow_rule == "large_displacements"

    @property
    def is_of_geometry(self) -> bool:
        """Whether it is geometry that makes this peak, and not the joints alone."""
        drawn = 0.0 if self.drawn is None else self.drawn.load_multiplier
        return self.rigid_curve is not None and is_of_geometry(self.rigid_curve, drawn)

    @property
    def headline(self) -> LimitState:
        """The state that is reported and that the macroblocks come from: the one that loading meets.

        It is the last rest, not converged, where no limit state was closed there: what was found to stand. Without a
        path: the paper's, else the lowest, else the associative one.
        """
        return self.path or next(iter(self._settled), self.associative)

    @property
    def bound(self) -> LimitState:
        """The associative state of the wall that the headline belongs to."""
        return self.associative_left or self.associative

    @property
    def _settled(self) -> tuple[LimitState, ...]:
        """The non-associative states that have converged, of walls that bear some load: none that has to be held."""
        states = (self.path, self.sequence, self.lowest)
        return tuple(s for s in states if s is not None and s.converged and s.load_multiplier > 0.0)

    @property
    def non_associative_range(self) -> tuple[float, float] | None:
        """Smallest and largest multiplier of headline and states that loading could reach, None if there is only a
        bound."""
        if self.headline is self.associative:
            return None
        multipliers = [self.headline.load_multiplier, *(self.interval or ())]
        multipliers += [self.lowest.load_multiplier] if self.lowest else []
        multipliers += [self.highest] if self.highest is not None else []
        return min(multipliers), max(multipliers)


def refuse_other_analysis(assemblage: Assemblage, analysis: LimitAnalysis) -> None:
    """Raise CaseError for a limit analysis of another wall than the one given, ties among its joints."""
    state, size = analysis.headline, (len(assemblage.wall.blocks), assemblage.joints.count)
    another = (len(state.mechanism.velocities), len(state.joint_forces)) != size
    if another or analysis.wall not in ("", fingerprint_of_wall(assemblage)):
        problem = "is not of this wall: other blocks or joints, or others of their values"
        raise CaseError("analysis", problem, "make it by analyse(assemblage) of the assemblage that is given")


def of_first_joints(analysis: LimitAnalysis, joints: int) -> LimitAnalysis:
    """Return the analysis with the forces and rates of so many joints, the first ones; those after them are ties, which
    have their forces apart (`LimitState.tie_forces`)."""

    def cut(state: LimitState) -> LimitState:
        motion = state.mechanism
        motion = replace(motion, opening=motion.opening[:joints], slip=motion.slip[:joints])
        ends = None if state.open_ends is None else state.open_ends[:joints]
        pull = read_only(-state.joint_forces[joints:, :2].sum(axis=1))
        forces = state.joint_forces[:joints]
        return replace(state, joint_forces=forces, mechanism=motion, open_ends=ends, tie_forces=pull)

    return replace(
        analysis,
        associative=cut(analysis.associative),
        sequence=analysis.sequence and cut(analysis.sequence),
        path=analysis.path and cut(analysis.path),
        lowest=analysis.lowest and cut(analysis.lowest),
        drawn=analysis.drawn and cut(analysis.drawn),
        associative_left=analysis.associative_left and cut(analysis.associative_left),
        local_failures=tuple(replace(one, state=cut(one.state)) for one in analysis.local_failures),
    )

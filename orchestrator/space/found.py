"""What a limit analysis of a wall in space found: which of its states counts, and what is said beside it."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Literal

from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.equilibrium import Torsion
from orchestrator.space.loads import SpaceLoads
from orchestrator.space.states import SpaceState

ONE_ANSWER = 0.01
"""Relative difference of two pushes up to which the joints' stiffness decides nothing, as in the plane."""
UNSETTLED = 0.05
"""Flow error of a push that is not at rest up to which it says how far the multiplier may be off."""
PUSHES = ("elastic joints", "elastic joints, equal springs")
"""names of the states that are headlines, the first one found; springs stiffer with depth, equal springs"""

States = Literal["range", "headline", "none"]


@dataclass(frozen=True, eq=False, slots=True)
class SpaceAnalysis:
    """associative: bound and mechanism, None where a wall would bear any load if sliding dilated; other_torsion: the
    multiplier with the other torsion, infinite where it holds the wall; states: what was found without dilation, the
    headline's push first; looked_for: which of them were looked for. weight (N) of the free blocks. seconds in all.
    going_down: ids of blocks that go down under the dead load unless they are wedged: whether the wall stands is
    open."""

    assemblage: SpaceAssemblage
    loads: SpaceLoads
    torsion: Torsion
    associative: SpaceState | None
    other_torsion: float
    states: tuple[SpaceState, ...]
    weight: float
    seconds: float
    remarks: tuple[str, ...]
    going_down: tuple[int, ...] = ()
    looked_for: States = "range"

    @property
    def counted(self) -> list[SpaceState]:
        """The states; pushes that ended in what is nearly one, where no push ended in one and none was closed that
        bears no more; and where that is nothing what is nearest to one."""
        valid = [state for state in self.states if state.valid]
        nearly = [state for state in self.states if state.nearly and self.associative is not None]
        if not any(state.name in PUSHES or state.load_multiplier <= self._most for state in valid):
            valid += [state for state in nearly if state.name in PUSHES]
        return valid or sorted(nearly, key=lambda state: state.validation.flow)[:1]

    @property
    def headline(self) -> SpaceState | None:
        """The end of the first push that is a state, or the lower one where two differ by more than ONE_ANSWER; else
        the first state that was closed and bears no more than where a push ended, or the first of all."""
        counted = self.counted
        pushes = [state for state in counted if state.name in PUSHES]
        if not pushes:
            near = (state for state in counted if state.load_multiplier <= self._most)
            return next(near, counted[0] if counted else None)
        lowest = min(pushes, key=lambda state: state.load_multiplier)
        apart = lowest.load_multiplier < (1.0 - ONE_ANSWER) * pushes[0].load_multiplier
        return lowest if apart else pushes[0]

    @property
    def not_at_rest(self) -> float | None:
        """Multiplier at which a push had not come to rest, where the headline is a state that was closed elsewhere and
        bears more than one may where pushes ended (`_most`): the wall may fail there; else None."""
        headline = self.headline
        if headline is None or headline.name in PUSHES:
            return None
        ends = [state.load_multiplier for state in self.states if state.name in PUSHES]
        return min(ends) if headline.load_multiplier > self._most else None

    @property
    def _most(self) -> float:
        """The most that a state may bear that is where pushes ended, of which the flow error says how far they may be
        from rest; infinite where none was made."""
        ends = [state for state in self.states if state.name in PUSHES]
        off = [max(ONE_ANSWER, min(state.validation.flow, UNSETTLED)) for state in ends]
        return min((state.load_multiplier * (1.0 + one) for state, one in zip(ends, off, strict=True)), default=inf)

    @property
    def lowest(self) -> SpaceState | None:
        """The lowest state found."""
        return min(self.counted, key=lambda state: state.load_multiplier, default=None)

    @property
    def range(self) -> tuple[float, float] | None:
        """Lowest and highest state found."""
        multipliers = [state.load_multiplier for state in self.counted]
        return (min(multipliers), max(multipliers)) if multipliers else None

    @property
    def horizontal_load(self) -> float:
        """Horizontal resultant of the live load at a multiplier of 1, N: base shears are multiples of it."""
        return self.loads.base_shear(self.assemblage.wall.up)

    @property
    def upright_load(self) -> float | None:
        """Vertical live load at a multiplier of 1, in N upwards, where none of it is horizontal; else None."""
        return self.loads.upright(self.assemblage.wall.up)

    @property
    def bound(self) -> float:
        """The associative multiplier, which no state exceeds: infinite where there is none."""
        return inf if self.associative is None else self.associative.load_multiplier

    @property
    def shown(self) -> SpaceState:
        """The state whose mechanism is drawn: the headline, else the associative one."""
        state = self.headline or self.associative
        assert state is not None, "an analysis without either is not returned"
        return state

"""Equilibria of rigid blocks on elastic joints that are pushed: displacements along the live load are prescribed.

From a first rest under a small load on each step is an equilibrium, with the load as its unknown: joints open, close
and slide on the way, and what the wall bears grows until it loses its hold. Where the load has fallen by DROP since its
peak, or no further equilibrium is found, however small the step (the wall snaps back), the load of the peak is held,
and a little more: where the wall then comes to rest against a drag (overdamped.py) it is pushed on from there; where it
does not, the curve has its peak. The same for joints as they were drawn, where blocks in the end move like a mechanism
under a load that stands still (loading_path.py), and for joints that move with their blocks (rigid_pushover.py).

Sources: path following by a displacement, and overdamped motion as a substitute for dynamics after a snap, are common;
own combination.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.limit_analysis.paper.limit_state import LimitState
from orchestrator.limit_analysis.search.elastic_contact import Position
from orchestrator.limit_analysis.search.implicit_step import Step, Task
from orchestrator.limit_analysis.search.overdamped import FIRST_DRAG, REST_BUDGET, Moved, Overdamped

STEPS = 20
"""Steps of the load, at least, up to the associative multiplier."""
FIRST_LOADS = (1.0, 0.1, 0.01)
"""Parts of a load step under which a first rest is looked for."""
HELD = 1e-3
"""Part of the associative multiplier that is added to the load of the peak when it is held; where the wall then rests,
and no displacement leads on from there, up to a step of the load the next times."""
DROP = 0.2
"""Part of its peak by which a load has fallen where prescribed displacements end."""
GROWTH = 2.0
"""Growth of the displacement prescribed after each step, at most."""
SHORTER = 0.3
"""Factor after a step that was not found or not taken."""
TURNED = 0.3
"""Part of its change of displacements by which a step longer than the elastic displacement may differ from the step
before to be taken: where several solutions exist, another path begins there. Where no shorter step leads on it is
taken: a stone has snapped over."""
LEAP = 1.25
"""Steps of the load by which the load of a step so long may change to be taken, for the same reason; a step is as long
as makes it 1, and rounding may not decide."""
SHORTEST = (1e-2, 1e-3)
"""Parts of the elastic displacement and of all displacement so far below which a step leads nowhere: the wall snaps
back."""
FIRST = 10.0
"""Times the shortest step that a first one has at least."""
MOTION = 1e-3
"""Flow error of a motion that is that of a mechanism."""
SHARP = 1e-8
"""Flow error of a limit state that is sharp enough."""
CLOSE = 1e-5
"""Flow error of a motion that is worth checking."""
FARTHEST = 1e5
"""Displacement over the elastic one from which on a mechanism is not followed any further."""


@dataclass(frozen=True, eq=False, slots=True)
class Way:
    """Where pushing has led a wall.

    equilibria: the first of them under the dead load; met: the one that is the sharpest limit state, None where none
    passed the check; lost: the motion after the last of them; held: the load that was held last above the peak
    (scaled), inf where none was; is_lost: whether the wall did not come to rest under it.
    """

    equilibria: tuple[Moved, ...]
    met: Moved | None
    lost: Moved
    held: float
    is_lost: bool

    @property
    def peak(self) -> Moved:
        """The equilibrium with the largest load."""
        return max(self.equilibria, key=lambda one: one.multiplier)

    @property
    def rising(self) -> list[Moved]:
        """Equilibria that bear more than any before them, the first under the dead load."""
        highest = np.maximum.accumulate([-np.inf, *(one.multiplier for one in self.equilibria)])
        return [one for one, before in zip(self.equilibria, highest, strict=False) if one.multiplier > before]


class Pushing(Overdamped):
    """The equilibria of one wall that is pushed."""

    def checked(self, position: Position, change: FloatArray, multiplier: float) -> LimitState | None:
        """Return the limit state that forces and their motion are; none is known here."""
        return None

    def closed(self, last: Moved, motion: Moved, load_step: float) -> Moved | None:
        """Return the limit state near the last equilibrium of a wall, or near its motion under the load held above the
        peak; none is known here."""
        return None

    def is_mechanism(self, here: Moved) -> bool:
        """Whether blocks move like a mechanism, under a load that stands still."""
        return here.flow < MOTION

    @property
    def is_over(self) -> bool:
        """Whether no factorisations are left but those for the load that is held above the peak."""
        return self.spent >= self.most - REST_BUDGET

    def too_little(self, peak: Moved) -> float:
        """Multiplier below which what a wall bears as it moves under the load held above a peak is too little for it to
        be followed far; none here."""
        return -np.inf

    def budget_held(self, peak: Moved, last: Moved) -> int:
        """Factorisations for the load held last above a peak; last: where displacements ended."""
        return self.most - self.spent

    def shortest(self, here: Moved) -> float:
        """Displacement prescribed next that leads nowhere."""
        elastic, far = SHORTEST
        return max(elastic * self.elastic * here.multiplier, far * self.moved(here.position))

    def is_followed(self, here: Moved, peak: Moved) -> bool:
        """Whether a wall is pushed any further than where it is: not after a fall, or as a mechanism."""
        if here.multiplier < (1.0 - DROP) * peak.multiplier or (here.state is not None and here.flow < SHARP):
            return False
        return not (self.is_mechanism(here) and self.is_further(FARTHEST, here.position, here.multiplier))

    def followed(self, rest: Moved, load_step: float) -> Iterator[Moved]:
        """Yield equilibria under prescribed displacements, until none is found or the budget is spent.

        rest: its `change` says which way, and how far at first. load_step: by which the load is to change at most.
        """
        here, growth = rest, GROWTH
        advance, met = max(float(self.live @ rest.change), FIRST * self.shortest(rest)), False
        elsewhere: tuple[Step, float] | None = None
        while not self.is_over:
            if advance > self.shortest(here):
                expected = here.change * (advance / float(self.live @ here.change))
                shorter = self.times_too_long(expected)
                advance, expected = advance / shorter, expected / shorter
                found = self.step(here.position, Task(here.multiplier, 0.0, advance), expected)
                if not found.found and (met or (here is not rest and self.is_mechanism(here))):
                    return
                change = found.position.displacements - here.position.displacements
                turned = np.abs(change - expected).max() > TURNED * np.abs(change).max()
                turned |= abs(found.multiplier - here.multiplier) > LEAP * load_step
                if not found.found or (turned and advance > self.elastic * here.multiplier):
                    elsewhere = (found, advance) if found.found else elsewhere
                    self.counts["turned" if found.found else "shorter"] += 1
                    advance, growth = SHORTER * advance, 1.0
                    continue
            elif elsewhere is not None:
                found, advance = elsewhere
                change = found.position.displacements - here.position.displacements
                self.counts["elsewhere"] += 1
            else:
                return
            elsewhere, grown = None, abs(found.multiplier - here.multiplier)
            flow = self.flow(found.position, here.position, found.multiplier * advance)
            here = Moved(found.position, change, found.multiplier, flow, True)
            if flow < CLOSE:
                here = replace(here, state=self.checked(here.position, change, here.multiplier))
                met = met or here.state is not None
            yield here
            advance *= min(growth, load_step / max(grown, 1e-3 * load_step))
            growth = GROWTH

    def first_rest(self, stands: Moved, load_step: float) -> Moved:
        """Return a rest under a load up to a step, with all its displacement; the last motion where there is none."""
        for part in FIRST_LOADS:
            found = self.rest(stands.position, part * load_step, FIRST_DRAG, REST_BUDGET)
            if found.rests:
                self.elastic = self.moved(found.position) / found.multiplier
                return replace(found, change=found.position.displacements - stands.position.displacements)
        return found

    def held(self, peak: Moved, last: Moved, more: float, fine: float) -> Moved:
        """Return the rest under a load above a peak by `more`, or by less, down to `fine`, or the motion under that.

        last: where displacements ended.
        """
        while True:
            self.counts["held"] += 1
            budget = REST_BUDGET if more > fine else self.budget_held(peak, last)
            found = self.rest(peak.position, peak.multiplier + more, FIRST_DRAG, budget, self.too_little(peak))
            if found.rests or more <= fine:
                return found
            more = max(SHORTER * more, fine)

    def pushed(self, stands: Moved, associative: float) -> Way:
        """Push the wall from its rest under the dead load; associative: the multiplier of Eq. (1)."""
        found, met, scale = [stands], None, self.wall.problem.per_multiplier
        load_step, fine = scale * associative / STEPS, scale * associative * HELD
        first = rest = self.first_rest(stands, load_step)
        lost, more = rest, fine
        while rest.rests and not self.is_over:
            found.append(rest)
            peak, lost, met = rest, rest, None
            for here in self.followed(replace(rest, change=first.change), load_step):
                found.append(here)
                lost, peak = here, max(peak, here, key=lambda one: one.multiplier)
                if here.state is not None and (met is None or here.flow < met.flow):
                    met = here
                if not self.is_followed(here, peak):
                    break
            if met is not None and met.flow < SHARP and met.multiplier + fine >= peak.multiplier:
                break
            more = fine if peak is not rest else min(GROWTH * more, load_step)
            rest = self.held(peak, lost, more, fine)
            if rest.rests or met is not None:
                continue
            met, lost = self.closed(lost, rest, load_step), rest
        if rest.rests and rest is not found[-1] and met is None:  # with the last factorisations
            found.append(rest)
        return Way(tuple(found), met, lost, rest.multiplier if self.counts["held"] else np.inf, not rest.rests)

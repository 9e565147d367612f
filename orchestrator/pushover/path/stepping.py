"""From the unloaded wall to its collapse: static increments, and damped motion wherever no static state is near.

Every increment solves R_u = 0 of newton.py from the state before it, u_n: backward Euler of an overdamped flow.
One quantity is prescribed, by phase:

    gravity         the share of the weight
    load            the load multiplier
    displacement    the mean displacement of the bodies that are driven; the multiplier is an unknown

The load is prescribed until a part of the wall moves for good; what moves then is driven. An increment is static when
the proximal term carries less than `out_of_balance` of the weight of every body. One that bends, and whose work and
energies do not balance, may have jumped to another path of equilibrium: it is taken shorter, but for one that is not
above the elastic slip. Where no static state is found near, the prescribed quantity is held and the wall moves against
viscous contacts and its mass (motion.py) until it rests.

A part of less than `local_share` of the wall's dead load and of its live load that does not come to rest is a local
failure: its motion is kept, it is taken out when it has lost its hold, and the wall goes on while it carries live load.
What falls before the wall rests again is one failure, and all of them may take no more than local_part.py says. That
holds under gravity too: what falls there and is no local failure is a wall that does not stand.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray, read_only
from orchestrator.basis.errors import CollapseError, ConvergenceError, HeldError
from orchestrator.pushover.increments import GAVE_WAY, RESTED, Increment, Phase, end_of_curve
from orchestrator.pushover.model import ContactModel, driven_by, touching
from orchestrator.pushover.path.energies import balances
from orchestrator.pushover.path.growth import BENT, growth, longer
from orchestrator.pushover.path.increment_record import at_rest, in_front, of_all_nodes
from orchestrator.pushover.path.increment_solver import Aim, IncrementSolver, measured_by
from orchestrator.pushover.path.losses import (
    fallen_by_weight,
    is_local_motion,
    is_the_wall,
    since_rest,
    without_their_hold,
)
from orchestrator.pushover.path.motion import FAST, FASTEST, farthest, motion, step_of_motion
from orchestrator.pushover.path.moved_wall import is_held
from orchestrator.pushover.path.moving import body_motion, body_size, moving_part
from orchestrator.pushover.path.trial import SHRINK, Trial
from orchestrator.pushover.settings import NewtonSettings, SteppingSettings
from orchestrator.pushover.solve.linear_system import LinearSystem

logger = logging.getLogger(__name__)

CUTS = {"gravity": 1, "load": 0, "displacement": 2}
"""times that an increment is made smaller before the wall is left to move, once more where it begins above the largest
(only once under displacement control: motion where the curve has a kink that a sixteenth of the increment follows, and
up to three times the iterations)"""
ONSET = 1 / 64
"""a local failure is looked for in load increments down to this share of the largest"""
LOADED = "the load is prescribed"
"""what an attempt says after which an increment of load took the place of one of what is driven"""
HELD_FROM = 2.0
"""over the multiplier that limit analysis expects at most: from there on it is asked whether supports hold the wall"""


@dataclass(frozen=True)
class Pushover:
    """A contact model, its linear system and the settings; expected_multiplier: what limit analysis expects.

    loose (b,): of macroblocks, the bodies of which any part that moves is a local failure. Under the live load no
    others are: macroblocks are those of one mechanism, and know no other once it has fallen. None where every stone is
    a body.
    """

    model: ContactModel
    system: LinearSystem
    newton: NewtonSettings
    stepping: SteppingSettings
    expected_multiplier: float = 0.3
    loose: BoolArray | None = None

    @cached_property
    def solver(self) -> IncrementSolver:
        """What solves its increments."""
        measure = measured_by(self.model, self.expected_multiplier)
        return IncrementSolver(self.model, self.system, self.newton, self.stepping, measure)

    def increments(self, last: Increment | None = None) -> Iterator[Increment]:
        """Yield the increments from gravity to the end of the curve, or those after `last`.

        Raises ConvergenceError when no further increment converges, CollapseError when a large part of the wall has
        fallen, HeldError when supports hold the wall against any multiple of the load; everything yielded before stays
        valid.
        """
        state = in_front(self.model, last) if last else at_rest(self.model)
        while state.phase == "gravity" or end_of_curve(state, self.stepping, self.model.height) is None:
            if state.load_multiplier > HELD_FROM * self.expected_multiplier and is_held(self.model, state):
                raise HeldError(state.load_multiplier)
            if state.phase == "gravity" and state.number >= self.stepping.largest_increments and not self._rests(state):
                spent = f"in {state.number} increments (stepping.largest_increments)"
                raise ConvergenceError("gravity", f"the wall has not come to rest under its dead load {spent}")
            for following in self._after(state):
                state = following
                yield of_all_nodes(self.model, state)

    def _after(self, state: Increment) -> Iterator[Increment]:
        """Yield what follows `state`: one increment, static or in motion, or several when a motion is kept."""
        if state.phase == "gravity" and self._rests(state):
            state = replace(state, phase="load", time=0.0, step=(self._largest("load"), 0.0))
        if state.moving:
            change = state.change.ravel()
            fast = farthest(self.model, state, change) > FAST
            driving = self._driving_what_moves(state, change) if fast else None
            if driving is None:
                yield self._without_what_fell(step_of_motion(self.solver, state, self._held(state)))
                return
            state = driving
        found: Trial | list[Increment] = Trial(state, state.step[0] or self._largest(state.phase))
        while isinstance(found, Trial):
            found = self._static(found)
        yield from found

    def _slides_alone(self, trial: Trial, change: FloatArray) -> bool:
        """Return whether in a change (n,) of what is driven a local part goes FAST by itself, in a wall that stands."""
        return farthest(self.model, trial.state, change) > FAST and self._is_alone(trial, change)

    def _is_alone(self, trial: Trial, change: FloatArray) -> bool:
        """Return whether only a local part moves in a change (n,) of what is driven, and the wall has not given way: it
        carries its largest base shear but for what a local part may. Asked once in two increments."""
        state = trial.state
        asked = any(attempt.action == LOADED for attempt in (*state.attempts, *trial.attempts))
        if state.phase != "displacement" or asked:
            return False
        whole = state.load_multiplier * self.model.horizontal_load  # base shear, had nothing fallen, N
        stands = whole >= (1.0 - self.stepping.local_share) * state.largest_base_shear
        return stands and self._is_local(state, body_motion(self.model, change) * ~state.fallen)

    def _loaded(self, trial: Trial, spent: int) -> Trial:
        """Return a trial of the smallest increment of load in the place of one that drives what moves in a local part
        alone: in the increment of load before, which was larger, that part had taken others along."""
        size = ONSET * self._largest("load")
        state = replace(self._driving(trial.state, ~trial.state.fallen), phase="load", step=(size, 0.0))
        return replace(trial.then("a local part moves alone", LOADED, spent, state), size=size)

    def _static(self, trial: Trial) -> Trial | list[Increment]:
        """Return the static increment that is tried, what the wall does where there is none, or what to try next."""
        state, aim = trial.state, self._aim(trial.state, trial.size)
        trial = replace(trial, size=aim.size)
        try:
            solved = self.solver.static(state, aim, friction_of_before=not self._is_retried(trial))
        except ConvergenceError as error:
            return self._not_static(trial, aim, str(error), error.iterations)
        trial = trial.after(solved)
        falls = solved.base_shear < (1 - self.newton.residual) * state.base_shear  # more than by rounding
        if solved.moving:
            return self._not_static(trial, aim, "a part of the wall moves", solved.iterations)
        if self._slides_alone(trial, solved.change.ravel()):
            return self._loaded(trial, solved.iterations)
        resolves = aim.phase != "displacement" or aim.size > self.model.slip_tolerance
        if self._passes_a_peak(state, solved) and resolves:
            return trial.smaller("the base shear falls from its highest", solved.iterations)
        bent, length = self.solver.bent(state, solved, aim), self._length(state, solved)
        if resolves and bent >= BENT and self._may_be_smaller(trial) and not balances(state, solved):
            return trial.smaller("work and energies do not balance", solved.iterations)
        if aim.size > self._largest(aim.phase) and length > 1.0 and bent * length > BENT:
            return trial.smaller("the curve is not straight", solved.iterations)
        grows = growth(state, bent, smaller=trial.cuts > 0)
        grown = min(grows * aim.size, self._resolved(solved, length) * (longer(bent, length) if falls else 1.0))
        return [replace(solved, attempts=trial.attempts, step=(grown, aim.size))]

    def _not_static(self, trial: Trial, aim: Aim, why: str, spent: int) -> Trial | list[Increment]:
        """Return a smaller increment to try, or what the wall does that is left to move; spent: iterations so far."""
        state, smaller = trial.state, SHRINK * trial.size
        if self._is_retried(trial):
            return trial.smaller(why, spent)
        rows = motion(self.solver, state, aim)
        last, moved = rows[-1], trial.after(*rows)
        total = spent + sum(row.iterations for row in rows)
        if not last.moving:
            whole = (last.displacement - state.displacement).ravel()
            if last.base_shear < state.base_shear and self._is_alone(trial, whole):  # it creeps from rest to rest
                return self._loaded(moved, total)
            borne = np.array([state.base_shear, *(row.base_shear for row in rows)])
            lost = float(np.max(np.maximum.accumulate(borne) - borne))
            action = GAVE_WAY if lost > self.newton.residual * float(np.abs(borne).max()) else RESTED
            attempts = moved.then(why, action, total - last.iterations).attempts
            again = any(attempt.action in (RESTED, GAVE_WAY) for attempt in state.attempts)
            return [replace(last, number=state.number + 1, attempts=attempts, step=self._anew(aim, again))]
        if self._slides_alone(trial, last.change.ravel()):
            return self._loaded(moved, total)
        driving = self._driving_what_moves(state, last.change.ravel())
        if driving is not None:
            # the wall moves, and not a part alone: it goes on by what was found before, half of what was asked at most
            asked = [0.5 * attempt.tried for attempt in trial.attempts if attempt.action == LOADED]
            return replace(moved.then(why, "what moves is driven", total, driving), size=max([driving.step[0], *asked]))
        if state.phase == "load" and trial.size > ONSET * self._largest("load"):
            return replace(moved.then(why, f"a local part moves; retried with {smaller:g}", total), size=smaller)
        attempts = trial.then(why, "a local part moves", spent).attempts + rows[0].attempts
        return [replace(rows[0], attempts=attempts), *rows[1:]]

    def _may_be_smaller(self, trial: Trial) -> bool:
        """Return whether an increment that fails is made smaller: not as often as is allowed already."""
        phase = trial.state.phase
        return trial.cuts < CUTS[phase] + (trial.state.step[0] > self._largest(phase))

    def _is_retried(self, trial: Trial) -> bool:
        """Return whether a smaller increment is tried where this one is not static."""
        return self._may_be_smaller(trial) and trial.size > ONSET * self._largest(trial.state.phase)

    def _passes_a_peak(self, state: Increment, solved: Increment) -> bool:
        """Return whether the base shear falls, in one increment of displacement, from the highest so far by more than
        a static state may be out of balance: somewhere between the two it may have been higher."""
        fallen = solved.base_shear < (1 - self.stepping.out_of_balance) * state.base_shear
        return state.phase == "displacement" and state.base_shear >= state.largest_base_shear and fallen

    def _without_what_fell(self, state: Increment) -> Increment:
        """Return the state without the bodies that have lost their hold. Raises CollapseError for a large part."""
        if not state.moving:
            return replace(state, step=self._anew(self._held(state)))
        by_weight = state.phase == "gravity"
        lost = (fallen_by_weight if by_weight else without_their_hold)(self.model, state)
        if not lost.any():
            return state
        under = f"{state.time:.3g} of the weight" if by_weight else f"a multiplier of {state.load_multiplier:.5f}"
        logger.info("%s fell under %s", self._names(lost), under)
        if is_the_wall(self.model, state, lost, self.loose, self._local_share(state.phase)):
            if by_weight:
                farthest = self.model.body_names[int(np.argmax(np.where(lost, state.gone, 0.0)))]
                raise ConvergenceError("gravity", f"the wall does not stand under its dead load: {farthest} falls")
            raise CollapseError(self._names(since_rest(self.model, state, lost)), 1e3 * state.control_displacement)
        fallen = read_only(state.fallen | lost, np.bool_)
        force = np.where(touching(fallen, self.model.possible), 0.0, state.normal_force)
        driven = state.driven & ~fallen
        state = replace(state, fallen=fallen, normal_force=read_only(force))
        return self._driving(state, driven if self.model.body_live[driven].any() else ~fallen)

    def _names(self, part: BoolArray) -> str:
        return ", ".join(self.model.body_names[body] for body in np.flatnonzero(part))

    def _local_share(self, phase: Phase) -> float:
        """Return below which share of both loads a part is local in a phase, apart from what is loose."""
        of_one_mechanism = self.loose is not None and phase != "gravity"
        return 0.0 if of_one_mechanism else self.stepping.local_share

    def _is_local(self, state: Increment, motion: FloatArray) -> bool:
        """Whether what moves, by a motion (b,) of the bodies, is a local part of what has not fallen in a state."""
        return is_local_motion(self.model, motion, state.fallen, self.loose, self._local_share(state.phase))

    def _driving_what_moves(self, state: Increment, change: FloatArray) -> Increment | None:
        """Return the state from which what moves in a change (n,) is driven; None where that is local, or driven.

        The first increment is expected along that change: the state itself says nothing of the mechanism, and Newton's
        method would need up to its last iteration to find it.
        """
        if state.phase == "gravity":
            return None
        motion = body_motion(self.model, change) * ~state.fallen
        if self._is_local(state, motion):
            return None
        part = moving_part(self.model, motion) & ~state.fallen & state.driven
        mass = self.model.body_mass
        if state.phase == "displacement" and mass[part & state.driven].sum() > 0.5 * mass[part].sum():
            return None
        if not self.model.body_live[part].any() or float(driven_by(self.model, part).mean_row @ change) <= 0.0:
            return None
        driving = self._driving(replace(state, phase="displacement", moving=False), part)
        largest = self._largest("displacement")
        row = self.solver.model_of(driving).mean_row
        size = min(max(SHRINK * float(row @ state.change.ravel()), 1e-2 * largest), largest)
        change = read_only(change.reshape(-1, 3))
        return replace(driving, change=change, attempts=(), step=(size, float(row @ change.ravel())))

    def _driving(self, state: Increment, driven: BoolArray) -> Increment:
        state = replace(state, driven=read_only(driven, np.bool_))
        return replace(
            state, mean_displacement=float(self.solver.model_of(state).mean_row @ state.displacement.ravel())
        )

    def _largest(self, phase: Phase) -> float:
        """Return the largest increment of a phase, in its unit."""
        if phase == "gravity":
            return 1.0 / self.stepping.gravity_increments
        if phase == "load":
            return self.stepping.load_increment * self.expected_multiplier
        return self.solver.largest_displacement

    def _anew(self, aim: Aim, again: bool = False) -> tuple[float, float]:
        """Return the next increment after a slip or a motion, and the last one, in the unit of the phase.

        Where a displacement is prescribed it is not known yet how the wall moves on: it begins with the elastic slip,
        or twice the last one, if more, where it rests `again` after a motion, as in the increment before.
        """
        if aim.phase == "displacement":
            return min(max(self.model.slip_tolerance, 2.0 * aim.size * again), self._largest(aim.phase)), aim.size
        size = aim.size or SHRINK**2 * self._largest(aim.phase)
        return size, size

    def _length(self, state: Increment, solved: Increment) -> float:
        """Return how far an increment under displacement control goes, over the largest: by the displacement of the
        top, or by the multiplier where that is more; 0 in other phases."""
        if solved.phase != "displacement":
            return 0.0
        _, control_change = self.solver.last_changes(solved)
        carries_more = abs(solved.load_multiplier - state.load_multiplier) / self._largest("load")
        return max(abs(control_change) / self._largest("displacement"), carries_more)

    def _resolved(self, solved: Increment, length: float) -> float:
        """Return the increment up to which the curve after a static increment is resolved, in its phase's unit.

        Under displacement control it is that of the length 1; a part that slides inside the wall, which moves neither
        the top nor the multiplier, may go farther.
        """
        largest = self._largest(solved.phase)
        if solved.phase != "displacement":
            return largest
        return max(largest, self.solver.last_changes(solved)[0] / length) if length else np.inf

    def _aim(self, state: Increment, size: float) -> Aim:
        if state.phase == "gravity":
            return Aim("gravity", min(state.time + size, 1.0), size)
        mean_change, control_change = self.solver.last_changes(state)
        if state.phase == "load":
            size = self._to_the_end(state, size, state.load_multiplier, state.pushed)
            size = self._to_the_end(state, size, state.step[1], control_change)  # next to nothing after a motion
            return Aim("load", state.load_multiplier + size, size)
        if self.solver.was_driven(state):
            size = self._to_the_end(state, size, mean_change, control_change)
            fastest = float(np.max(body_motion(self.model, state.change.ravel()) / body_size(self.model)))
            size = min(size, max(FASTEST * mean_change / fastest, 1e-3 * size))
        return Aim("displacement", state.mean_displacement + size, size)

    def _to_the_end(self, state: Increment, size: float, went: float, moved: float) -> float:
        """Return an increment that does not go beyond the end of the curve if the top goes on as it `moved` (m) while
        what is prescribed `went` on, in its unit."""
        if not (went and moved):
            return size
        left = self.stepping.end_of(self.model.height) - np.sign(moved) * state.pushed
        return min(size, max(left * went / abs(moved), 1e-3 * size))

    def _held(self, state: Increment) -> Aim:
        """Return the aim that holds what a state in motion prescribes."""
        held = {"gravity": state.time, "load": state.load_multiplier, "displacement": state.mean_displacement}
        return Aim(state.phase, held[state.phase], 0.0)

    def _rests(self, state: Increment) -> bool:
        """Return whether all weight acts and the proximal term has faded below Newton's tolerance."""
        inertia = self.model.mass @ state.change.ravel() / np.square(self.solver.time_step(Aim("gravity", 1.0, 0.0)))
        quiet = np.linalg.norm(inertia) < self.newton.residual * np.linalg.norm(self.model.gravity)
        return state.time >= 1.0 and not state.moving and bool(quiet)

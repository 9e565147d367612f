"""One increment: what is prescribed, on which geometry, and Newton's method on it.

R_u = 0 of newton.py from the state before it, u_n: backward Euler of an overdamped flow.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import ConvergenceError
from orchestrator.pushover.increments import Attempt, Increment, Phase
from orchestrator.pushover.model import ContactModel, displaced, driven_by, without
from orchestrator.pushover.path.energies import slid_off, with_friction_of
from orchestrator.pushover.path.increment_record import increment_of, scattered, without_jumps
from orchestrator.pushover.path.moving import body_motion, body_thrust, body_turn
from orchestrator.pushover.path.prediction import carried_on
from orchestrator.pushover.settings import NewtonSettings, SteppingSettings
from orchestrator.pushover.solids.tie_bars import tightened
from orchestrator.pushover.solve.iterate import Iterate, Target, evaluate
from orchestrator.pushover.solve.linear_system import LinearSystem
from orchestrator.pushover.solve.newton import solve_increment

TURN = 2e-3
"""an increment whose bodies turn by more than this (rad) from the geometry that it is solved on is solved again on its
own: contacts of a body that turns by theta more than expected close to theta^2 / 2 of its size (2e-6), and their forces
are inclined by theta, in this increment only: by less where these are many times the live load (`_turns_allowed`). Once
it is solved again already from what a static body may be out of balance on: a wall under the load at which it turns
rests anywhere on one geometry. (With 5e-4 each time, loose stones at the limit of friction that turn one way on the
geometry of the other made walls creep: 4,950 and more than 14,442 iterations in place of 2,429 and 6,341.)"""
TURNED_OVER = 0.1
"""a solution in which a body has turned by more than this (rad) from the geometry that it was found on is no state
near: its contacts close to 0.5 % of its size (loose stones that fall under a held load turned by 1.1 rad, and by 1.6 on
the geometry of that, an eighth of the time of 230 stones; a throw-away script)"""
WEAK = 0.1
"""live load that limit analysis expects, over the weight of the wall, below which drag and balance of bodies are shares
of ten times that load: weight says nothing of what a slender wall bears"""
LEAST_LOAD = 0.1
"""part of the live load that limit analysis expects, or of WEAK, that stands for less where geometry is judged"""
FROM_BEFORE = "a second path, from the state before"
"""what an attempt says where no path led on from the expected state"""
OF_BEFORE = "friction of the normal forces before"
"""what an attempt says after which an increment or a step of motion was solved with that"""


@dataclass(frozen=True, slots=True)
class Aim:
    """What an increment prescribes: `value` of its phase's quantity (share, multiplier, m), `size` more than before."""

    phase: Phase
    value: float
    size: float


def measured_by(model: ContactModel, expected_multiplier: float) -> float:
    """Return what drag and balance of bodies are shares of, over their weight, where a load multiplier is expected."""
    return min(1.0, expected_multiplier * live_share(model) / WEAK)


def live_share(model: ContactModel) -> float:
    """Return the live load over the weight."""
    return float(model.body_live.sum() / model.body_weight.sum())


@dataclass(frozen=True, slots=True)
class IncrementSolver:
    """Solves single increments of a model.

    measure: what the drag of a body, and what it may be out of balance by, are shares of, over its weight.
    """

    model: ContactModel
    system: LinearSystem
    newton: NewtonSettings
    stepping: SteppingSettings
    measure: float = 1.0
    _models: dict[bytes, ContactModel] = field(default_factory=dict)

    def model_of(self, state: Increment) -> ContactModel:
        """Return the undeformed model with the bodies that a state drives, and without those that have fallen."""
        key = state.driven.tobytes() + state.fallen.tobytes()
        if key not in self._models:
            model = without(self.model, state.fallen) if state.fallen.any() else self.model
            self._models.clear()
            self._models[key] = model if state.driven.all() else driven_by(model, state.driven)
        return self._models[key]

    @property
    def largest_displacement(self) -> float:
        """The largest increment of the mean displacement, m."""
        return self.stepping.displacement_increment * self.stepping.end_of(self.model.height)

    def last_changes(self, state: Increment) -> tuple[float, float]:
        """Return the last change of the mean displacement of what is driven, and of the top, in m."""
        change, model = state.change.ravel(), self.model_of(state)
        return float(model.mean_row @ change), float(model.top_row @ change)

    def was_driven(self, state: Increment) -> bool:
        """Return whether the last change is an increment of what is driven now, not the end of a slip or a motion."""
        mean_change, _ = self.last_changes(state)
        return state.phase == "displacement" and state.step[1] > 0.0 and abs(mean_change / state.step[1] - 1) < 1e-3

    def share(self, state: Increment, aim: Aim) -> float:
        """Return the increment over the last one, at most 2; 0 where the last change is none of the same kind."""
        goes_on = aim.phase == "load" or self.was_driven(state)
        if aim.phase != state.phase or state.step[1] == 0.0 or aim.phase == "gravity" or not goes_on:
            return 0.0
        return min(aim.size / state.step[1], 2.0)

    def bent(self, state: Increment, solved: Increment, aim: Aim) -> float:
        """Return what an increment departs from the one before, over its length; 0 where that is of another kind.

        How hard the next one is to solve is told by this, not by the number of iterations, which rounding changes where
        Newton's matrix is nearly singular.
        """
        share, change = self.share(state, aim), solved.change.ravel()
        if not share:
            return 0.0
        return float(np.linalg.norm(change - share * state.change.ravel())) / max(float(np.linalg.norm(change)), 1e-300)

    def time_step(self, aim: Aim, fastest: float = 0.0) -> float:
        """Return the time step of a static increment, s: the drag of the `fastest` body (m, expected) has one share."""
        moves = largest = self.largest_displacement
        if aim.phase == "displacement":
            moves = max(aim.size, fastest, 1e-3 * largest)
        gravity = self.model.weight / float(self.model.body_mass.sum())
        return float(np.sqrt(moves / (self.measure * self.stepping.proximal_share * gravity)))

    def static(self, state: Increment, aim: Aim, friction_of_before: bool = False) -> Increment:
        """Return the static increment; its proximal term carries the same share of every size of displacement.

        friction_of_before: where Coulomb's friction leaves none, that of the normal forces before is taken.
        """
        here, share = state.displacement.ravel(), self.share(state, aim)
        predicted = carried_on(self.model, here, state.change.ravel(), share) if share else here
        fastest = share * float(body_motion(self.model, state.change.ravel()).max())
        solved = self.solved if friction_of_before else self._solved
        return solved(state, aim, predicted, self.time_step(aim, fastest))

    def solved(
        self, state: Increment, aim: Aim, predicted: FloatArray, time_step: float, viscosity: float = 0.0
    ) -> Increment:
        """Return the increment of Coulomb's friction; where it leaves none, that of the normal forces before, which
        leaves one but for bonds that soften, and is out of balance by what they change."""
        try:
            return self._solved(state, aim, predicted, time_step, viscosity)
        except ConvergenceError as error:
            if error.stage == "geometry":
                raise
            failed = Attempt(str(error), aim.size, OF_BEFORE, error.iterations)
        try:
            found = self._solved(state, aim, predicted, time_step, viscosity, friction_of_before=True)
        except ConvergenceError as error:
            raise ConvergenceError(error.stage, error.where, error.iterations + failed.iterations) from error
        return replace(found, attempts=(failed, *found.attempts))

    def _solved(
        self,
        state: Increment,
        aim: Aim,
        predicted: FloatArray,
        time_step: float,
        viscosity: float = 0.0,
        *,
        friction_of_before: bool = False,
    ) -> Increment:
        """Solve on the geometry of the predicted displacement, again where bodies have turned away from it.

        friction_of_before: friction follows the normal forces of `state`.
        """
        undeformed = self.model_of(state)
        problem = self._target(undeformed, state, aim, time_step, viscosity)
        multiplier = aim.value if aim.phase == "load" else state.load_multiplier
        force, attempts, spent, excess_before = state.normal_force, list[Attempt](), 0, np.inf
        opening, closed = state.gap, None
        if undeformed.mortar is not None:
            mortar = replace(undeformed.mortar, closing=state.closing)
            opening, closed = mortar.opened(opening, state.normal_force), mortar.closed_by(state.normal_force)
        measures = {"gravity": 1.0, "load": abs(multiplier) * live_share(self.model), "displacement": self.measure}
        bound = self.stepping.out_of_balance * measures[aim.phase]
        known = ~np.isnan(state.gap)
        while True:
            model = without_jumps(displaced(undeformed, predicted, closed, known), state)
            self.system.follow(model)
            here = _on_its_contacts(model, problem, state, opening, friction_of_before)
            first = evaluate(model, here, predicted, model.on_its_contacts(force), multiplier)
            try:
                iterate = self._converged(model, here, first, aim, attempts)
            except ConvergenceError as error:
                raise ConvergenceError(error.stage, error.where, spent + error.iterations) from error
            spent += iterate.number
            turned = body_turn(self.model, predicted, iterate.displacement)
            excess = float((turned / self._turns_allowed(model, iterate, aim)).max())
            if excess < 1.0 and (excess_before < np.inf or turned.max() < bound):
                break
            if excess >= excess_before or turned.max() >= TURNED_OVER:  # such passes swing between two states
                raise ConvergenceError("geometry", f"bodies turn by {turned.max():.1e} more than expected", spent)
            excess_before = excess
            predicted, multiplier = iterate.displacement, iterate.load_multiplier
            force = scattered(state.normal_force, model.rows, iterate.normal_force)
            known = known | (scattered(np.zeros(len(known)), model.rows, iterate.normal_force) > 0.0)
        own = spent - sum(attempt.iterations for attempt in attempts)
        time = aim.value if aim.phase == "gravity" else state.time + time_step
        found = increment_of(model, state, here, replace(iterate, number=own), aim.phase, time, bound)
        contacts = slid_off(model, state)
        if len(contacts):
            before = displaced(undeformed, state.displacement.ravel(), closed, known)
            found = with_friction_of(found, state, before, contacts)
        return replace(found, attempts=tuple(attempts))

    def _turns_allowed(self, model: ContactModel, iterate: Iterate, aim: Aim) -> FloatArray:
        """Return by what angle (b,) in rad bodies may have turned from the geometry that an iterate was found on: the
        forces that go through them are inclined by it, by which the live load may be wrong as it may be out of balance.

        Thin arches had peaks up to 12 % above what they bore under prescribed displacements, with 2e-3 rad for all.
        """
        least = LEAST_LOAD * WEAK * self.measure * self.model.weight
        live = max(abs(iterate.load_multiplier) * float(self.model.body_live.sum()), least)
        load = self.model.weight if aim.phase == "gravity" else live
        through = np.maximum(body_thrust(model, iterate.normal_force), 1e-9 * self.model.weight)
        return np.minimum(TURN, self.stepping.out_of_balance * load / through)

    def _target(
        self, undeformed: ContactModel, state: Increment, aim: Aim, time_step: float, viscosity: float
    ) -> Target:
        """Return what is prescribed after a state, but for what each contact has of its own."""
        ties, share = None, aim.value if aim.phase == "gravity" else None
        if undeformed.ties is not None:
            ties = tightened(undeformed.ties, state.tie_rest, share)
        return Target(
            gravity_share=1.0 if share is None else share,
            displacement=state.displacement.ravel(),
            elastic_slip=state.elastic_slip,
            time_step=time_step,
            mean_displacement=aim.value if aim.phase == "displacement" else None,
            reference_force=0.0 if state.number else self.model.weight / len(self.model.contacts),
            viscosity=viscosity,
            ties=ties,
        )

    def _converged(
        self, model: ContactModel, problem: Target, first: Iterate, aim: Aim, attempts: list[Attempt]
    ) -> Iterate:
        """Return the solution to which a path leads from the expected state, or else from the one before it.

        The path that leads nowhere is added to `attempts`; its iterations count in the number of the iterate, too. A
        step of motion has no second one, which costs more there than friction of the normal forces before; that has
        none either, as its problem is convex.
        """
        try:
            return solve_increment(model, self.system, problem, first, self.newton)
        except ConvergenceError as error:
            alone = problem.viscosity > 0.0 or problem.pressure is not None
            if alone or np.array_equal(first.displacement, problem.displacement):
                raise
            cause, spent = str(error), error.iterations
        first = evaluate(model, problem, problem.displacement, first.normal_force, first.load_multiplier)
        try:
            found = solve_increment(model, self.system, problem, first, self.newton)
        except ConvergenceError as error:
            where = f"neither from the expected state nor from the one before: {error.where}"
            raise ConvergenceError(error.stage, where, spent + error.iterations) from error
        attempts.append(Attempt(cause, aim.size, FROM_BEFORE, spent))
        return replace(found, number=spent + found.number)


def _on_its_contacts(
    model: ContactModel, problem: Target, state: Increment, opening: FloatArray, friction_of_before: bool
) -> Target:
    """Return what is prescribed with what the contacts of a displaced model have from the state before."""
    touch = model.on_its_contacts((state.normal_force != 0.0).astype(float)) > 0.0
    return replace(
        problem,
        elastic_slip=model.on_its_contacts(problem.elastic_slip),
        bond=model.bond and model.bond.at(model.rows, state.damage, state.slip, opening),
        mortar=model.mortar and model.mortar.at(model.rows, state.closing, state.normal_force),
        damped=touch if touch.any() else None,
        pressure=model.on_its_contacts(state.normal_force) if friction_of_before else None,
    )

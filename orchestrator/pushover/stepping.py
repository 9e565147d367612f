"""Gravity, load ramp, displacement control: one generator each of converged increments, and `pushover`, their chain.

Every increment solves R_u = 0 of newton.py with a different inertia reference:

    gravity, displacement control: u_ref = u_n, dt = proximal time (a proximal term, no history of velocity)
    ramp (backward Euler):         u_ref = u_n + dt v_n, and v = (u - u_n)/dt afterwards

The ramp's base shear falls behind multiplier x weight as soon as a mechanism moves; the increment that shows this is
dropped, and from the one before on the mean displacement is prescribed and the load multiplier is an unknown, so that
the reported peak is a static one.

A failed increment is tried again smaller: the ramp cuts its time step; displacement control cuts the increment by 4 and
the proximal time by 2 together, which keeps the inertia's share du/dt^2 (where no static state is near, cutting the
increment alone cannot help).
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
import numpy.typing as npt

from orchestrator.errors import ConvergenceError
from orchestrator.masonry.wall import FloatArray, IntArray, read_only
from orchestrator.pushover.linear_system import LinearSystem
from orchestrator.pushover.model import ContactModel
from orchestrator.pushover.newton import Iterate, Problem, evaluate, solve_increment
from orchestrator.pushover.settings import NewtonSettings, SteppingSettings
from orchestrator.pushover.state import Attempt, ContactStatus, Increment, Phase

logger = logging.getLogger(__name__)

EASY = 8
"""iterations up to which the next increment may grow"""


@dataclass(frozen=True, slots=True)
class Step:
    """Size of an increment (share of gravity, time in s, or mean displacement in m) and time dt of its inertia term."""

    size: float
    time: float


@dataclass(frozen=True, slots=True)
class Policy:
    """How steps shrink after a failure and grow after success; smaller than `smallest` is giving up."""

    largest: Step
    smallest: float
    shrink: Step
    grow: Step

    def reduced(self, step: Step, error: ConvergenceError) -> Step:
        """Return the next smaller step. Raises ConvergenceError from `error` below the smallest."""
        smaller = Step(step.size * self.shrink.size, step.time * self.shrink.time)
        if smaller.size < self.smallest:
            raise ConvergenceError("stepping", f"no increment above {self.smallest:g} converges ({error})") from error
        return smaller

    def after(self, iterations: int, step: Step) -> Step:
        """Return the step after one that took so many iterations."""
        if iterations > EASY:
            return step
        return Step(
            min(step.size * self.grow.size, self.largest.size), min(step.time * self.grow.time, self.largest.time)
        )


def at_rest(model: ContactModel) -> Increment:
    """Return the stress-free wall without weight, the start of gravity (number 0)."""
    count, nodes = len(model.contacts), len(model.meshes.nodes)
    zero = read_only(np.zeros(count))
    return Increment(
        number=0,
        phase="gravity",
        time=0.0,
        load_multiplier=0.0,
        displacement=read_only(np.zeros((nodes, 3))),
        velocity=read_only(np.zeros((nodes, 3))),
        normal_force=zero,
        elastic_slip=read_only(np.zeros((count, 2))),
        slip=zero,
        gap=zero,
        status=read_only(np.full(count, ContactStatus.STICK), np.int64),
        base_shear=0.0,
        control_displacement=0.0,
        mean_displacement=0.0,
        kinetic_energy=0.0,
        internal_energy=0.0,
        dissipated_energy=0.0,
        external_work=0.0,
        equilibrium_residual=0.0,
        iterations=0,
        step=(0.0, 0.0, 0.0, 0.0),
    )


SolveStep = Callable[[Increment, Step], Increment]


def follow(state: Increment, step: Step, solve_step: SolveStep, policy: Policy) -> Iterator[Increment]:
    """Yield converged increments for ever; after a failure try again smaller. Raises ConvergenceError at the end."""
    attempts: tuple[Attempt, ...] = ()
    while True:
        try:
            solved = solve_step(state, step)
        except ConvergenceError as error:
            smaller = policy.reduced(step, error)
            attempts += (Attempt(str(error), step.size, f"retried with {smaller.size:g}", error.iterations),)
            step = smaller
            continue
        following = policy.after(solved.iterations, step)
        state = replace(solved, attempts=attempts, step=(following.size, following.time, step.size, step.time))
        step, attempts = following, ()
        yield state


@dataclass(frozen=True, slots=True)
class Pushover:
    """A contact model, its linear system and the settings: what all three phases share."""

    model: ContactModel
    system: LinearSystem
    newton: NewtonSettings
    stepping: SteppingSettings

    def increments(self, last: Increment | None = None) -> Iterator[Increment]:
        """Yield gravity, ramp and displacement control up to the final displacement, or continue after `last`.

        Raises ConvergenceError when no further increment converges; everything yielded before stays valid.
        """
        state = last or at_rest(self.model)
        for phase in (self._gravity, self._ramp, self._displacement_control):
            for following in phase(state):
                state = following
                yield state

    def finished(self, state: Increment) -> bool:
        """Return whether the curve has reached its end: the final displacement or the largest number of increments."""
        reached = state.control_displacement >= self.stepping.final_displacement
        return state.phase != "gravity" and (reached or state.number >= self.stepping.largest_increments)

    def _gravity(self, state: Increment) -> Iterator[Increment]:
        if state.phase != "gravity":
            return
        share = 1.0 / self.stepping.gravity_increments
        policy = Policy(Step(share, self.stepping.proximal_time), 1e-3 * share, Step(0.5, 1.0), Step(2.0, 1.0))
        step = Step(*state.step[:2]) if state.number else policy.largest
        if self._rests(state):
            return
        for solved in islice(follow(state, step, self._solve_gravity, policy), self.stepping.largest_increments):
            yield solved
            if self._rests(solved):
                return
        raise ConvergenceError("gravity", "the wall keeps moving under its own weight")

    def _rests(self, state: Increment) -> bool:
        """Return whether all weight acts and the proximal term has faded below Newton's tolerance."""
        inertia = self.model.mass @ state.velocity.ravel() / self.stepping.proximal_time
        quiet = np.linalg.norm(inertia) < self.newton.residual * np.linalg.norm(self.model.gravity)
        return state.time >= 1.0 and bool(quiet)

    def _solve_gravity(self, state: Increment, step: Step) -> Increment:
        share = min(state.time + step.size, 1.0)
        problem = Problem(
            gravity_share=share,
            displacement=state.displacement.ravel(),
            elastic_slip=state.elastic_slip,
            inertia_reference=state.displacement.ravel(),
            time_step=step.time,
            mean_displacement=None,
            reference_force=0.0 if state.number else self.model.weight / len(self.model.contacts),
        )
        return replace(self._solved(state, problem, state.displacement.ravel(), 0.0, "gravity"), time=share)

    def _ramp(self, state: Increment) -> Iterator[Increment]:
        if state.phase == "displacement" or self.finished(state):
            return
        largest = self.stepping.time_step
        policy = Policy(Step(largest, 1.0), 1e-3 * largest, Step(1 / 3, 1.0), Step(1.5, 1.0))
        if state.phase == "gravity":
            state = replace(state, velocity=read_only(np.zeros_like(state.velocity)), time=0.0)
            step = policy.largest
        else:
            step = Step(*state.step[:2])
        try:
            for solved in follow(state, step, self._solve_ramp, policy):
                if self._inertia_shows(solved):
                    return
                yield solved
                if self.finished(solved):
                    return
        except ConvergenceError as error:
            logger.info("the ramp ends, displacement control goes on: %s", error)

    def _solve_ramp(self, state: Increment, step: Step) -> Increment:
        displacement = state.displacement.ravel()
        predicted = displacement + step.size * state.velocity.ravel()
        problem = Problem(
            gravity_share=1.0,
            displacement=displacement,
            elastic_slip=state.elastic_slip,
            inertia_reference=predicted,
            time_step=step.size,
            mean_displacement=None,
        )
        multiplier = state.load_multiplier + self.stepping.load_rate * step.size
        return replace(self._solved(state, problem, predicted, multiplier, "ramp"), time=state.time + step.size)

    def _inertia_shows(self, state: Increment) -> bool:
        shortfall = state.load_multiplier - state.base_shear / self.model.weight
        return state.phase == "ramp" and shortfall > self.stepping.inertia_share

    def _displacement_control(self, state: Increment) -> Iterator[Increment]:
        if self.finished(state):
            return
        largest = Step(self.stepping.displacement_increment, self.stepping.proximal_time)
        policy = Policy(largest, 1e-12, Step(0.25, 0.5), Step(1.4, 1.4))
        if state.phase == "displacement":
            step = Step(*state.step[:2])
        else:
            last = float(self.model.mean_row @ state.velocity.ravel()) * state.step[2]
            step = Step(min(max(last, 1e-3 * largest.size), largest.size), largest.time)
        for solved in follow(state, step, self._solve_displacement, policy):
            yield solved
            if self.finished(solved):
                break

    def _solve_displacement(self, state: Increment, step: Step) -> Increment:
        displacement = state.displacement.ravel()
        last_change = state.velocity.ravel() * state.step[3 if state.phase == "displacement" else 2]
        mean_change = float(self.model.mean_row @ last_change)
        share = step.size / mean_change if mean_change > 0 else 0.0
        problem = Problem(
            gravity_share=1.0,
            displacement=displacement,
            elastic_slip=state.elastic_slip,
            inertia_reference=displacement,
            time_step=step.time,
            mean_displacement=state.mean_displacement + step.size,
        )
        predicted = displacement + min(share, 2.0) * last_change
        solved = self._solved(state, problem, predicted, state.load_multiplier, "displacement")
        return replace(solved, time=state.time + step.time)

    def _solved(
        self, state: Increment, problem: Problem, predicted: FloatArray, multiplier: float, phase: Phase
    ) -> Increment:
        first = evaluate(self.model, problem, predicted, state.normal_force, multiplier)
        iterate = solve_increment(self.model, self.system, problem, first, self.newton)
        return _increment(self.model, state, problem, iterate, phase)


def _increment(model: ContactModel, state: Increment, problem: Problem, iterate: Iterate, phase: Phase) -> Increment:
    """Return the converged iterate as the increment after `state`; `time` and `step` are the caller's to set."""
    force = np.where(iterate.active, np.maximum(iterate.normal_force, 0.0), 0.0)
    closed = iterate.active & (force > 0.0)
    elastic_slip = np.where(closed[:, None], iterate.response.elastic_slip, 0.0)
    change = iterate.displacement - problem.displacement
    slip_change = (model.tangential_rows @ change).reshape(-1, 2)
    plastic = np.where(closed[:, None], slip_change - (elastic_slip - problem.elastic_slip), 0.0)
    velocity = change / problem.time_step
    load = problem.gravity_share * model.gravity + iterate.load_multiplier * model.lateral
    earlier = _gravity_share(state) * model.gravity + state.load_multiplier * model.lateral
    return Increment(
        number=state.number + 1,
        phase=phase,
        time=state.time,
        load_multiplier=iterate.load_multiplier,
        displacement=read_only(iterate.displacement.reshape(-1, 3)),
        velocity=read_only(velocity.reshape(-1, 3)),
        normal_force=read_only(force),
        elastic_slip=read_only(elastic_slip),
        slip=read_only(state.slip + np.linalg.norm(plastic, axis=1)),
        gap=read_only(iterate.gap),
        status=read_only(_status(closed, iterate.response.sliding), np.int64),
        base_shear=_base_shear(model, iterate),
        control_displacement=float(model.top_row @ iterate.displacement),
        mean_displacement=float(model.mean_row @ iterate.displacement),
        kinetic_energy=0.5 * float(velocity @ (model.mass @ velocity)),
        internal_energy=_internal_energy(model, iterate, force, elastic_slip),
        dissipated_energy=state.dissipated_energy + float(np.sum(iterate.response.traction * plastic)),
        external_work=state.external_work + 0.5 * float((load + earlier) @ change),
        equilibrium_residual=iterate.norms[0],
        iterations=iterate.number,
        step=state.step,
    )


def _status(closed: npt.NDArray[np.bool_], sliding: npt.NDArray[np.bool_]) -> IntArray:
    return np.where(closed, np.where(sliding, ContactStatus.SLIP, ContactStatus.STICK), ContactStatus.OPEN)


def _gravity_share(state: Increment) -> float:
    return state.time if state.phase == "gravity" else 1.0


def _base_shear(model: ContactModel, iterate: Iterate) -> float:
    """Return the horizontal force of the supports on the wall against the load, N."""
    x_on_wall = iterate.normal_force * model.contacts.normal[:, 0]
    x_on_wall = x_on_wall - iterate.response.traction[:, 0] * model.contacts.tangent[:, 0]
    return -model.direction * float(x_on_wall[model.on_support].sum())


def _internal_energy(
    model: ContactModel, iterate: Iterate, normal_force: FloatArray, elastic_slip: FloatArray
) -> float:
    """Return elastic energy of the bodies and of the elastic slip, J."""
    strain = 0.5 * float(iterate.displacement @ (model.stiffness @ iterate.displacement))
    stiffness = model.contacts.friction * normal_force / model.slip_tolerance
    return strain + 0.5 * float(stiffness @ np.sum(elastic_slip**2, axis=1))

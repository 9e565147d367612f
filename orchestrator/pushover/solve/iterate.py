"""State of a trial solution of one increment: residuals and contact response (equations in newton.py)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray
from orchestrator.pushover.contact.cohesion import Bond, BondResponse, bond_response
from orchestrator.pushover.contact.contact_law import FrictionResponse, friction_response
from orchestrator.pushover.contact.mortar import Mortar
from orchestrator.pushover.model import ContactModel
from orchestrator.pushover.solids.tie_bars import TieHistory, TieResponse, tie_response

EPSILON = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False, slots=True)
class Target:
    """What one increment asks for (n displacements, c contacts).

    gravity_share: part of the own weight that acts. displacement (n,) and elastic_slip (c, 2) at the start, m.
    time_step dt in s: inertia M (u - u_n)/dt^2, u_n the displacement at the start. Either `mean_displacement` (m) is
    prescribed or, where it is None, the load multiplier of the first iterate stays. reference_force: normal force (N)
    that friction sees in the very first iterate of a wall without any contact force yet, else 0. viscosity (N/m):
    contacts that were closed at the start (damped (c,)) resist slip by viscosity x (slip since then) besides friction,
    whether they stay closed or not: a force that came and went with the contact could leave a step without a solution.
    Bonded ones resist opening likewise. pressure (c,): normal force in N that friction follows, None: that of the
    contacts in this increment. bond: strengths and history of the contacts, None where no joint has any;
    mortar: stiffness, strength and history likewise. ties: history of the ties, None without any.
    """

    gravity_share: float
    displacement: FloatArray
    elastic_slip: FloatArray
    time_step: float
    mean_displacement: float | None
    reference_force: float = 0.0
    viscosity: float = 0.0
    damped: BoolArray | None = None
    pressure: FloatArray | None = None
    bond: Bond | None = None
    mortar: Mortar | None = None
    ties: TieHistory | None = None

    @property
    def shear_stiffness(self) -> FloatArray | None:
        """Shear stiffness of each contact (c,) in N/m, None where no joint has any."""
        return None if self.mortar is None else self.mortar.shear_stiffness

    def viscosities(self, contacts: int) -> FloatArray:
        """Return the viscosity of each contact (c,) in N/m."""
        return self.viscosity * (np.ones(contacts) if self.damped is None else self.damped.astype(float))


@dataclass(frozen=True, eq=False, slots=True)
class Iterate:
    """displacement (n,), normal_force (c,), load multiplier, and what follows from them.

    force_residual (n,) in N, gap (c,) in m (what mortar leaves of it), active (c,): closed, crushes (c,): of those.
    strength in N: what they crush at (c,), or infinity. `norms`: force residual / weight, largest |gap| of an active
    contact (m), largest |normal force| of an inactive one / weight, error of the mean displacement (m). of_bodies: the
    largest force residual of a body, added up by its size, or force of an inactive contact, / the weight of the
    (lighter) body. rounding: what summing K u leaves of the force residual / weight in double precision, a bound that
    thin walls reach. pull (c,) in N: tension that a contact carries when it opens, its slope pull_slope (c,) in N/m;
    bond: the rest of that, or None.
    """

    displacement: FloatArray
    normal_force: FloatArray
    load_multiplier: float
    force_residual: FloatArray
    gap: FloatArray
    active: BoolArray
    response: FrictionResponse
    norms: tuple[float, float, float, float]
    of_bodies: float
    rounding: float
    pull: FloatArray
    pull_slope: FloatArray
    bond: BondResponse | None
    crushes: BoolArray
    strength: FloatArray | float
    ties: TieResponse | None = None
    number: int = 0


def evaluate(
    model: ContactModel, problem: Target, displacement: FloatArray, normal_force: FloatArray, multiplier: float
) -> Iterate:
    """Return residuals and contact response of a trial state."""
    gap = model.normal_rows @ displacement + model.gap_offset
    mortar = problem.mortar
    if mortar is not None:
        gap = mortar.opened(gap, normal_force)
    response, bond, pull, pull_slope = _resistance(model, problem, displacement, normal_force, gap)
    pressed = normal_force - model.contact_stiffness * gap
    active = normal_force + pull - model.contact_stiffness * gap >= 0.0
    strength = np.inf if mortar is None else mortar.strength
    crushes = active & (pressed >= strength)
    off = np.where(crushes, normal_force - strength, normal_force + pull)  # forces given where contacts open or crush
    strained = displacement - model.rigid
    residual = (
        model.stiffness @ strained
        + model.mass @ (displacement - problem.displacement) / np.square(problem.time_step)
        - problem.gravity_share * model.gravity
        - multiplier * model.lateral
        - model.normal_columns @ normal_force
        + model.tangential_columns @ response.traction.ravel()
    )
    ties = None
    if model.ties is not None and problem.ties is not None:
        ties = tie_response(model.ties, problem.ties, displacement)
        residual = residual + model.ties.rows.T @ ties.force
    weight = float(np.linalg.norm(model.gravity))
    return Iterate(
        displacement=displacement,
        normal_force=normal_force,
        load_multiplier=multiplier,
        force_residual=residual,
        gap=gap,
        active=active,
        response=response,
        norms=(
            float(np.linalg.norm(residual)) / weight,
            float(np.max(np.abs(gap[active & ~crushes]), initial=0.0)),
            float(np.max(np.abs(off[~active | crushes]), initial=0.0)) / model.weight,
            abs(control_error(model, problem, displacement)),
        ),
        of_bodies=max(
            out_of_balance(model, residual), _of_lighter_bodies(model, np.where(~active | crushes, off, 0.0))
        ),
        rounding=EPSILON * float(np.linalg.norm(model.stiffness_magnitude @ np.abs(displacement))) / weight,
        pull=pull,
        pull_slope=pull_slope,
        bond=bond,
        crushes=crushes,
        strength=strength,
        ties=ties,
    )


def _resistance(
    model: ContactModel, problem: Target, displacement: FloatArray, normal_force: FloatArray, gap: FloatArray
) -> tuple[FrictionResponse, BondResponse | None, FloatArray, FloatArray]:
    """Return friction, viscosity and bonds of the contacts, what is left of the bonds, and the tension (c,) in N that
    they carry when they open, with its slope (c,) in N/m."""
    slip = (model.tangential_rows @ (displacement - problem.displacement)).reshape(-1, 2)
    trial = problem.elastic_slip + slip
    pressure, friction = normal_force if problem.pressure is None else problem.pressure, model.contacts.friction
    response = friction_response(trial, pressure, friction, model.slip_tolerance, problem.shear_stiffness)
    bond = None
    pull = pull_slope = np.zeros(len(gap))
    if problem.bond is not None:
        bond, holds = bond_response(problem.bond, gap, trial, model.slip_tolerance), problem.bond.holds
        response = response.bonded(trial, pressure, friction, bond)
        pull = bond.tension + problem.viscosity * holds * (gap - problem.bond.opening)
        pull_slope = bond.tension_slope + problem.viscosity * holds
    response = response if problem.pressure is None else response.at_given_pressure()
    return response.damped(slip, problem.viscosities(len(gap))), bond, pull, pull_slope


def control_error(model: ContactModel, problem: Target, displacement: FloatArray) -> float:
    """Return what the mean displacement is short of the prescribed one, m."""
    if problem.mean_displacement is None:
        return 0.0
    return problem.mean_displacement - float(model.mean_row @ displacement)


def out_of_balance(model: ContactModel, force: FloatArray) -> float:
    """Return the largest force (n,) in N on a body that equilibrium does not explain, over the body's weight.

    The forces on the nodes of a body are added up by their size, so that those that turn it count too.
    """
    node = np.linalg.norm(force.reshape(-1, 3)[:, :2], axis=1)
    of_body = np.bincount(model.body, node, model.bodies)
    return float(np.max(of_body[: model.bodies] / model.body_weight, initial=0.0))


def _of_lighter_bodies(model: ContactModel, force: FloatArray) -> float:
    """Return the largest force (c,) in N of a contact over the weight of the lighter body that it acts on."""
    weight = np.append(model.body_weight, np.inf)  # supports
    bodies = (np.minimum(body, model.bodies) for body in (model.contacts.slave_body, model.contacts.master_body))
    return float(np.max(np.abs(force) / np.minimum(*(weight[body] for body in bodies)), initial=0.0))

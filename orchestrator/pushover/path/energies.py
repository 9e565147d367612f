"""Works and energies of an increment.

Every work of an increment is computed from the forces at its two ends, and nothing is a rest:

    external      1/2 (f0 + f1) du                of dead and live load
    friction      1/2 (k0 + k1) q1 dq_plastic     at its limit while it slides, k = mu lambda / gamma, and the exact
                                                  integral of the fracture of bonded joints; dq_plastic is all that is
                                                  not elastic: what an opening contact gives off, too
    crushing      f_c A dw                        of mortar
    yielding      N dr                            of ties, N at its limit; what tightens them is external
    other         -1/2 (lambda0 + lambda1) dG     gaps that open and close under force (G of mortar.py)
                  -1/2 (k1 - k0) q0 q1            pressure makes a contact that sticks stiffer
                  1/2 (N0 + N1) (dD - dN/k - dr)  ties that become taut or slack
                  (proximal, viscous force) du    what the increment resists besides

A contact that goes, with its force, off the end of a face has half of the friction of the start, as one that comes has
half of that of the end: on the geometry before the increment. What its force does where it then falls past the face is
no work of equilibrium, and stays missing.

External work less these is what stored energy must have grown by (elastic energy of the bodies, of the elastic slip,
of mortar and of ties). The difference is `energy_error`. An increment that moves is no path of equilibrium: what it
takes from the balance is `lost_in_motion`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.pushover.contact.cohesion import dissipation, shear_limit
from orchestrator.pushover.contact.contact_law import tolerances
from orchestrator.pushover.contact.mortar import Mortar
from orchestrator.pushover.increments import ContactStatus, Increment
from orchestrator.pushover.model import ContactModel
from orchestrator.pushover.path.curve_checks import ENERGY
from orchestrator.pushover.solve.iterate import Iterate, Target


@dataclass(frozen=True, eq=False, slots=True)
class ContactsAtEnd:
    """The c contacts at the end of an increment: force (c,) in N, elastic_slip (c, 2) and slip that is not elastic,
    sliding (c, 2), in m, holds (c,): closed or bonded, status (c,). closing (c,): what mortar has crushed by, given
    (c,): what it gives way by in all, m."""

    force: FloatArray
    elastic_slip: FloatArray
    sliding: FloatArray
    holds: BoolArray
    status: IntArray
    closing: FloatArray
    given: FloatArray


@dataclass(frozen=True, slots=True)
class Energies:
    """Stored energy at the end; what the increment dissipates, external and other work, that of the live load alone,
    and what is missing in the balance, J."""

    internal: float
    dissipated: float
    external: float
    other: float
    live: float
    missing: float


def at_the_end(model: ContactModel, problem: Target, iterate: Iterate) -> ContactsAtEnd:
    """Return the contacts of a converged iterate."""
    bond, mortar, count = iterate.bond, problem.mortar, len(iterate.gap)
    remains = np.zeros(count) if bond is None else bond.tension
    bonded = np.zeros(count, bool) if bond is None else bond.intact & (bond.damage < 1.0)
    force = np.where(iterate.active, np.maximum(iterate.normal_force, 0.0 - remains), 0.0 - remains)
    closing, given = np.zeros(count), np.zeros(count)
    if mortar is not None:
        force = np.where(iterate.crushes, mortar.strength, force)
        closing = mortar.closing + np.where(iterate.crushes, np.maximum(-iterate.gap, 0.0), 0.0)
        given = mortar.compliance * iterate.normal_force + mortar.closing
    closed = iterate.active & ((force > 0.0) | bonded)
    holding = np.where(iterate.response.sliding, ContactStatus.SLIP, ContactStatus.STICK)
    holds = closed | bonded
    elastic_slip = np.where(holds[:, None], iterate.response.elastic_slip, 0.0)
    slip = (model.tangential_rows @ (iterate.displacement - problem.displacement)).reshape(-1, 2)
    return ContactsAtEnd(
        force=force,
        elastic_slip=elastic_slip,
        sliding=slip - (elastic_slip - problem.elastic_slip),  # a contact that opens gives off its elastic slip
        holds=holds,
        status=np.where(closed, holding, ContactStatus.OPEN),
        closing=closing,
        given=given,
    )


def energies(
    model: ContactModel, state: Increment, problem: Target, iterate: Iterate, contacts: ContactsAtEnd, resisted: float
) -> Energies:
    """Return works and energies of an increment; resisted: work against mass and viscosity, J."""
    change = iterate.displacement - problem.displacement
    load = problem.gravity_share * model.gravity + iterate.load_multiplier * model.lateral
    share = state.time if state.phase == "gravity" else 1.0
    earlier = share * model.gravity + state.load_multiplier * model.lateral
    work = 0.5 * float((load + earlier) @ change)
    live = 0.5 * (state.load_multiplier + iterate.load_multiplier) * float(model.lateral @ change)
    friction = _friction(model, state, problem, iterate, contacts)
    if problem.mortar is not None:
        friction += float(contacts.force @ (contacts.closing - problem.mortar.closing))
    in_ties, tightening, yielding, slack = _work_of_ties(model, state, problem, iterate)
    work, friction = work + tightening, friction + yielding
    internal = in_ties + _internal_energy(model, iterate, contacts.elastic_slip, problem.mortar, contacts.force)
    other = _other_work(model, state, problem, iterate, contacts, change) + resisted
    other += slack
    missing = work - friction - other - (internal - state.internal_energy)
    return Energies(internal, friction, work, other, live, missing)


def slid_off(model: ContactModel, state: Increment) -> IntArray:
    """Return the numbers of the contacts that carried a force in a state, and that `model` has no more and handed to no
    other."""
    carried = np.flatnonzero(state.normal_force > 0.0)
    return np.setdiff1d(carried, np.append(model.rows, model.heirs[:, 0]))


def with_friction_of(found: Increment, state: Increment, before: ContactModel, contacts: IntArray) -> Increment:
    """Return the increment after a state with the friction of `contacts` that have gone; before: that state's model."""
    here = np.isin(before.rows, contacts)
    rows, shear_stiffness = before.rows[here], None
    if before.mortar is not None:
        shear_stiffness = before.mortar.at(rows, state.closing, state.normal_force).shear_stiffness
    limit = before.contacts.friction[here] * state.normal_force[rows]
    stiffness = limit / tolerances(limit, before.slip_tolerance, shear_stiffness)[0]
    slip, held = (before.tangential_rows @ found.change.ravel()).reshape(-1, 2)[here], state.elastic_slip[rows]
    friction = 0.5 * float(stiffness @ np.sum(held * (slip + held), axis=1))
    return replace(
        found,
        dissipated_energy=found.dissipated_energy + friction,
        lost_in_motion=found.lost_in_motion - found.moving * friction,
        energy_error=found.energy_error - (not found.moving) * friction,
    )


def balances(state: Increment, solved: Increment) -> bool:
    """Return whether work and energies of a static increment balance by themselves as those of a whole curve must.

    Else it may be a jump from one path of equilibrium to another. The live load's work is taken at its largest so far,
    for where the load has fallen to nothing it does none. From a state in motion, and under gravity, no path leads.
    """
    if solved.phase == "gravity" or state.gone.any():
        return True
    live = solved.largest_base_shear * abs(solved.mean_displacement - state.mean_displacement)
    stored = abs(solved.internal_energy - state.internal_energy)
    turned_over = live + stored + abs(solved.dissipated_energy - state.dissipated_energy)
    return abs(solved.energy_error - state.energy_error) <= ENERGY * turned_over


def _friction(
    model: ContactModel, state: Increment, problem: Target, iterate: Iterate, contacts: ContactsAtEnd
) -> float:
    """Return the work of friction and of bonds that break, J."""
    limit, cohesion, tolerance = _limit_before(model, state, problem)
    holds, sliding = contacts.holds, contacts.sliding
    slides = np.where(holds[:, None], iterate.response.elastic_slip, problem.elastic_slip)  # at its limit, all along
    before = (limit - cohesion)[:, None] * slides / np.where(holds, iterate.response.tolerance, tolerance)[:, None]
    friction = 0.5 * float(np.sum((before + iterate.response.traction) * sliding))
    if problem.bond is not None and iterate.bond is not None:
        bond = iterate.bond
        left = (bond.intact * bond.cohesion / iterate.response.tolerance)[:, None] * iterate.response.elastic_slip
        friction += 0.5 * float(np.sum(left * sliding))  # all of it: `dissipation` has only what is beyond it
        friction += float(dissipation(problem.bond, bond, iterate.gap).sum())
    return friction


def _other_work(
    model: ContactModel,
    state: Increment,
    problem: Target,
    iterate: Iterate,
    contacts: ContactsAtEnd,
    change: FloatArray,
) -> float:
    """Return the work (J) of gaps that open and close under force, and of the pressure on contacts that stick."""
    before = np.maximum(model.on_its_contacts(state.normal_force), 0.0)  # the tension of a bond is stored, or breaks it
    after = np.maximum(iterate.normal_force, 0.0)
    opened = model.normal_rows @ change
    if problem.mortar is not None:
        more = iterate.normal_force - model.on_its_contacts(state.normal_force)
        opened = opened + problem.mortar.compliance * more + contacts.closing - problem.mortar.closing
    gaps = -0.5 * float((before + after) @ opened)
    limit, _, tolerance = _limit_before(model, state, problem)
    stiffer = iterate.response.limit - limit * (iterate.response.tolerance / tolerance)
    sticking = np.sum(problem.elastic_slip * contacts.elastic_slip, axis=1) / iterate.response.tolerance
    return gaps - 0.5 * float(stiffer @ sticking)


def _work_of_ties(
    model: ContactModel, state: Increment, problem: Target, iterate: Iterate
) -> tuple[float, float, float, float]:
    """Return the energy that ties store at the end, and in the increment: work of what tightens them, of yielding, of
    slack, J."""
    bars, response, history = model.ties, iterate.ties, problem.ties
    if bars is None or response is None or history is None:
        return 0.0, 0.0, 0.0, 0.0
    held = bars.stiffness > 0.0
    before, after, stiffness = state.tie_force[held], response.force[held], bars.stiffness[held]
    elongated = (bars.rows @ (iterate.displacement - problem.displacement))[held]
    rested = (response.rest - history.rest)[held]
    given = ~np.isnan(history.tightened[held])
    mean = 0.5 * (before + after)
    stored = float(np.sum(after**2 / stiffness)) / 2.0
    tightening = float(np.sum((mean * ((after - before) / stiffness - elongated))[given]))
    yielding = float(np.sum((after * rested)[~given]))
    slack = float(np.sum((mean * (elongated - (after - before) / stiffness - rested))[~given]))
    return stored, tightening, yielding, slack


def _limit_before(model: ContactModel, state: Increment, problem: Target) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return (c,): what the traction of the contacts reached before the increment and the cohesion in it, N, and the
    elastic slip at which, m."""
    limit, cohesion = shear_limit(model.on_its_contacts(state.normal_force), model.contacts.friction, problem.bond)
    return limit, cohesion, tolerances(limit, model.slip_tolerance, problem.shear_stiffness)[0]


def _internal_energy(
    model: ContactModel, iterate: Iterate, elastic_slip: FloatArray, mortar: Mortar | None, force: FloatArray
) -> float:
    """Return elastic energy of the bodies, the elastic slip and mortar (force (c,)), and free energy of cracks, J."""
    strained = iterate.displacement - model.rigid
    stiffness = iterate.response.limit / iterate.response.tolerance
    slip = 0.5 * float(stiffness @ np.sum(elastic_slip**2, axis=1))
    if iterate.bond is not None:
        slip += float(iterate.bond.tension @ np.maximum(iterate.gap, 0.0))
    if mortar is not None:
        slip += 0.5 * float(mortar.compliance @ force**2)
    return 0.5 * float(strained @ (model.stiffness @ strained)) + slip

"""A converged iterate -> the Increment that is kept: forces, states, energies.

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

External work less these is what stored energy must have grown by (elastic energy of the bodies, of the elastic slip,
of mortar and of ties). The difference is `energy_error`. An increment that moves is no path of equilibrium: what it
takes from the balance is `lost_in_motion`.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from orchestrator.basis.arrays import FloatArray, IntArray, read_only
from orchestrator.pushover.contact.cohesion import dissipation, shear_limit
from orchestrator.pushover.contact.contact_law import tolerances
from orchestrator.pushover.contact.contact_tracking import ANGLED
from orchestrator.pushover.contact.mortar import Mortar
from orchestrator.pushover.increments import ContactStatus, Increment, Phase
from orchestrator.pushover.model import ContactModel
from orchestrator.pushover.path.curve_checks import ENERGY
from orchestrator.pushover.solve.iterate import Iterate, Target, evaluate, out_of_balance

ROUNDING = 1e-9
"""Gap of faces that touch as they were drawn, over the height of what moves: a larger one is open."""


def at_rest(model: ContactModel) -> Increment:
    """Return the stress-free wall without weight, the start of gravity (number 0)."""
    count, nodes = len(model.possible), len(model.body)
    zero = read_only(np.zeros(count))
    gap = zero if model.tracking is None else np.where(model.tracking.corner == ANGLED, np.nan, zero)
    gap = scattered(gap, model.rows, np.zeros(len(model.rows)))
    return Increment(
        number=0,
        phase="gravity",
        time=0.0,
        load_multiplier=0.0,
        displacement=read_only(np.zeros((nodes, 3))),
        change=read_only(np.zeros((nodes, 3))),
        normal_force=zero,
        elastic_slip=read_only(np.zeros((count, 2))),
        slip=zero,
        damage=zero,
        closing=zero,
        tie_force=read_only(np.zeros(len(model.ties or ()))),
        tie_rest=read_only(np.zeros(len(model.ties or ()))),
        gap=read_only(gap),
        overlap=read_only(scattered(np.zeros(count), model.rows, _drawn_overlap(model))),
        status=read_only(np.full(count, ContactStatus.STICK), np.int64),
        base_shear=0.0,
        horizontal_load=model.horizontal_load,
        control_displacement=0.0,
        mean_displacement=0.0,
        internal_energy=0.0,
        dissipated_energy=0.0,
        external_work=0.0,
        other_work=0.0,
        live_work=0.0,
        lost_in_motion=0.0,
        energy_error=0.0,
        largest_base_shear=0.0,
        out_of_balance=0.0,
        moving=False,
        driven=read_only(np.ones(model.bodies, bool), np.bool_),
        fallen=read_only(np.zeros(model.bodies, bool), np.bool_),
        gone=read_only(np.zeros(model.bodies)),
        equilibrium_residual=0.0,
        iterations=0,
        step=(0.0, 0.0),
    )


def _drawn_overlap(model: ContactModel) -> FloatArray:
    """Return (c,) in m: by how much contacts of the undeformed wall are taken to overlap, all that rounding leaves."""
    return np.where(model.gap_offset < ROUNDING * model.height, model.gap_offset, 0.0)


def of_all_nodes(model: ContactModel, state: Increment) -> Increment:
    """Return the increment with the displacements of all nodes, as it is stored."""
    displacement, change = (read_only(model.front.of_all(one)) for one in (state.displacement, state.change))
    return replace(state, displacement=displacement, change=change)


def in_front(model: ContactModel, state: Increment) -> Increment:
    """Return the increment with the displacements of the nodes in front only, as the path knows it."""
    number = model.front.number
    return replace(state, displacement=state.displacement[number], change=state.change[number])


def increment_of(
    model: ContactModel,
    state: Increment,
    problem: Target,
    iterate: Iterate,
    phase: Phase,
    time: float,
    bound: float,
) -> Increment:
    """Return the converged iterate as the increment after `state`; `step` is the caller's to set.

    bound: largest force on a body over its weight with which the increment is static.
    """
    bond = iterate.bond
    remains = np.zeros(len(iterate.gap)) if bond is None else bond.tension
    bonded = np.zeros(len(iterate.gap), bool) if bond is None else bond.intact & (bond.damage < 1.0)
    force = np.where(iterate.active, np.maximum(iterate.normal_force, 0.0 - remains), 0.0 - remains)
    mortar, closing, given = problem.mortar, np.zeros(len(force)), np.zeros(len(force))
    if mortar is not None:
        force = np.where(iterate.crushes, mortar.strength, force)
        closing = mortar.closing + np.where(iterate.crushes, np.maximum(-iterate.gap, 0.0), 0.0)
        given = mortar.compliance * iterate.normal_force + mortar.closing
    closed = iterate.active & ((force > 0.0) | bonded)
    holding = np.where(iterate.response.sliding, ContactStatus.SLIP, ContactStatus.STICK)
    status = np.where(closed, holding, ContactStatus.OPEN)
    holds = closed | bonded
    elastic_slip = np.where(holds[:, None], iterate.response.elastic_slip, 0.0)
    change = iterate.displacement - problem.displacement
    slip_change = (model.tangential_rows @ change).reshape(-1, 2)
    sliding = slip_change - (elastic_slip - problem.elastic_slip)  # a contact that opens gives off its elastic slip
    plastic = np.where(holds[:, None], sliding, 0.0)
    load = problem.gravity_share * model.gravity + iterate.load_multiplier * model.lateral
    share = state.time if state.phase == "gravity" else 1.0
    earlier = share * model.gravity + state.load_multiplier * model.lateral
    work = 0.5 * float((load + earlier) @ change)
    live = 0.5 * (state.load_multiplier + iterate.load_multiplier) * float(model.lateral @ change)
    limit, cohesion, tolerance = _limit_before(model, state, problem)
    slides = np.where(holds[:, None], iterate.response.elastic_slip, problem.elastic_slip)  # at its limit, all along
    before = (limit - cohesion)[:, None] * slides / np.where(holds, iterate.response.tolerance, tolerance)[:, None]
    friction = 0.5 * float(np.sum((before + iterate.response.traction) * sliding))
    if problem.bond is not None and bond is not None:
        left = (bond.intact * bond.cohesion / iterate.response.tolerance)[:, None] * iterate.response.elastic_slip
        friction += 0.5 * float(np.sum(left * sliding))  # all of it: `dissipation` has only what is beyond it
        friction += float(dissipation(problem.bond, bond, iterate.gap).sum())
    if mortar is not None:
        friction += float(force @ (closing - mortar.closing))
    in_ties, tightening, yielding, slack = _work_of_ties(model, state, problem, iterate)
    work, friction = work + tightening, friction + yielding
    resisting = resistance(model, problem, iterate)
    internal = in_ties + _internal_energy(model, iterate, elastic_slip, mortar, force)
    other = _other_work(model, state, problem, iterate, elastic_slip, change, closing) + float(resisting @ change)
    other += slack
    missing = work - friction - other - (internal - state.internal_energy)
    unbalanced = out_of_balance(model, resisting + _given_friction(model, problem, iterate))
    moving = unbalanced > bound
    base_shear = _base_shear(model, iterate)
    count = len(model.possible)
    return Increment(
        number=state.number + 1,
        phase=phase,
        time=time,
        load_multiplier=iterate.load_multiplier,
        displacement=read_only(iterate.displacement.reshape(-1, 3)),
        change=read_only(change.reshape(-1, 3)),
        normal_force=read_only(scattered(np.zeros(count), model.rows, force)),
        elastic_slip=read_only(scattered(np.zeros((count, 2)), model.rows, elastic_slip)),
        slip=read_only(state.slip + scattered(np.zeros(count), model.rows, np.linalg.norm(plastic, axis=1))),
        damage=read_only(state.damage if bond is None else scattered(state.damage, model.rows, bond.damage)),
        closing=read_only(state.closing if mortar is None else scattered(state.closing, model.rows, closing)),
        tie_force=state.tie_force if iterate.ties is None else read_only(iterate.ties.force),
        tie_rest=state.tie_rest if iterate.ties is None else read_only(iterate.ties.rest),
        gap=read_only(scattered(np.full(count, np.nan), model.rows, iterate.gap - given)),
        overlap=read_only(scattered(np.zeros(count), model.rows, model.overlap)),
        status=read_only(scattered(np.full(count, ContactStatus.OPEN), model.rows, status), np.int64),
        base_shear=base_shear,
        horizontal_load=model.horizontal_load,
        control_displacement=float(model.top_row @ iterate.displacement),
        mean_displacement=float(model.mean_row @ iterate.displacement),
        internal_energy=internal,
        dissipated_energy=state.dissipated_energy + friction,
        external_work=state.external_work + work,
        other_work=state.other_work + other,
        live_work=state.live_work + live,
        lost_in_motion=state.lost_in_motion + moving * missing,
        energy_error=state.energy_error + (not moving) * missing,
        largest_base_shear=state.largest_base_shear if moving else max(state.largest_base_shear, base_shear),
        out_of_balance=unbalanced,
        moving=moving,
        driven=state.driven,
        fallen=state.fallen,
        gone=read_only(np.zeros(len(state.gone))),
        equilibrium_residual=iterate.norms[0],
        iterations=iterate.number,
        step=state.step,
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


def without_jumps(model: ContactModel, state: Increment) -> ContactModel:
    """Return the model with contacts that have come since `state` closed where they overlap already.

    A corner may have sunk in a little before its contact exists, by the deformation of the faces (micrometres): as a
    gap to be closed at once that would be a blow of many times the weight. A contact that takes over the force of
    another one starts closed in any case.
    """
    if model.tracking is None:
        return model
    gap = model.normal_rows @ state.displacement.ravel() + model.gap_offset
    if model.mortar is not None:
        here = model.mortar.at(model.rows, state.closing, state.normal_force)
        gap = gap + here.closed_by(model.on_its_contacts(state.normal_force))
    takes_over = model.on_its_contacts(state.normal_force) > 0.0
    come = np.isnan(state.gap[model.rows])
    overlap = np.where(come, np.where(takes_over, gap, np.minimum(gap, 0.0)), state.overlap[model.rows])
    return replace(model, gap_offset=model.gap_offset - overlap, overlap=overlap)


def scattered(values: npt.NDArray, rows: IntArray, part: npt.NDArray) -> npt.NDArray:
    """Return a copy of `values` with `part` in its `rows`."""
    copy = values.copy()
    copy[rows] = part
    return copy


def resistance(model: ContactModel, problem: Target, iterate: Iterate) -> FloatArray:
    """Return the forces (n,) in N by which mass and viscosity resist the motion of the increment."""
    inertia = model.mass @ (iterate.displacement - problem.inertia_reference) / np.square(problem.time_step)
    if problem.viscosity == 0.0:
        return inertia
    slip = (model.tangential_rows @ (iterate.displacement - problem.displacement)).reshape(-1, 2)
    viscous = problem.viscosities(len(slip))[:, None] * slip
    return inertia + model.tangential_columns @ viscous.ravel()


def _given_friction(model: ContactModel, problem: Target, iterate: Iterate) -> FloatArray:
    """Return the forces (n,) in N by which friction of given normal forces departs from that of an iterate's own."""
    if problem.pressure is None:
        return np.zeros(len(iterate.displacement))
    coulomb = replace(problem, pressure=None)
    of_coulomb = evaluate(model, coulomb, iterate.displacement, iterate.normal_force, iterate.load_multiplier)
    return iterate.force_residual - of_coulomb.force_residual


def _other_work(
    model: ContactModel,
    state: Increment,
    problem: Target,
    iterate: Iterate,
    elastic_slip: FloatArray,
    change: FloatArray,
    closing: FloatArray,
) -> float:
    """Return the work (J) of gaps that open and close under force, and of the pressure on contacts that stick.

    closing (c,): what mortar has crushed by at the end, m.
    """
    before = np.maximum(model.on_its_contacts(state.normal_force), 0.0)  # the tension of a bond is stored, or breaks it
    after = np.maximum(iterate.normal_force, 0.0)
    opened = model.normal_rows @ change
    if problem.mortar is not None:
        more = iterate.normal_force - model.on_its_contacts(state.normal_force)
        opened = opened + problem.mortar.compliance * more + closing - problem.mortar.closing
    gaps = -0.5 * float((before + after) @ opened)
    limit, _, tolerance = _limit_before(model, state, problem)
    stiffer = iterate.response.limit - limit * (iterate.response.tolerance / tolerance)
    sticking = np.sum(problem.elastic_slip * elastic_slip, axis=1) / iterate.response.tolerance
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


def _base_shear(model: ContactModel, iterate: Iterate) -> float:
    """Return the horizontal force of supports and anchors on the wall against the load, N."""
    on_slave = iterate.normal_force * (model.contacts.normal @ model.forward)
    on_slave = on_slave - iterate.response.traction[:, 0] * (model.contacts.tangent @ model.forward)
    shear = -float(on_slave @ model.support_side)
    if model.ties is None or iterate.ties is None:
        return shear
    return shear - model.ties.towards_anchors(iterate.ties.force, model.forward)


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

"""A converged iterate -> the Increment that is kept: forces, states, energies (energies.py)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from orchestrator.basis.arrays import FloatArray, IntArray, read_only
from orchestrator.pushover.increments import ContactStatus, Increment, Phase
from orchestrator.pushover.model import ContactModel
from orchestrator.pushover.path.energies import at_the_end, energies
from orchestrator.pushover.solve.iterate import Iterate, Target, evaluate, out_of_balance

ROUNDING = 1e-9
"""Gap of faces that touch as they were drawn, over the height of what moves: a larger one is open."""


def at_rest(model: ContactModel) -> Increment:
    """Return the stress-free wall without weight, the start of gravity (number 0)."""
    count, nodes = len(model.possible), len(model.body)
    zero = read_only(np.zeros(count))
    gap = scattered(np.full(count, np.nan), model.rows, np.zeros(len(model.rows)))
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
        under_gravity=0.0,
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
    contacts = at_the_end(model, problem, iterate)
    change = iterate.displacement - problem.displacement
    plastic = np.where(contacts.holds[:, None], contacts.sliding, 0.0)
    resisting = resistance(model, problem, iterate)
    done = energies(model, state, problem, iterate, contacts, float(resisting @ change))
    unbalanced = out_of_balance(model, resisting + _given_friction(model, problem, iterate))
    moving, top = unbalanced > bound, float(model.top_row @ iterate.displacement)
    base_shear, bond = _base_shear(model, iterate), iterate.bond
    count, rows = len(model.possible), model.rows
    status = scattered(np.full(count, ContactStatus.OPEN), rows, contacts.status)
    return Increment(
        number=state.number + 1,
        phase=phase,
        time=time,
        load_multiplier=iterate.load_multiplier,
        displacement=read_only(iterate.displacement.reshape(-1, 3)),
        change=read_only(change.reshape(-1, 3)),
        normal_force=read_only(scattered(np.zeros(count), rows, contacts.force)),
        elastic_slip=read_only(scattered(np.zeros((count, 2)), rows, contacts.elastic_slip)),
        slip=read_only(state.slip + scattered(np.zeros(count), rows, np.linalg.norm(plastic, axis=1))),
        damage=read_only(state.damage if bond is None else scattered(state.damage, rows, bond.damage)),
        closing=read_only(
            state.closing if problem.mortar is None else scattered(state.closing, rows, contacts.closing)
        ),
        tie_force=state.tie_force if iterate.ties is None else read_only(iterate.ties.force),
        tie_rest=state.tie_rest if iterate.ties is None else read_only(iterate.ties.rest),
        gap=read_only(scattered(np.full(count, np.nan), rows, iterate.gap - contacts.given)),
        overlap=read_only(scattered(np.zeros(count), rows, model.overlap)),
        status=read_only(status, np.int64),
        base_shear=base_shear,
        horizontal_load=model.horizontal_load,
        control_displacement=top,
        under_gravity=top if phase == "gravity" else state.under_gravity,
        mean_displacement=float(model.mean_row @ iterate.displacement),
        internal_energy=done.internal,
        dissipated_energy=state.dissipated_energy + done.dissipated,
        external_work=state.external_work + done.external,
        other_work=state.other_work + done.other,
        live_work=state.live_work + done.live,
        lost_in_motion=state.lost_in_motion + moving * done.missing,
        energy_error=state.energy_error + (not moving) * done.missing,
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


def without_jumps(model: ContactModel, state: Increment) -> ContactModel:
    """Return the model with contacts that have come since `state` closed where they overlap already.

    A corner may have sunk in a little before its contact exists, by the deformation of the faces (micrometres): as a
    gap to be closed at once that would be a blow of many times the weight. One that bears only once it is deep enough
    closes at that depth, however long the increment is. A contact that takes over the force of another one starts
    closed in any case.
    """
    if model.tracking is None:
        return model
    gap = model.normal_rows @ state.displacement.ravel() + model.gap_offset
    if model.mortar is not None:
        here = model.mortar.at(model.rows, state.closing, state.normal_force)
        gap = gap + here.closed_by(model.on_its_contacts(state.normal_force))
    takes_over = model.on_its_contacts(state.normal_force) > 0.0
    come = np.isnan(state.gap[model.rows])
    overlap = np.where(come, np.where(takes_over, gap, np.minimum(gap, model.overlap)), state.overlap[model.rows])
    return replace(model, gap_offset=model.gap_offset - overlap, overlap=overlap)


def scattered(values: npt.NDArray, rows: IntArray, part: npt.NDArray) -> npt.NDArray:
    """Return a copy of `values` with `part` in its `rows`."""
    copy = values.copy()
    copy[rows] = part
    return copy


def resistance(model: ContactModel, problem: Target, iterate: Iterate) -> FloatArray:
    """Return the forces (n,) in N by which mass and viscosity resist the motion of the increment."""
    inertia = model.mass @ (iterate.displacement - problem.displacement) / np.square(problem.time_step)
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


def _base_shear(model: ContactModel, iterate: Iterate) -> float:
    """Return the horizontal force of supports and anchors on the wall against the load, N."""
    on_slave = iterate.normal_force * (model.contacts.normal @ model.forward)
    on_slave = on_slave - iterate.response.traction[:, 0] * (model.contacts.tangent @ model.forward)
    shear = -float(on_slave @ model.support_side)
    if model.ties is None or iterate.ties is None:
        return shear
    return shear - model.ties.towards_anchors(iterate.ties.force, model.forward)

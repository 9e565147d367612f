"""A converged iterate -> the Increment that is kept: forces, states, energies.

Multiplying the residual R_u = 0 of newton.py by the change of displacement gives the balance of one increment,

    external work = change of stored + change of kinetic energy + friction and fracture + algorithmic dissipation,

external work by the trapezoidal rule. The last term is what implicit Euler takes out: half the work of the changes of
elastic force and load, the impact of gaps that close, inertia beyond the kinetic energy, and viscous contacts. It also
holds what pressure does to a contact that sticks (its stiffness grows with the normal force, at no work), which may
make it negative in an increment.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from orchestrator.masonry.wall import FloatArray, IntArray, read_only
from orchestrator.pushover.cohesion import dissipation, stored
from orchestrator.pushover.iterate import Iterate, Problem
from orchestrator.pushover.model import ContactModel
from orchestrator.pushover.state import ContactStatus, Increment, Phase


def increment_of(
    model: ContactModel, state: Increment, problem: Problem, iterate: Iterate, phase: Phase, time: float
) -> Increment:
    """Return the converged iterate as the increment after `state`; `step` is the caller's to set."""
    bond = iterate.bond
    remains = np.zeros(len(iterate.gap)) if bond is None else bond.tension
    bonded = np.zeros(len(iterate.gap), bool) if bond is None else bond.intact & (bond.damage < 1.0)
    force = np.where(iterate.active, np.maximum(iterate.normal_force, 0.0 - remains), 0.0 - remains)
    closed = iterate.active & ((force > 0.0) | bonded)
    holds = closed | bonded
    elastic_slip = np.where(holds[:, None], iterate.response.elastic_slip, 0.0)
    change = iterate.displacement - problem.displacement
    slip_change = (model.tangential_rows @ change).reshape(-1, 2)
    plastic = np.where(holds[:, None], slip_change - (elastic_slip - problem.elastic_slip), 0.0)
    velocity = change / problem.time_step
    load = problem.gravity_share * model.gravity + iterate.load_multiplier * model.lateral
    earlier = _gravity_share(state) * model.gravity + state.load_multiplier * model.lateral
    work = 0.5 * float((load + earlier) @ change)
    friction = float(np.sum(iterate.response.traction * plastic))
    if problem.bond is not None and bond is not None:
        friction += float(dissipation(problem.bond, bond, iterate.gap).sum())
    kinetic = 0.5 * float(velocity @ (model.mass @ velocity))
    internal = _internal_energy(model, iterate, elastic_slip)
    stored = internal - state.internal_energy + kinetic - state.kinetic_energy
    base_shear = _base_shear(model, iterate)
    count = len(model.possible)
    return Increment(
        number=state.number + 1,
        phase=phase,
        time=time,
        load_multiplier=iterate.load_multiplier,
        displacement=read_only(iterate.displacement.reshape(-1, 3)),
        velocity=read_only(velocity.reshape(-1, 3)),
        normal_force=read_only(scattered(np.zeros(count), model.rows, force)),
        elastic_slip=read_only(scattered(np.zeros((count, 2)), model.rows, elastic_slip)),
        slip=read_only(state.slip + scattered(np.zeros(count), model.rows, np.linalg.norm(plastic, axis=1))),
        damage=read_only(state.damage if bond is None else scattered(state.damage, model.rows, bond.damage)),
        gap=read_only(scattered(np.full(count, np.nan), model.rows, iterate.gap)),
        overlap=read_only(scattered(np.zeros(count), model.rows, model.overlap)),
        status=read_only(
            scattered(np.zeros(count, np.int64), model.rows, _status(closed, iterate.response.sliding)), np.int64
        ),
        base_shear=base_shear,
        control_displacement=float(model.top_row @ iterate.displacement),
        mean_displacement=float(model.mean_row @ iterate.displacement),
        kinetic_energy=kinetic,
        internal_energy=internal,
        dissipated_energy=state.dissipated_energy + friction,
        external_work=state.external_work + work,
        algorithmic_dissipation=state.algorithmic_dissipation
        + _work_of_internal_forces(model, problem, iterate, change, load, earlier)
        - stored
        - friction,
        largest_base_shear=max(state.largest_base_shear, base_shear),
        equilibrium_residual=iterate.norms[0],
        iterations=iterate.number,
        step=state.step,
    )


def without_jumps(model: ContactModel, state: Increment) -> ContactModel:
    """Return the model with contacts that have come since `state` closed where they overlap already.

    A corner may have sunk in a little before its contact exists, by the deformation of the faces (micrometres): as a
    gap to be closed at once that would be a blow of many times the weight. A contact that takes over the force of
    another one starts closed in any case.
    """
    if model.tracking is None:
        return model
    gap = model.normal_rows @ state.displacement.ravel() + model.gap_offset
    takes_over = model.on_its_contacts(state.normal_force) > 0.0
    come = np.isnan(state.gap[model.rows])
    overlap = np.where(come, np.where(takes_over, gap, np.minimum(gap, 0.0)), state.overlap[model.rows])
    return replace(model, gap_offset=model.gap_offset - overlap, overlap=overlap)


def contact_states(state: Increment) -> FloatArray:
    """Return (possible, 3): 1 for the ContactStatus of each contact, 0 for all three where it does not exist."""
    return np.eye(len(ContactStatus))[state.status] * ~np.isnan(state.gap)[:, None]


def states_of(iterate: Iterate) -> FloatArray:
    """Return (c, 3): 1 for the ContactStatus of each contact."""
    return np.eye(len(ContactStatus))[_status(iterate.active, iterate.response.sliding)]


def scattered(values: npt.NDArray, rows: IntArray, part: npt.NDArray) -> npt.NDArray:
    """Return a copy of `values` with `part` in its `rows`."""
    copy = values.copy()
    copy[rows] = part
    return copy


def _work_of_internal_forces(
    model: ContactModel, problem: Problem, iterate: Iterate, change: FloatArray, load: FloatArray, earlier: FloatArray
) -> float:
    """Return the work (J) that everything but the load takes up in the increment, less half the growth of the load."""
    forces = (
        model.stiffness @ (iterate.displacement - model.rigid)
        + model.mass @ (iterate.displacement - problem.inertia_reference) / problem.time_step**2
        - model.normal_columns @ iterate.normal_force
        + model.tangential_columns @ iterate.response.traction.ravel()
    )
    return float(forces @ change) - 0.5 * float((load - earlier) @ change)


def _status(closed: npt.NDArray[np.bool_], sliding: npt.NDArray[np.bool_]) -> IntArray:
    return np.where(closed, np.where(sliding, ContactStatus.SLIP, ContactStatus.STICK), ContactStatus.OPEN)


def _gravity_share(state: Increment) -> float:
    return state.time if state.phase == "gravity" else 1.0


def _base_shear(model: ContactModel, iterate: Iterate) -> float:
    """Return the horizontal force of the supports on the wall against the load, N."""
    x_on_slave = iterate.normal_force * model.contacts.normal[:, 0]
    x_on_slave = x_on_slave - iterate.response.traction[:, 0] * model.contacts.tangent[:, 0]
    return -model.direction * float(x_on_slave @ model.support_side)


def _internal_energy(model: ContactModel, iterate: Iterate, elastic_slip: FloatArray) -> float:
    """Return elastic energy of the bodies and of the elastic slip, and free energy of bonded cracks, J."""
    strained = iterate.displacement - model.rigid
    stiffness = iterate.response.limit / model.slip_tolerance
    slip = 0.5 * float(stiffness @ np.sum(elastic_slip**2, axis=1))
    if iterate.bond is not None:
        slip += stored(iterate.bond, iterate.gap)
    return 0.5 * float(strained @ (model.stiffness @ strained)) + slip

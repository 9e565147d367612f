"""A semicircular arch of 49 stones past its peak, where no increment has a state with Coulomb's friction.

A few contacts are at the limit of friction to the last digit there. Whether they slide or stick, no change of the
forces agrees with it, forth or back, however small. The friction of the normal forces before leads on.
"""

from __future__ import annotations

import numpy as np

from orchestrator.pushover.increments import Increment
from orchestrator.pushover.model import ContactModel, displaced
from orchestrator.pushover.path.increment_record import in_front
from orchestrator.pushover.path.increment_solver import OF_BEFORE
from orchestrator.pushover.path.moved_wall import rigid_motions
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import NewtonSettings, SteppingSettings
from orchestrator.pushover.solve.linear_system import LinearSystem
from tests.support.pushover_chain import MPI, model_of
from tests.support.walls import of_file


def missing(model: ContactModel, state: Increment) -> float:
    """Return the largest resultant on a body, over its weight, of its loads and the forces of Coulomb's contacts."""
    here = displaced(model, state.displacement.ravel(), known=~np.isnan(state.gap))
    motions = rigid_motions(here, state.displacement)
    pressure = state.normal_force[here.rows]
    friction = here.contacts.friction * pressure / model.slip_tolerance
    traction = friction[:, None] * state.elastic_slip[here.rows]
    force = here.gravity + state.load_multiplier * here.lateral
    force = force + here.normal_rows.T @ pressure - here.tangential_rows.T @ traction.ravel()
    resultants = (motions.T @ force).reshape(3, -1)[:2]
    return float(np.max(np.linalg.norm(resultants, axis=0) / model.body_weight))


def test_its_states_are_in_balance_with_coulombs_friction():
    model = model_of(of_file("semicircular_arch_49_stones").wall, large_displacement=True)
    stepping = SteppingSettings(final_displacement=2.2 / 30)
    given, rows = [], 0
    with LinearSystem(model, MPI.COMM_SELF) as system:
        for row in Pushover(model, system, NewtonSettings(), stepping, 0.45).increments():
            rows = row.number
            if not row.moving and any(attempt.action == OF_BEFORE for attempt in row.attempts):
                given.append(in_front(model, row))
            if len(given) == 5:
                break
    assert len(given) == 5, "else this wall tries nothing"
    assert rows < 500, "by chance 110 or 310 lead there"
    for row in given:
        assert missing(model, row) < stepping.out_of_balance

"""A motion ends where the wall rests, whatever a static increment says there."""

from __future__ import annotations

import pytest
from mpi4py import MPI

from orchestrator.basis.errors import ConvergenceError
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.path.increment_record import in_front
from orchestrator.pushover.path.increment_solver import Aim, IncrementSolver
from orchestrator.pushover.path.motion import LONGEST, motion
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import NewtonSettings, SteppingSettings
from orchestrator.pushover.solve.linear_system import LinearSystem
from tests.support.pushover_chain import model_of, rectangle


class WithoutStatic(IncrementSolver):
    """Finds no static increment, as friction may leave none that is followed."""

    def static(self, state, aim, friction_of_before=False):
        raise ConvergenceError("Newton", "no static increment")


@pytest.mark.parametrize("multiplier", [0.1, 0.45])
def test_a_tower_at_rest_does_not_move_for_ever_where_no_static_increment_is_found(multiplier):
    """Two blocks that overturn at 0.5: held under less they rest after a few steps; under more they do not."""
    blocks = [Block(0, rectangle(-1, -0.5, 3, 0.5), True, 20e3)]
    blocks += [Block(1 + k, rectangle(0, k, 1.0, 1.0), False, 20e3) for k in range(2)]
    model = model_of(Wall("tower", tuple(blocks), 0.3, 0.7), mesh_size=0.5, large_displacement=True)
    with LinearSystem(model, MPI.COMM_SELF) as system:
        pushover = Pushover(model, system, NewtonSettings(), SteppingSettings(), 0.5)
        stands = in_front(model, next(one for one in pushover.increments() if one.phase == "load"))
        solver = WithoutStatic(model, system, NewtonSettings(), SteppingSettings(), pushover.solver.measure)
        rests = motion(solver, stands, Aim("load", multiplier, multiplier))
        falls = motion(solver, stands, Aim("load", 0.6, 0.6))
    assert not rests[-1].moving
    assert len(rests) < LONGEST / 2
    assert rests[-1].out_of_balance <= NewtonSettings().residual
    assert rests[-1].attempts[-1].action == "at rest without a static increment", "counted in the journal"
    assert falls[-1].moving

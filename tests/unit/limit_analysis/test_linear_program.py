"""The linear programs on one block whose optimum, forces and mechanism are known by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.basis.arrays import read_only
from orchestrator.basis.errors import ConvergenceError
from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.paper.linear_program import (
    InfeasibleError,
    LimitProgram,
    UnboundedError,
    solve_gravity_lp,
    solve_limit_lp,
)
from orchestrator.limit_analysis.paper.yield_conditions import coulomb
from orchestrator.masonry.interfaces import straight_interfaces
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.wall import Block, Wall
from tests.support.limit_analysis_cases import weight_along


def block_on_floor(width=1.0, height=2.0, friction=0.65, joint=None):
    """A block on a floor at x = 0 ... width; `joint` limits the joint to x = joint[0] ... joint[1]."""
    left, right = joint or (0.0, width)
    floor = Block(0, read_only([[-1, -1], [9, -1], [9, 0], [-1, 0]]), True, 1000.0)
    block = Block(1, read_only([[0, 0], [width, 0], [width, height], [0, height]]), False, 1000.0)
    ends = np.array([[right, 0.0]]), np.array([[left, 0.0]])
    joints = straight_interfaces(np.array([0]), np.array([1]), *ends, 1.0, np.array([friction]))
    return Assemblage(Wall("block", (floor, block), 1.0, friction), joints)


def terms(assemblage, direction=1):
    return assemble_equilibrium(assemblage, weight_along(assemblage, direction)), coulomb(assemblage)


def test_overturning_block():
    """Weight 2 kN, lambda = b/h; all of it on the right toe, about which the block turns clockwise with f_L.u = 1.
    The floor (i) holds it back to the left, which is along the joint's tangent: positive shear."""
    solution = solve_limit_lp(*terms(block_on_floor()))
    assert solution.load_multiplier == pytest.approx(0.5, abs=1e-10)
    assert solution.joint_forces == pytest.approx(np.array([[2000.0, 0.0, 1000.0]]), abs=1e-6)
    omega = -1.0 / 2000.0  # the centroid, 1 m up, moves right at 1/2000 m/s
    assert solution.velocities == pytest.approx([-omega * 1.0, omega * -0.5, omega], abs=1e-13)
    assert solution.rates == pytest.approx(np.array([[0.0, -omega * 1.0, 0.0]]), abs=1e-13)
    assert solution.normal == pytest.approx([2000.0])


def test_sliding_block_dilates_by_mu():
    solution = solve_limit_lp(*terms(block_on_floor(width=2.0, height=1.0)))
    assert solution.load_multiplier == pytest.approx(0.65, abs=1e-10)
    slip = -1.0 / 2000.0  # to the right, against the joint's tangent
    assert solution.rates == pytest.approx(np.array([[-0.65 * slip, -0.65 * slip, slip]]), abs=1e-12)
    assert solution.joint_forces[0, 2] == pytest.approx(0.65 * 2000.0)


def test_shift_takes_the_dilation_out():
    equilibrium, law = terms(block_on_floor(width=2.0, height=1.0))
    solution = LimitProgram(equilibrium, law).solve(law.cohesion, shift=np.array([0.65 / 2000.0]))
    assert solution.load_multiplier == pytest.approx(0.65, abs=1e-10)
    assert solution.rates == pytest.approx(np.array([[0.0, 0.0, -1.0 / 2000.0]]), abs=1e-12)


def test_one_program_serves_many_right_sides():
    """The same set-up must forget the cohesion and the shift of the solve before."""
    equilibrium, law = terms(block_on_floor(width=2.0, height=1.0, friction=0.3))
    program = LimitProgram(equilibrium, law)
    first = program.solve(np.array([0.0])).load_multiplier
    glued = program.solve(np.array([200.0]), shift=np.array([1e-4])).load_multiplier
    again = program.solve(np.array([0.0])).load_multiplier
    assert (first, glued, again) == pytest.approx((0.3, 0.4, 0.3), abs=1e-10)


def test_no_equilibrium_raises():
    """The joint ends left of the centroid: nothing holds the block."""
    with pytest.raises(InfeasibleError):
        solve_limit_lp(*terms(block_on_floor(width=2.0, height=1.0, friction=0.1, joint=(0.0, 0.4))))


def test_infinite_multiplier_raises():
    """Load to the left against a wall: a second joint on the block's left side, along the wall's face."""
    free = block_on_floor(width=2.0, height=1.0)
    wall = Block(2, read_only([[-0.5, 0], [0, 0], [0, 2], [-0.5, 2]]), True, 1000.0)
    ends = np.array([[2.0, 0.0], [0.0, 0.0]]), np.array([[0.0, 0.0], [0.0, 1.0]])
    joints = straight_interfaces(np.array([0, 2]), np.array([1, 1]), *ends, 1.0, np.full(2, 0.65))
    held = Assemblage(replace(free.wall, blocks=(*free.wall.blocks, wall)), joints)
    assert joints.normal[1].tolist() == [1.0, 0.0]
    with pytest.raises(UnboundedError):
        solve_limit_lp(*terms(held, -1))
    assert solve_limit_lp(*terms(held, 1)).load_multiplier == pytest.approx(0.5 * 2.0 / 1.0 * 0.65, abs=1e-8)


def test_both_errors_are_convergence_errors_that_say_why():
    assert issubclass(InfeasibleError, ConvergenceError)
    assert issubclass(UnboundedError, ConvergenceError)
    with pytest.raises(ConvergenceError, match="no joint forces satisfy equilibrium and friction"):
        solve_limit_lp(*terms(block_on_floor(width=2.0, height=1.0, friction=0.1, joint=(0.0, 0.4))))


def test_gravity_needs_nothing_for_a_block_that_stands():
    missing, _ = solve_gravity_lp(*terms(block_on_floor()))
    assert missing == pytest.approx(0.0, abs=1e-8)


def test_gravity_misses_the_moment_of_a_block_beyond_its_edge():
    """Weight W, centroid 1 m right of the joint's end at x = 0: with forces and moments/length added at equal price,
    a moment W (1 m)/length, or a lift; length = sqrt(area) = sqrt 2 m, so the moment is cheaper: 1/sqrt 2."""
    hanging = block_on_floor(width=2.0, height=1.0, joint=(-1.0, 0.0))
    missing, velocities = solve_gravity_lp(*terms(hanging))
    assert missing == pytest.approx(1.0 / np.sqrt(2.0), abs=1e-8)
    assert velocities[2] == pytest.approx(-1.0 / np.sqrt(2.0), abs=1e-8)  # clockwise, rotation x length = 1
    assert velocities[1] == pytest.approx(-1.0 / np.sqrt(2.0), abs=1e-8)  # its centroid goes down

"""Which bodies move, by closed form: speeds, participation, hold, out-of-balance force."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from orchestrator.pushover.path.moving import (
    body_motion,
    body_size,
    moving_part,
    participation,
    without_hold,
)
from orchestrator.pushover.solve.iterate import out_of_balance
from tests.support.pushover_chain import model_of, stack

NOBODY = np.zeros(3, bool)


def bodies(*masses, live=None):
    """Bodies of some masses under a live load proportional to them, or another one."""
    mass = np.array(masses, float)
    live = 9.81 * mass if live is None else np.array(live, float)
    return SimpleNamespace(body_mass=mass, body_weight=9.81 * mass, body_live=live)


@pytest.fixture(scope="module")
def model():
    """A stone of 0.4 m x 0.3 m and one of 0.2 m x 0.5 m on it; thickness 0.1 m, 25 kN/m3."""
    return model_of(stack((0.4, 0.3), (0.2, 0.5), friction=0.6))


@pytest.mark.parametrize(
    ("motion", "share"),
    [
        ([0.0, 0.0, 2e-3], 0.1),  # what moves alone has its share of the dead load
        ([7.0, 7.0, 7.0], 1.0),
        ([0.0, 1.0, 1.0], 0.4),
        ([1.0, 2.0, 0.0], (6 + 6) ** 2 / (10 * (6 + 12))),
        ([0.0, 0.0, 0.0], 1.0),  # nothing moves: no part is singled out
    ],
)
def test_participation_is_the_share_of_what_moves(motion, share):
    found = participation(bodies(6, 3, 1), np.array(motion))
    assert (found.dead, found.live) == pytest.approx((share, share)), "the live load is that of the masses"


def test_a_part_that_moves_alone_has_its_own_share_of_either_load():
    """A body of a tenth of the weight with half of the live load, beside bodies that creep a millionth as far."""
    found = participation(bodies(6, 3, 1, live=[4, 1, 5]), np.array([1e-6, 1e-6, 1.0]))
    assert (found.dead, found.live) == pytest.approx((0.1, 0.5), rel=1e-4)
    without = participation(bodies(6, 3, 1, live=[4, 6, 0]), np.array([1e-6, 1e-6, 1.0]))
    assert without.dead == pytest.approx(0.1, rel=1e-4)
    assert without.live < 1e-5, "what creeps carries all live load and is not what moves"


@pytest.mark.parametrize("factor", [1e-9, 1.0, 1e6])
def test_participation_knows_no_unit(factor):
    motion = np.array([0.1, 0.7, 0.3])
    found = participation(bodies(6, 3, 1), factor * motion)
    assert found.dead == pytest.approx(participation(bodies(6, 3, 1), motion).dead)


def test_the_moving_part_is_what_keeps_up_with_a_tenth_of_the_mean_speed():
    """Mean speed by momentum: (3 x 1 + 1 x 0.11^2 + 6 x 0.09^2) / (3 + 0.11 + 0.54) = 0.839."""
    motion = np.array([0.09, 1.0, 0.11])
    mean = (6 * 0.09**2 + 3 + 0.11**2) / (6 * 0.09 + 3 + 0.11)
    assert mean == pytest.approx(0.839, abs=1e-3)
    assert moving_part(bodies(6, 3, 1), motion).tolist() == [True, True, True]
    assert moving_part(bodies(6, 3, 1), np.array([0.05, 1.0, 0.11])).tolist() == [False, True, True]


def test_a_small_stone_that_races_ahead_is_the_part_that_moves():
    assert moving_part(bodies(1e4, 1e4, 1), np.array([1e-7, 0.0, 1e-2])).tolist() == [False, False, True]


def held(pairs, force, fallen=NOBODY):
    """Return what has no hold of three bodies; bodies 3 and 4 are supports."""
    slave, master = np.array(pairs).T
    model = SimpleNamespace(bodies=3, pairs=(slave, master), ties=None)
    return without_hold(model, np.array(force, float), fallen, np.zeros(0)).tolist()


def test_a_body_is_held_by_a_chain_of_contacts_that_carry():
    chain = [(0, 3), (1, 0), (2, 1)]
    assert held(chain, [5, 3, 1]) == [False, False, False]
    assert held(chain, [5, 0, 1]) == [False, True, True]
    assert held(chain, [0, 3, 1]) == [True, True, True]


def test_all_supports_hold_and_a_bond_in_tension_does_too():
    assert held([(0, 3), (4, 1), (2, 1)], [1, 1, -1]) == [False, False, False]
    assert held([(0, 3), (4, 1), (2, 1)], [1, 0, -1]) == [False, True, True]


def test_what_has_fallen_before_does_not_fall_again():
    assert held([(0, 3), (1, 0), (2, 1)], [5, 3, 0], np.array([False, False, True])) == [False, False, False]


def test_motion_and_size_of_a_body(model):
    """A turn about the centre by a: root mean square a x (mean square distance of the nodes from it)."""
    nodes, body = model.front.nodes, model.front.body_of_node
    change = np.zeros((len(model.body), 3))
    change[: len(nodes)][body == 0] = [3e-3, 4e-3, 1.0]  # out of the plane does not count
    arm = nodes[body == 1][:, :2] - nodes[body == 1][:, :2].mean(axis=0)
    change[: len(nodes)][body == 1, :2] = 1e-3 * np.column_stack([-arm[:, 1], arm[:, 0]])
    expected = [5e-3, 1e-3 * np.sqrt(np.mean(np.sum(arm**2, axis=1)))]
    assert body_motion(model, change.ravel()) == pytest.approx(expected)
    assert body_size(model) == pytest.approx([np.sqrt(0.4 * 0.3), np.sqrt(0.2 * 0.5)])


def test_masses_and_weights_are_those_of_the_stones(model):
    assert model.body_weight == pytest.approx([25e3 * 0.1 * 0.12, 25e3 * 0.1 * 0.1])
    assert model.body_mass == pytest.approx(model.body_weight / 9.81)
    assert model.body_live == pytest.approx(model.body_weight)


@pytest.mark.parametrize("body", [0, 1])
def test_an_acceleration_of_one_body_is_out_of_balance_by_its_share_of_g(model, body):
    """M a with a = 0.02 g on one body alone: 0.02 of its weight, whatever the other one weighs."""
    acceleration = np.zeros((len(model.body), 3))
    acceleration[model.body == body, 0] = 0.02 * 9.81
    assert out_of_balance(model, model.mass @ acceleration.ravel()) == pytest.approx(0.02)


def test_a_couple_is_out_of_balance_though_its_sum_is_zero(model):
    """Forces of 1 % of the weight, to the left on one node and to the right on another: 2 %."""
    force = np.zeros((len(model.body), 3))
    first, second = np.flatnonzero(model.body == 1)[[0, 3]]
    force[first, 0], force[second, 0] = 0.01 * model.body_weight[1], -0.01 * model.body_weight[1]
    assert out_of_balance(model, force.ravel()) == pytest.approx(0.02)

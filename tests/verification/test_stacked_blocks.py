"""Blocks on a support under a horizontal mass-proportional load: closed forms of statics.

One block b x h slides at multiplier mu or overturns about its toe at b/h, whichever is smaller; a stack of blocks
slides in the joint, or overturns above the joint, that gives the smallest value.
"""

import numpy as np
import pytest

from orchestrator.pushover.increments import ContactStatus
from tests.support.pushover_chain import model_of, moved_to, run, stack


@pytest.mark.parametrize("friction", [0.3, 0.5])
@pytest.mark.parametrize("direction", [1, -1])
def test_block_slides_at_its_coefficient_of_friction(friction, direction):
    result = run(model_of(stack((0.4, 0.6), friction=friction), direction=direction), final_displacement=2e-3)
    assert result.peak == pytest.approx(friction, abs=1e-4)
    status = result.increments[-1].status  # the heel may lift: resultant outside the middle third
    assert (status == ContactStatus.SLIP).sum() >= 2
    assert not (status == ContactStatus.STICK).any()
    assert np.sign(result.increments[-1].displacement[:, 0].mean()) == direction


def test_block_overturns_at_width_over_height():
    result = run(model_of(stack((0.4, 0.6), friction=0.9)), final_displacement=2e-3)
    assert result.peak == pytest.approx(0.4 / 0.6, rel=1e-3)
    closed = result.increments[-1].status != ContactStatus.OPEN
    assert result.model.contacts.point[closed, 0] == pytest.approx(0.2), "the block stands on its toe"


@pytest.mark.parametrize(
    ("sizes", "friction", "expected"),
    [
        (((0.4, 0.3), (0.4, 0.3)), 0.3, 0.3),  # slides, in either joint
        (((0.4, 0.3), (0.2, 0.3)), 0.9, 0.2 / 0.3),  # the upper block overturns
        (((0.4, 0.5), (0.4, 0.5)), 0.7, 0.4 / 1.0),  # both overturn together
    ],
)
def test_two_stacked_blocks(sizes, friction, expected):
    result = run(model_of(stack(*sizes, friction=friction)), final_displacement=2e-3)
    assert result.peak == pytest.approx(expected, rel=1e-3)


def test_reaction_after_gravity_is_the_weight():
    model = model_of(stack((0.4, 0.3), (0.2, 0.3), friction=0.6))
    result = run(model, final_displacement=1e-6)
    weight = 25e3 * 0.1 * (0.4 * 0.3 + 0.2 * 0.3)
    reaction = result.under_gravity.normal_force[model.support_side == 1].sum()
    assert model.weight == pytest.approx(weight, rel=1e-12)
    assert reaction == pytest.approx(weight, rel=1e-8)


def test_elastic_slip_is_half_the_tolerance_at_half_the_limit():
    """A stiff block pulled with half its friction has gone half the slip tolerance, and no more."""
    tolerance = 2e-4
    model = model_of(stack((0.4, 0.3), friction=0.6), slip_tolerance=tolerance)
    result = run(model, final_displacement=1e-3)
    half = min(result.increments, key=lambda i: abs(i.load_multiplier - 0.3))
    assert half.load_multiplier == pytest.approx(0.3, abs=1e-9)
    slip = half.elastic_slip[:, 0] @ half.normal_force / half.normal_force.sum()
    assert abs(slip) == pytest.approx(tolerance / 2, rel=1e-3)


def test_sliding_dissipates_friction_force_times_slip():
    model = model_of(stack((0.4, 0.3), friction=0.4))
    result = run(model, final_displacement=2e-3)
    first = next(i for i in result.increments if (i.status == ContactStatus.SLIP).all())
    last = result.increments[-1]
    slid = last.mean_displacement - first.mean_displacement
    assert slid > 1e-3
    assert last.dissipated_energy - first.dissipated_energy == pytest.approx(0.4 * model.weight * slid, rel=1e-3)


def test_cycles_of_reversed_load_dissipate_friction_force_times_slip():
    """Two cycles of +-0.1 mm: the block slides at +-mu, and each reversal first takes back the elastic slip."""
    friction, amplitude = 0.4, 1e-4
    model = model_of(stack((0.4, 0.3), friction=friction))
    quarter = np.linspace(0.0, amplitude, 11)[1:]
    cycle = [*quarter, *quarter[-2::-1], 0.0, *-quarter, *-quarter[-2::-1], 0.0]
    path = moved_to(model, [0.0, *cycle, *cycle])
    first, last = path[1], path[-1]
    assert max(i.load_multiplier for i in path) == pytest.approx(friction, rel=1e-3)
    assert min(i.load_multiplier for i in path) == pytest.approx(-friction, rel=1e-3)
    travelled = 8 * amplitude
    reversals = 4
    slipped = travelled - (1 + 2 * reversals) * model.slip_tolerance
    dissipated = last.dissipated_energy - first.dissipated_energy
    assert dissipated == pytest.approx(friction * model.weight * slipped, rel=0.01)

"""A rigid block that rocks about its toe: the multiplier is tan(alpha0 - theta) until it stands on its corner.

G. W. Housner, Bull. Seism. Soc. Am. 53 (1963) 403-417: geometry of the rocking block, alpha0 = atan(width / height).
"""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.assessment.seismic.n2 import equivalent_system
from orchestrator.assessment.seismic.observed import nodal_mass
from tests.support.pushover_chain import Run, model_of, run, stack


def rocked(width: float, height: float, direction: int = 1) -> Run:
    """Push a block on a rough base until its base shear has fallen to zero."""
    model = model_of(stack((width, height), friction=5.0), large_displacement=True, direction=direction)
    return run(model, 2 * height, final_drop=1.0, displacement_increment=1e-3 / height)


def rotation(displacement: np.ndarray, width: float, height: float) -> np.ndarray:
    """Return theta of a rigid block whose top moves by width/2 (1 - cos theta) + height sin theta on average."""
    theta = np.linspace(0.0, np.pi / 4, 100_001)
    return np.interp(displacement, width / 2 * (1 - np.cos(theta)) + height * np.sin(theta), theta)


@pytest.mark.parametrize(("width", "height"), [(0.4, 0.6), (0.3, 0.9)])
@pytest.mark.parametrize("direction", [1, -1])
def test_multiplier_of_a_rocking_block_falls_to_zero(width, height, direction):
    result = rocked(width, height, direction)
    slenderness = np.arctan2(width, height)
    theta = rotation(result.curve.control_displacement_m, width, height)
    multiplier = result.curve.base_shear_N / result.model.weight
    assert multiplier[-2] > 0 > multiplier[-1]
    assert theta[-2] < slenderness < theta[-1]
    rocking = theta > 0.002
    error = np.abs(multiplier - np.tan(slenderness - theta))[rocking] / np.tan(slenderness)
    assert np.count_nonzero(rocking) > 15
    assert error.max() < 0.005


@pytest.mark.parametrize("direction", [1, -1])
def test_equivalent_system_of_a_rocking_block(direction):
    """It turns as a whole about its toe: phi = y / h, so m* = M/2, Gamma = (1/2) / (1/3), F*/V = 1/2 under its mass."""
    model = model_of(stack((0.2, 0.8), friction=5.0), direction=direction)
    result = run(model, 0.01, displacement_increment=0.1)
    nodes, front = len(model.meshes.nodes), model.front
    moved = (result.increments[-1].displacement - result.under_gravity.displacement)[:, 0]
    mass, top = nodal_mass(model.meshes), np.zeros(nodes)
    top[front.number] = model.top_row[::3]
    speed, in_front = (np.sin(5 * x[:, 0]) + 2 * x[:, 1] ** 2 for x in (model.meshes.nodes, front.nodes))
    assert in_front @ model.mass[::3, ::3] @ in_front == pytest.approx(speed @ mass @ speed), "that of the elements"
    along = direction * moved
    system = equivalent_system(mass, along / float(top @ moved), mass @ np.ones(nodes), np.ones(nodes))
    assert system.whole_mass == pytest.approx(model.weight / 9.81)
    assert system.mass == pytest.approx(0.5 * system.whole_mass, rel=0.01)
    assert system.gamma == pytest.approx(1.5, rel=0.01)
    assert system.force_share == pytest.approx(0.5, rel=0.01)


def test_small_displacements_keep_the_multiplier():
    """The detector: without the turn of the block the multiplier stays at width / height."""
    model = model_of(stack((0.4, 0.6), friction=5.0))
    result = run(model, 0.1, displacement_increment=0.02)
    assert result.curve.base_shear_N[-1] / result.model.weight == pytest.approx(0.4 / 0.6, rel=2e-3)

"""A rigid block that rocks about its toe: the multiplier is tan(alpha0 - theta) until it stands on its corner.

So it is of a portal, whose lintel rides on corners opposite to the toes of its columns.

G. W. Housner, Bull. Seism. Soc. Am. 53 (1963) 403-417: geometry of the rocking block, alpha0 = atan(width / height).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator import JointSettings, MeshSettings, SteppingSettings, analyse, find_joints, one_body_per_block, push
from orchestrator.assessment.seismic.n2 import equivalent_system
from orchestrator.assessment.seismic.observed import nodal_mass
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.settings import ElasticSettings
from tests.support.pushover_chain import Run, model_of, rectangle, run, stack


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
    time = result.curve.time_s
    assert time[0] == 0.0, "the state under gravity is where the curve begins"
    assert (np.diff(time) > 0.0).all()
    assert error.max() < 0.005


@pytest.mark.parametrize("slenderness", [0.04, 0.01, 0.005])
@pytest.mark.parametrize("stones", [1, 3])
def test_a_slender_stack_bears_its_slenderness_and_its_curve_counts(slenderness, stones):
    """While drag was a share of the weight 0.2 % of a peak of 0.02 was missing at the supports, and 0.3 % of 0.01."""
    width = 0.03
    part = width / slenderness / stones
    ground = Block(0, rectangle(-0.1, -0.02, 0.3, 0.02), True, 20e3)
    drums = [Block(1 + k, rectangle(0.0, k * part, width, part), False, 20e3) for k in range(stones)]
    assemblage = find_joints(Wall("stack", (ground, *drums), 0.3, 0.7), JointSettings())
    analysis = analyse(assemblage)
    stepping, stiff = SteppingSettings(final_displacement=width), ElasticSettings(350e9)
    done = push(assemblage, analysis, one_body_per_block(assemblage), stepping=stepping, elastic=stiff)
    assert not done.complaints
    assert done.capacity.peak_multiplier == pytest.approx(slenderness, rel=5e-3)
    assert done.capacity.peak_reached


def portal() -> Wall:
    """Two columns of 0.5 m x 2 m, 1 m apart, under a lintel of 0.3 m."""
    outlines = [rectangle(0.0, 0.0, 0.5, 2.0), rectangle(1.5, 0.0, 0.5, 2.0), rectangle(0.0, 2.0, 2.0, 0.3)]
    ground = Block(0, rectangle(-0.5, -0.2, 3.0, 0.2), True, 20e3)
    return Wall("portal", (ground, *(Block(1 + k, one, False, 20e3) for k, one in enumerate(outlines))), 0.5, 0.7)


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_every_static_row_of_a_portal_is_in_balance(direction):
    """One was 0.8 % above it: 3.9 mm on, under the load at which it begins to turn, which was taken for its peak."""
    assemblage, load = find_joints(portal(), JointSettings()), LoadSettings(direction)
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    stepping, stiff = SteppingSettings(final_displacement=0.45), ElasticSettings(35e9)
    corners = MeshSettings(toe_offset=0.5)  # elements of one size: it turns about the very ends of its joints
    done = push(
        assemblage, analysis, one_body_per_block(assemblage), load, mesh=corners, stepping=stepping, elastic=stiff
    )
    assert not done.complaints
    curve = done.curve.static
    turned = np.interp(curve.control_displacement_m, _of_corner(theta := np.linspace(0.0, 0.3, 100_001)), theta)
    multiplier = curve.base_shear_N / done.curve.horizontal_load_N
    loaded = np.flatnonzero(multiplier >= 0.99 * done.capacity.peak_multiplier)[0]
    assert len(multiplier) >= loaded + 8
    assert multiplier[loaded:] == pytest.approx(np.tan(np.arctan2(0.5, 2.0) - turned[loaded:]), abs=1e-3 * 0.25)
    assert done.capacity.displacement_at_peak < 0.3e-3


def _of_corner(turned: np.ndarray) -> np.ndarray:
    """Return by how far (m) the corner over the heel of a column moves that turns about its toe (rad)."""
    return 0.5 * (1.0 - np.cos(turned)) + 2.0 * np.sin(turned)


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


def test_a_support_that_no_stone_touches_changes_nothing():
    """A neighbour beyond a gap, the last of the blocks: two stones rock at width / height as without it."""
    wall = stack((0.5, 0.6), (0.5, 0.6), friction=0.9)
    beyond = replace(
        wall.blocks[0], id=99, polygon=np.array([[0.56, 0.2], [0.8, 0.2], [0.8, 1.5], [0.56, 1.5]]), fixed=True
    )
    peaks = []
    for blocks in (wall.blocks, (*wall.blocks, beyond)):
        assemblage = find_joints(replace(wall, blocks=blocks), JointSettings())
        stepping = SteppingSettings(final_displacement=0.01)
        done = push(assemblage, analyse(assemblage), one_body_per_block(assemblage), stepping=stepping)
        assert done.summary.valid
        peaks.append(done.capacity.peak_multiplier)
    assert peaks[1] == pytest.approx(peaks[0], rel=1e-9)
    assert peaks[0] == pytest.approx(0.5 / 1.2, rel=5e-3)

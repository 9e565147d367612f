"""Section forces and reactions balance the loads: over a storey, over the supports, in moments, and by hand."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.assessment.panels import in_storeys, piers
from orchestrator.assessment.section_forces import reactions, section_forces
from orchestrator.limit_analysis.gravity import refuse_what_cannot_be_analysed
from orchestrator.loads import DeadLoad, LoadSettings, loads_on
from orchestrator.masonry.block_properties import block_centroids
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.sources.block_files import read_blocks
from tests.support.limit_analysis_cases import assemblage_of, box
from tests.support.paths import PROJECT

MESHES = PROJECT / "meshes"
FLOOR = LoadSettings(direction="-x", dead=(DeadLoad(level=1.925, line_load=8e3, inertia=True),))


def solved(name, settings):
    assemblage = find_joints(read_blocks(MESHES / name), JointSettings())
    loads = loads_on(assemblage.wall, settings)
    state = refuse_what_cannot_be_analysed(assemblage, loads)
    return assemblage, loads.dead + state.load_multiplier * loads.live, state


@pytest.fixture(scope="module", params=["ferris_tinloi_wall6.json", "arched_facade.json"])
def facade(request):
    """A facade with its loads at collapse (n, 3), pushed to the left; benchmark 1 with a floor that has mass."""
    name = request.param
    return solved(name, FLOOR if name.startswith("ferris") else LoadSettings(direction="-x"))


def test_the_piers_of_a_storey_carry_all_that_is_above(facade):
    assemblage, loads, state = facade
    found = section_forces(assemblage, state.joint_forces)
    heights, scale = block_centroids(assemblage.wall)[:, 1], np.abs(loads).sum()
    free = np.array([not block.fixed for block in assemblage.wall.blocks])
    storeys = in_storeys(piers(assemblage.wall))
    assert storeys
    for row in storeys:
        for section in ("foot", "middle", "head"):
            names = [panel.name for panel in row]
            own = [force for force in found if force.panel in names and force.section == section]
            assert len(own) == len(row)
            above = free * 0.5 * (np.sign((heights - own[0].y).round(6)) + 1.0)  # half of a stone on the line
            x, y = above @ loads[:, :2]
            assert sum(force.normal for force in own) == pytest.approx(-y, abs=1e-6 * scale)
            assert sum(force.shear for force in own) == pytest.approx(x, abs=1e-6 * scale)
            arm = block_centroids(assemblage.wall) - [0.0, own[0].y]
            turning = above * (loads[:, 2] + arm[:, 0] * loads[:, 1] - arm[:, 1] * loads[:, 0])
            moment = sum(force.moment - force.x * force.normal for force in own)
            assert moment == pytest.approx(turning.sum(), abs=1e-5 * scale), "about (0, y of the section)"


def test_the_supports_carry_weight_and_base_shear(facade):
    assemblage, loads, state = facade
    free = [not block.fixed for block in assemblage.wall.blocks]
    x, y, _ = loads[free].sum(axis=0)
    found = reactions(assemblage, state.joint_forces)
    assert x < 0.0
    assert sum(one.vertical for one in found) == pytest.approx(-y, rel=1e-6)
    assert sum(one.horizontal for one in found) == pytest.approx(-x, rel=1e-6)


def test_a_block_about_to_overturn_stands_on_its_toe():
    """0.5 m x 1 m x 1 m at 20 kN/m3: W = 10 kN, lambda = 0.5; all of it at the right corner, b/2 = 0.25 m off."""
    assemblage = assemblage_of([box(-3, -1, 6, 1), box(0, 0, 0.5, 1.0)], friction=0.7)
    state = refuse_what_cannot_be_analysed(assemblage, loads_on(assemblage.wall))
    (reaction,) = reactions(assemblage, state.joint_forces)
    assert (reaction.x, reaction.y) == pytest.approx((0.25, 0.0))
    assert (reaction.horizontal, reaction.vertical) == pytest.approx((-5e3, 10e3), rel=1e-6)
    assert reaction.moment == pytest.approx(10e3 * 0.25, rel=1e-6)


def test_a_lintel_at_rest_on_two_piers_by_hand():
    """Pier 10 kN, lintel 12 kN. No joint cuts the lintel: sections of the spandrel step round it to its bearing on the
    right pier, which pushes it up by 6 kN, 0.75 m beside the middle, or to that on the left one: by the mean of both
    there is no shear, as by symmetry, and the moment of both."""
    polygons = [box(-1, -1, 5, 1), box(0, 0, 0.5, 1), box(1.5, 0, 0.5, 1), box(0, 1, 2, 0.3)]
    assemblage = assemblage_of(polygons, friction=0.7)
    on_ground = (assemblage.joints.i == 0) | (assemblage.joints.j == 0)
    forces = np.zeros((len(on_ground), 3))
    forces[:, :2] = np.where(on_ground, 8e3, 3e3)[:, None]
    found = {(one.panel, one.section): one for one in section_forces(assemblage, forces)}
    for pier in ("pier 1.1", "pier 1.2"):
        foot, head = found[pier, "foot"], found[pier, "head"]
        assert (foot.normal, head.normal) == pytest.approx((16e3, 6e3))
        assert (foot.shear, foot.moment, head.moment) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
        assert foot.depth == pytest.approx(0.5)
    spandrel = found["spandrel above 1.1", "middle"]
    assert (spandrel.normal, spandrel.shear, spandrel.moment) == pytest.approx((0.0, 0.0, 6e3 * 0.75), abs=1e-9)

"""The tilting table: gravity turned by theta is weight cos theta (1, tan theta), so a wall falls at tan theta = lambda.

Checked on the same wall drawn tilted: what it still resists is tan(theta - tilt), and beyond theta it cannot stand.
"""

from __future__ import annotations

from dataclasses import replace
from math import atan, cos, radians, sin, tan

import numpy as np
import pytest

from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis import analyse
from orchestrator.loads import DeadLoad, LiveLoad, LoadSettings, loads_on
from orchestrator.masonry.joints import JointClass, JointSettings, find_joints
from tests.support.limit_analysis_cases import answers, assemblage_of, box, case, transformed


def tilted(name, angle):
    """The wall of a block file with its +x side tilted down."""
    turn = np.array([[cos(angle), sin(angle)], [-sin(angle), cos(angle)]])
    return transformed(case(name), lambda polygon: polygon @ turn.T)


@pytest.mark.parametrize("name", ["tower_5_blocks", "ferris_tinloi_wall3", "ferris_tinloi_wall4"])
def test_a_wall_drawn_tilted_has_the_rest_of_its_angle(name):
    found = answers(name)
    angle = found.tilt_angle(found.associative)
    assert angle == pytest.approx(atan(found.associative.load_multiplier), abs=1e-15)
    for tilt in (radians(-5), radians(5)):
        rest = analyse(tilted(name, tilt)).associative.load_multiplier
        assert rest == pytest.approx(tan(angle - tilt), abs=1e-7)


def test_a_wall_drawn_beyond_its_angle_cannot_stand():
    angle = atan(answers("ferris_tinloi_wall3").associative.load_multiplier)
    just = analyse(tilted("ferris_tinloi_wall3", angle - 1e-4))
    assert just.associative.load_multiplier == pytest.approx(1e-4, rel=1e-3)
    assert just.headline.load_multiplier > 0.0
    assert just.sequence is None
    assert any("would have to be held, at λ = -0.04" in remark for remark in just.remarks)
    with pytest.raises(CaseError, match="cannot stand"):
        analyse(tilted("ferris_tinloi_wall3", angle + 1e-4))


@pytest.mark.parametrize(
    ("settings", "tilts"),
    [
        (LoadSettings(), True),
        (LoadSettings(direction="-x"), True),
        (LoadSettings(dead=(DeadLoad((1,), line_load=1e3, inertia=True),)), True),
        (LoadSettings(dead=(DeadLoad((1,), line_load=1e3),)), False),
        (LoadSettings(inclination=0.1), False),
        (LoadSettings(distribution="mass_height"), False),
    ],
)
def test_only_a_load_that_tilts_with_the_wall_is_an_angle(settings, tilts):
    wall = case("tower_5_blocks")
    found = analyse(wall, loads=loads_on(wall.wall, settings))
    assert (found.tilt_angle(found.associative) is not None) == tilts


def test_a_load_that_acts_elsewhere_does_not_tilt():
    """Half a tonne on top of a block of 0.6 m x 1.2 m. A table tilts it about its toe where b/2 (W + P) = tan (W h/2 +
    P h); the same forces through the centroid need more, and no table has them."""
    wall = assemblage_of([box(-1, -1, 3, 1), box(0, 0, 0.6, 1.2)], friction=2.0)
    weight, on_top = float(loads_on(wall.wall).dead[1, 1]), DeadLoad((1,), force=5e3, at=(0.3, 1.2))
    through_it = LiveLoad(blocks=(1,), force=5e3 - weight)
    of_table = analyse(wall, loads=loads_on(wall.wall, LoadSettings(dead=(replace(on_top, inertia=True),))))
    other = LoadSettings(dead=(on_top,), distribution="per_block", live=(through_it,))
    centred = analyse(wall, loads=loads_on(wall.wall, other))
    tangent = 0.3 * (5e3 - weight) / (5e3 * 1.2 - weight * 0.6)
    assert of_table.tilt_angle(of_table.headline) == pytest.approx(atan(tangent), rel=1e-6)
    assert centred.headline.load_multiplier > 1.2 * tangent
    assert centred.tilt_angle(centred.headline) is None


def test_strengths_do_not_tilt():
    """Cohesion stays what it is while the weight across the joints goes with the cosine."""
    wall = find_joints(case("tower_5_blocks").wall, JointSettings(classes=(JointClass(cohesion=1e3),)))
    found = analyse(wall)
    assert found.tilt_angle(found.associative) is None
    assert replace(found, tilting_table=True).tilt_angle(found.associative) is not None

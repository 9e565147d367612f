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
from orchestrator.loads import DeadLoad, LoadSettings, loads_on
from orchestrator.masonry.joints import JointClass, JointSettings, find_joints
from tests.support.limit_analysis_cases import answers, case, transformed


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


def test_strengths_do_not_tilt():
    """Cohesion stays what it is while the weight across the joints goes with the cosine."""
    wall = find_joints(case("tower_5_blocks").wall, JointSettings(classes=(JointClass(cohesion=1e3),)))
    found = analyse(wall)
    assert found.tilt_angle(found.associative) is None
    assert replace(found, tilting_table=True).tilt_angle(found.associative) is not None

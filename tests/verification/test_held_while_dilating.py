"""Walls in space that would bear any load if sliding dilated, and do not: joints press no more than they did, and the
multiplier is that of the wall without its neighbours' help."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from orchestrator.app import cli
from orchestrator.geometry.polyhedra import box, prism
from orchestrator.space.analysis import SpaceLimitSettings, analyse
from orchestrator.space.contacts import find_joints
from orchestrator.space.loads import SpaceLoadSettings, loads_on
from orchestrator.space.resistance import UnresistedError
from tests.support.space_walls import block_file_of, wall_of

THICK, HIGH, WIDE = 0.4, 3.0, 2.0


def analysed(shapes, friction, direction, supports, states="range"):
    assemblage = find_joints(wall_of(shapes, friction, supports))
    loads = loads_on(assemblage.wall, SpaceLoadSettings(direction=direction))
    return analyse(assemblage, loads, replace(SpaceLimitSettings(), states=states))


def between(scale, sides=1):
    """Ground and two piers that stand still, three blocks on each other between them; sides: -1 in its mirror image."""
    boxes = [(-1.0, -1.0, -0.3, 4.0, 1.4, 0.0), (-0.5, 0.0, 0.0, 0.0, THICK, HIGH), (WIDE, 0.0, 0.0, 2.5, THICK, HIGH)]
    boxes += [(0.0, 0.0, HIGH * k / 3, WIDE, THICK, HIGH * (k + 1) / 3) for k in range(3)]
    ends = [(np.array(one[:3]) * [1, sides, 1], np.array(one[3:]) * [1, sides, 1]) for one in boxes]
    return [box(tuple(scale * np.minimum(*two)), tuple(scale * np.maximum(*two))) for two in ends]


@pytest.mark.parametrize(("scale", "sides"), [(1.0, 1), (0.1, 1), (1.0, -1)])
@pytest.mark.parametrize("states", ["range", "headline", "none"])
def test_a_panel_between_two_piers_turns_over_as_if_they_were_not_there(scale, sides, states):
    """Its head joints carry nothing under its own weight: t / H."""
    found = analysed(between(scale, sides), 0.6, "-y" if sides > 0 else "+y", 3, states)
    assert found.associative is None
    assert found.headline.load_multiplier == pytest.approx(THICK / HIGH, rel=1e-6)
    assert found.range == pytest.approx((THICK / HIGH,) * 2, rel=1e-4)


def test_a_block_under_a_ceiling_that_it_touches_slides_at_its_friction():
    ground, ceiling = box((-2.0, -2.0, -0.3), (2.0, 2.0, 0.0)), box((-2.0, -2.0, 0.5), (2.0, 2.0, 0.8))
    found = analysed([ground, ceiling, box((0.0, 0.0, 0.0), (1.0, 1.0, 0.5))], 0.3, "+x", 2)
    assert found.lowest.load_multiplier == pytest.approx(0.3, rel=1e-5)


def wedge():
    """A stone 0.4 m wide at y = 0 and 0.3 m at y = -0.4 on the ground, between two fixed ones that fit its sides."""
    stone = [(-0.2, 0.0), (-0.15, -0.4), (0.15, -0.4), (0.2, 0.0)]
    left = [(-1.0, 0.0), (-1.0, -0.4), (-0.15, -0.4), (-0.2, 0.0)]
    right = [(0.2, 0.0), (0.15, -0.4), (1.0, -0.4), (1.0, 0.0)]
    axes = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.3]])
    upright = [prism(np.array(outline), np.zeros(3), axes) for outline in (left, right, stone)]
    return [box((-2.0, -2.0, -0.3), (2.0, 2.0, 0.0)), *upright]


@pytest.mark.parametrize("friction", [0.1, 0.2, 0.3, 0.5])
def test_a_stone_leaves_its_wider_side_at_its_friction_whatever_that_is(friction):
    """With more than tan of the sides' angle, 0.125, it would bear any load if sliding dilated."""
    found = analysed(wedge(), friction, "+y", 3)
    assert (found.associative is None) == (friction > 0.125)
    assert found.headline.load_multiplier == pytest.approx(friction, rel=1e-6)


def test_a_stone_that_is_pushed_into_its_narrower_side_is_held():
    with pytest.raises(UnresistedError, match="however large"):
        analysed(wedge(), 0.3, "-y", 3)


def test_what_is_printed_and_written_of_a_wall_without_a_bound(tmp_path, capsys):
    """A block that touches a ceiling, in four directions; it has no bound in any of them, and slides at 0.3."""
    shapes = [box((-2.0, -2.0, -0.3), (2.0, 2.0, 0.0)), box((0.0, 0.0, 0.0), (1.0, 1.0, 0.5))]
    record = block_file_of([*shapes, box((-2.0, -2.0, 0.5), (2.0, 2.0, 0.8))], 0.3)
    record["blocks"][2]["fixed"] = True
    (tmp_path / "wall.json").write_text(json.dumps(record))
    case, output = tmp_path / "case.toml", tmp_path / "out"
    case.write_text('[wall]\nblocks = "wall.json"\n[load]\ndirection = "+x"\ndirections = 4\n')
    assert cli.main(["check", str(case), "--output", str(output)]) == 0
    assert cli.main(["limit", str(case), "--output", str(output)]) == 0
    said = capsys.readouterr().out
    assert said.count("the wall would bear any load in this direction: there is no upper bound") == 2
    assert "direction 90 degrees: associative held, without dilation 0.3000" in said
    analysed = json.loads((output / "limit_analysis.json").read_text())
    assert analysed["associative"] is None
    assert analysed["lowest"] == pytest.approx(0.3, rel=1e-5)
    directions = json.loads((output / "directions.json").read_text())
    assert directions["associative"] == [None] * 4
    assert directions["non_associative"] == pytest.approx([0.3] * 4, rel=1e-5)
    assert "there is no upper bound" in (output / "collapse.html").read_text()

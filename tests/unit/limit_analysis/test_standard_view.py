"""The same wall, numbered anew or seen from behind, has the same view to the last digit; answers are carried back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.basis.arrays import read_only
from orchestrator.limit_analysis import analyse
from orchestrator.limit_analysis.standard_view import standard_view
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from tests.support.limit_analysis_cases import analysed, assemblage_of, audit, box, case, mirrored, weight_along


def irregular():
    return find_joints(irregular_courses(IrregularCourses(1.2, 1.0, friction=0.6, seed=3)), JointSettings())


def renumbered(assemblage):
    """The wall with its blocks in another order and every outline begun at another corner."""
    blocks = np.random.default_rng(5).permutation(np.array(assemblage.wall.blocks, dtype=object))
    turned = tuple(replace(block, polygon=read_only(np.roll(block.polygon, 2, axis=0))) for block in blocks)
    return find_joints(replace(assemblage.wall, blocks=turned), JointSettings())


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("wall", [irregular, lambda: case("block_on_10deg_slope"), lambda: case("ferris_tinloi_wall4")])
def test_one_view_of_all_images_to_the_last_digit(wall, direction):
    """Renumbered: unless drawn with gaps (the slope, by 1e-7 m), where joints lie along the outline of block i."""
    images = [(wall(), direction), (mirrored(wall()), -direction)]
    if len(wall().wall.blocks) > 2:
        images.append((renumbered(wall()), direction))
    first, *others = (standard_view(image, weight_along(image, side)) for image, side in images)
    assert len(first.joint) > 0
    for other in others:
        assert np.array_equal(first.assemblage.joints.i, other.assemblage.joints.i)
        assert np.array_equal(first.assemblage.joints.j, other.assemblage.joints.j)
        for name in ("start", "end", "friction"):
            assert np.array_equal(getattr(first.assemblage.joints, name), getattr(other.assemblage.joints, name))
        for one, same in zip(first.assemblage.wall.blocks, other.assemblage.wall.blocks, strict=True):
            assert np.array_equal(one.polygon, same.polygon)
            assert one.fixed == same.fixed


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("image", [irregular, lambda: mirrored(irregular()), lambda: renumbered(irregular())])
def test_answers_are_those_of_the_original_wall(image, direction):
    """Statics, Coulomb's law, kinematics and power in the original's numbers, places and directions."""
    wall = image()
    found = analysed(wall, direction)
    assert found.loads.direction.tolist() == [direction, 0.0]
    assert found.horizontal_load == pytest.approx(found.weight)
    for state in (found.sequence, found.path):
        checked = audit(wall, state, direction)
        assert checked.unbalanced < 1e-10
        assert checked.excess_shear < 1e-9
        assert checked.wrong_rates < 1e-12
        assert checked.power == pytest.approx(checked.friction_power, abs=1e-6)
        assert checked.penetration < 1e-8


def test_images_have_the_same_answers_to_rounding():
    wall = irregular()
    there, behind, anew = analyse(wall), analysed(mirrored(wall), -1), analyse(renumbered(wall))
    for name in ("sequence", "path", "lowest"):
        expected = getattr(there, name).load_multiplier
        assert getattr(behind, name).load_multiplier == pytest.approx(expected, rel=1e-12)
        assert getattr(anew, name).load_multiplier == pytest.approx(expected, rel=1e-12)


def test_far_from_the_origin_on_a_wall_of_round_numbers():
    """3 m - x instead of -x, and 1 km away: rounding differs, the view does not."""
    stones = [(0.1, 0.0, 0.7, 0.2), (0.8, 0.0, 0.6, 0.2), (0.3, 0.2, 0.9, 0.2)]
    floor = (-1.0, -0.3, 4.0, 0.3)
    here = assemblage_of([box(*stone) for stone in (floor, *stones)])
    behind = assemblage_of([box(1003.0 - x - width, y, width, height) for x, y, width, height in (floor, *stones)])
    one, other = standard_view(here).assemblage, standard_view(behind, weight_along(behind, -1)).assemblage
    assert np.array_equal(one.joints.start, other.joints.start)
    assert np.array_equal(one.joints.end, other.joints.end)

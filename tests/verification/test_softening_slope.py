"""How the multiplier of a mechanism falls as it moves: closed forms, and the curve of rigid blocks followed."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator import one_body_per_block, push
from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.limit_analysis.softening_slope import softening_slope
from orchestrator.limit_analysis.turning_joints import pressed_at_hinges
from orchestrator.loads import DeadLoad, LoadSettings, loads_on
from orchestrator.masonry.joints import JointClass, JointSettings, find_joints
from orchestrator.masonry.patterns import Arch, arch_on_piers
from tests.support.limit_analysis_cases import assemblage_of, box

NOT_PUSHED = LimitAnalysisSettings(search_blocks=1, sequence_blocks=1, large_displacements=False)
PUSHED = LimitAnalysisSettings(search_blocks=1, sequence_blocks=1)
WIDTH, HEIGHT = 0.5, 2.0


def slope_of(assemblage, load=None, settings=NOT_PUSHED):
    """Multiplier and slope (1/m) of the state that loading meets."""
    loads = loads_on(assemblage.wall, load or LoadSettings())
    found = analyse(assemblage, settings, loads)
    return found.headline.load_multiplier, softening_slope(assemblage, loads, found.headline)


def block(size=1.0, friction=0.9):
    """A stone on the ground."""
    ground = box(-1.0 * size, -0.2 * size, 3.0 * size, 0.2 * size)
    return assemblage_of([ground, box(0.0, 0.0, WIDTH * size, HEIGHT * size)], friction=friction)


@pytest.mark.parametrize("direction", ["+x", "-x"])
@pytest.mark.parametrize("size", [1.0, 0.1])
def test_a_block_on_its_toe(direction, size):
    """It bears tan(alpha - theta), and its centroid, h / 2 high, goes along the load."""
    multiplier, slope = slope_of(block(size), LoadSettings(direction))
    assert multiplier == pytest.approx(WIDTH / HEIGHT, rel=1e-6)
    assert slope == pytest.approx(-(1.0 + multiplier**2) / (0.5 * HEIGHT * size), rel=1e-5)


def test_a_block_that_slides_bears_what_it_bore():
    multiplier, slope = slope_of(block(friction=0.2))
    assert multiplier == pytest.approx(0.2, rel=1e-6)
    assert slope == pytest.approx(0.0, abs=1e-6)


def test_a_floor_on_a_block_turns_with_it():
    """lambda W (h c + b s) = W (b c - h s) + 2 P (b / 2 c - h s) at a turn with cosine c and sine s, P on the top."""
    assemblage = block()
    floor = 60e3
    load = LoadSettings(dead=(DeadLoad((1,), force=floor, at=(0.5 * WIDTH, HEIGHT)),))
    own = float(-loads_on(assemblage.wall, LoadSettings()).dead[1, 1])
    multiplier, slope = slope_of(assemblage, load)

    def bears(turn):
        c, s = np.cos(turn), np.sin(turn)
        holds = own * (WIDTH * c - HEIGHT * s) + 2.0 * floor * (0.5 * WIDTH * c - HEIGHT * s)
        return holds / (own * (HEIGHT * c + WIDTH * s))

    assert multiplier == pytest.approx(bears(0.0), rel=1e-6)
    assert slope == pytest.approx((bears(1e-5) - bears(-1e-5)) / 2e-5 / (0.5 * HEIGHT), rel=1e-4)


def test_a_lintel_goes_along_on_two_uprights():
    """Its corners lie on theirs: tan(alpha - theta) again, but the live load's points go further."""
    stones = [box(0.0, 0.0, 0.4, 1.6), box(1.8, 0.0, 0.4, 1.6), box(0.0, 1.6, 2.2, 0.4)]
    assemblage = assemblage_of([box(-0.5, -0.2, 3.2, 0.2), *stones], friction=0.6)
    multiplier, slope = slope_of(assemblage)
    uprights, lintel = 2 * 0.4 * 1.6, 2.2 * 0.4
    moves = (0.8 * uprights + 1.6 * lintel) / (uprights + lintel)
    assert multiplier == pytest.approx(0.25, rel=1e-6)
    assert slope == pytest.approx(-(1.0 + multiplier**2) / moves, rel=1e-4)


def test_an_arch_as_rigid_blocks_that_are_followed():
    """Where four hinges stay where they are, the slope is that of the curve past its peak."""
    assemblage = find_joints(arch_on_piers(Arch(12, 1.1, 0.2, friction=0.7, thickness=0.3)), JointSettings())
    loads = loads_on(assemblage.wall, LoadSettings())
    found = analyse(assemblage, PUSHED, loads, elastic_modulus=3.5e12)
    moved, bears = found.rigid_curve[found.rigid_curve[:, 1] < 0.995 * found.rigid_peak].T
    past = moved > 0.5 * moved.max()
    followed = np.polyfit(moved[past], bears[past], 1)[0]
    assert softening_slope(assemblage, loads, found.headline) == pytest.approx(followed, rel=0.15)


def test_a_wall_that_is_not_pushed_bears_in_finite_elements_what_one_that_is_does():
    """With elements of one size it bears 1 % more."""
    stones = [box(0.0, 0.0, 0.4, 1.6), box(1.8, 0.0, 0.4, 1.6), box(0.0, 1.6, 2.2, 0.4)]
    assemblage = assemblage_of([box(-0.5, -0.2, 3.2, 0.2), *stones], friction=0.6, thickness=0.4)
    pushed, not_pushed = (analyse(assemblage, settings) for settings in (PUSHED, NOT_PUSHED))
    assert not_pushed.rigid_curve is None
    lengths, expected = (pressed_at_hinges(assemblage, found) for found in (not_pushed, pushed))
    assert np.count_nonzero(lengths) >= 2
    assert lengths[lengths > 0.0] == pytest.approx(expected[lengths > 0.0], rel=0.3)
    assert not_pushed.pressed_peak == pytest.approx(pushed.pressed_peak, rel=2e-3)
    stones = one_body_per_block(assemblage)
    one, other = (push(assemblage, found, stones).capacity.peak_multiplier for found in (not_pushed, pushed))
    assert one == pytest.approx(other, rel=3e-3)


def column(**law):
    stones = [box(0.0, 0.0, 0.5, 1.0), box(0.0, 1.0, 0.5, 1.0)]
    wall = assemblage_of([box(-0.5, -0.2, 1.5, 0.2), *stones], friction=0.6).wall
    return find_joints(wall, JointSettings(classes=(JointClass(**law),)))


def test_cohesion_without_tension_leaves_edges_as_they_are():
    """A facade of 52 stones bore 2 % more in finite elements with a cohesion of 1 Pa: its elements were all alike."""
    bare, held = column(friction=0.6), column(cohesion=1.0)
    loose, bonded = analyse(bare, NOT_PUSHED), analyse(held, NOT_PUSHED)
    lengths = pressed_at_hinges(bare, loose)
    assert lengths.any()
    assert pressed_at_hinges(held, bonded) == pytest.approx(lengths, rel=1e-4)
    assert bonded.pressed_peak == pytest.approx(loose.pressed_peak, rel=1e-4)


@pytest.mark.parametrize("law", [{"cohesion": 1e4, "tensile_strength": 1e4}, {"compressive_strength": 5e6}])
def test_joints_that_break_or_crush_have_no_such_slope(law):
    """A bond is gone before the wall moves so far, and a toe that crushes is as long as its strength says."""
    assemblage = column(**law)
    found = analyse(assemblage, NOT_PUSHED)
    assert not pressed_at_hinges(assemblage, found).any()
    assert found.pressed_peak is None

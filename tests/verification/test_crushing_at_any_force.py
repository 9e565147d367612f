"""Joints that crush under more than the dead load: ties, loads downwards and thrusts, against statics by another road.

A joint of length L and thickness t bears |M| <= N/2 (L - N/(f_c t)) about its middle. Closed forms, and where there is
none a linear program in N, V and M (tests/support/statics.py): the multiplier lies between those with all of this
moment and with a thousandth less, which is what the documentation says that the linearisation takes.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, radians, sin

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from orchestrator.basis.arrays import read_only
from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis import analyse
from orchestrator.limit_analysis.settlement import settle
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.macroblocks.merged_blocks import merged_multiplier
from orchestrator.masonry.joints import JointClass, JointSettings, find_joints
from orchestrator.masonry.ties import Tie, with_ties
from tests.support.limit_analysis_cases import assemblage_of, box
from tests.support.statics import LOST, by_statics

THICKNESS = 0.3
FLOOR = box(-1.0, -0.2, 4.0, 0.2)
LOSS = 1e-3
"""Part of a joint's moment that the linearisation may take."""
EXACT = 2e-5
"""What the joint that stands for a tie bears in bending, an eighth of 1e-5 block lengths times its strength."""
DOWNWARDS = Tie(blocks=(1,), start=(0.25, 0.5), end=(0.25, -1.0), strength=10e3)


def wall_of(polygons, friction, *ties, fixed=(0,), **strengths):
    """Stones of 20 kN/m3 and the joints between them, 0.3 m thick."""
    drawn = assemblage_of(polygons, fixed, friction=friction, thickness=THICKNESS, unit_weight=20e3).wall
    return with_ties(find_joints(drawn, JointSettings(classes=(JointClass(**strengths),))), ties)


def block(width, f_c, *ties, friction=5.0):
    """One block 1 m high on a floor."""
    return wall_of([FLOOR, box(0.0, 0.0, width, 1.0)], friction, *ties, compressive_strength=f_c)


def flat_arch(f_c, stones=9, span=3.0, depth=0.25, friction=0.9):
    """Stones between two that are fixed."""
    width = span / stones
    arch = [box(n * width, 0.0, width, depth) for n in range(stones)]
    ends = [box(-0.5, 0.0, 0.5, depth), box(span, 0.0, 0.5, depth)]
    return wall_of(ends + arch, friction, fixed=(0, 1), compressive_strength=f_c)


def along(degrees):
    """Direction of a live load so many degrees above the horizontal."""
    return cos(radians(degrees)), sin(radians(degrees))


def multipliers(wall, degrees=0.0):
    """Associative and sequence multiplier, and the headline, of states that balance."""
    found = analyse(wall, loads=loads_on(wall.wall, LoadSettings(inclination=radians(degrees))))
    states = (found.associative, found.sequence, found.headline)
    for state in states:
        assert state.equilibrium_residual < 1e-10
        assert state.yield_residual < 1e-9
        assert state.power_residual < 1e-7
    return np.array([state.load_multiplier for state in states])


def of_a_tied_block(width, f_c, strength):
    """lambda W h/2 = N/2 (b - N/(f_c t)) of a block 1 m high, tied down through its centroid with a strength.

    N = W + S; a tie that would crush the joint only pulls with as much as serves best, N = f_c t b/2.
    """
    W = 20e3 * width * THICKNESS
    N = min(W + strength, 0.5 * f_c * THICKNESS * width)
    return N / W * (width - N / (f_c * THICKNESS))


def assert_just_below(found, exact):
    assert np.all(found < exact * (1 + EXACT))
    assert np.all(found > exact * (1 - LOSS))


@pytest.mark.parametrize("f_c", [0.25e6, 0.5e6, 1e6, 10e6, 1e9])
def test_a_tie_that_pulls_with_ten_times_the_weight(f_c):
    """N = 66 kN, and 0.44 m of the joint to carry them: 6.16 at 0.5 MPa."""
    tie = Tie(blocks=(1,), start=(0.5, 0.5), end=(0.5, -1.0), strength=60e3)
    assert of_a_tied_block(1.0, 0.5e6, 60e3) == pytest.approx(6.16)
    assert_just_below(multipliers(block(1.0, f_c, tie)), of_a_tied_block(1.0, f_c, 60e3))


def test_a_live_load_that_goes_down_too():
    """lambda W cos a h/2 = N/2 (b - N/(f_c t)), N = W (1 + lambda sin a)."""
    f_c, W, (across, up) = 0.1e6, 6e3, along(-45.0)

    def left(multiplier):
        N = W * (1.0 - multiplier * up)
        return N / 2 * (1.0 - N / (f_c * THICKNESS)) - multiplier * W * across / 2

    assert_just_below(multipliers(block(1.0, f_c), -45.0), brentq(left, 0.0, 3.0))


def test_a_stronger_joint_never_bears_less():
    """Strengths from crushing under the tie alone to 100 MPa."""
    found = []
    for f_c in np.geomspace(0.1e6, 100e6, 13):
        found.append(multipliers(block(0.5, f_c, DOWNWARDS, friction=5.0)))
        assert_just_below(found[-1], of_a_tied_block(0.5, f_c, 10e3))
    assert np.all(np.diff(found, axis=0) > 0.0)


@pytest.mark.parametrize("f_c", [0.36e6, 1e6, 10e6])
def test_a_flat_arch_whose_thrust_is_more_than_its_weight(f_c):
    """N_c/2 bears most, N_c d/8 at the abutments and again at the joints beside the keystone, b wide.

        (1 + lambda) w (l^2 - b^2)/8 = f_c t d^2/4        w = weight over length: 1 + lambda = 2.8125 at 1 MPa

    and it stands by 1 + lambda, so that a thousandth of the moment is a thousandth of this.
    """
    arch, w = flat_arch(f_c), 20e3 * 0.25 * THICKNESS
    exact = 2.0 * f_c * THICKNESS * 0.25**2 / (w * (3.0**2 - (3.0 / 9) ** 2))
    assert 1.0 + by_statics(arch, (), along(-90.0)) == pytest.approx(exact, rel=1e-4)
    assert_just_below(1.0 + multipliers(arch, -90.0), exact)


def test_a_flat_arch_that_crushes_under_its_weight():
    """At 0.3556 MPa lambda above is 0."""
    with pytest.raises(CaseError, match="cannot stand"):
        analyse(flat_arch(0.355e6))
    assert by_statics(flat_arch(0.355e6), (), along(-90.0)) is None


def random_wall(seed):
    """Return a wall with ties, its ties, and the inclination of its load.

    A stack or two courses of bond on a floor, or a flat arch; joints with any of cohesion, tension and crushing.
    """
    random = np.random.default_rng(seed)
    kind, width, height = random.integers(3), *random.uniform(0.3, 0.8, 2)
    stones = [FLOOR]
    fixed = (0,)
    if kind == 0:
        left = np.cumsum(random.uniform(-0.1, 0.1, 3) * width)
        stones += [box(x, n * height, width, height) for n, x in enumerate(left)]
    elif kind == 1:
        stones += [box(n * width, 0.0, width, height) for n in range(2)]
        stones += [box((n + 0.5) * width, height, width, height) for n in range(2)]
    else:
        fixed = (0, 1)
        stones = [box(-0.5, 0.0, 0.5, height), box(5 * width, 0.0, 0.5, height)]
        stones += [box(n * width, 0.0, width, height) for n in range(5)]
    weight = 20e3 * width * height * THICKNESS
    strengths = {"compressive_strength": weight / (width * THICKNESS) * 10.0 ** random.uniform(0.5, 2.0)}
    if random.random() < 0.5:
        strengths |= {"cohesion": 0.5 * weight / width, "tensile_strength": 0.2 * weight / width}
    ties = []
    for _ in range(random.integers(3)):
        number = int(random.integers(len(fixed), len(stones)))
        start = np.mean(stones[number], axis=0) + random.uniform(-0.4, 0.4, 2) * (width, height)
        end = start + random.uniform(-2.0, 2.0, 2) - (0.0, 3.0)
        strength = weight * 10.0 ** random.uniform(-1.0, 1.5)
        ties.append(Tie(blocks=(number,), start=tuple(start), end=tuple(end), strength=strength))
    friction = float(random.uniform(0.4, 1.5))
    return wall_of(stones, friction, *ties, fixed=fixed, **strengths), ties, float(random.uniform(-90.0, 30.0))


@pytest.mark.parametrize("seed", range(30))
def test_any_wall_is_that_of_statics(seed):
    """The associative multiplier, and whether it stands at all."""
    wall, ties, degrees = random_wall(seed)
    exact = by_statics(wall, ties, along(degrees), 1.0 / (1.0 - LOST))
    least = by_statics(wall, ties, along(degrees), 1.0 - LOSS)
    loads = loads_on(wall.wall, LoadSettings(inclination=radians(degrees)))
    if exact is None:
        with pytest.raises(CaseError, match="cannot stand"):
            analyse(wall, loads=loads)
        return
    assert least is not None, "no wall here is within a thousandth of falling"
    found = analyse(wall, loads=loads).associative.load_multiplier
    assert least - EXACT * (1.0 + least) < found < exact + EXACT * (1.0 + exact)


def test_blocks_that_are_held_together():
    """Two stones of 0.5 m as one block 1 m high under a tie, by the same closed form; apart they bear no more."""
    tie = Tie(blocks=(2,), start=(0.25, 0.75), end=(0.25, -1.0), strength=10e3)
    stones = [FLOOR, box(0.0, 0.0, 0.5, 0.5), box(0.0, 0.5, 0.5, 0.5)]
    wall = wall_of(stones, 5.0, tie, compressive_strength=0.5e6)
    together = merged_multiplier(wall, read_only([0, 1, 1], np.int64), "associative")
    assert_just_below(together, of_a_tied_block(0.5, 0.5e6, 10e3))
    assert analyse(wall).associative.load_multiplier <= together * (1 + EXACT)


def test_a_support_that_settles_under_a_tied_beam():
    """Moments of W, R, S and N_L, those of bearings as far right as their joints can bear them.

    The tie over the middle of the left bearing presses that one alone, N_L = W - R + S, with what serves best.
    """
    f_c, W = 0.6e6, 20e3 * 3.0 * 0.5 * THICKNESS
    stones = [box(0.0, -0.2, 0.5, 0.2), box(2.5, -0.2, 0.5, 0.2), box(0.0, 0.0, 3.0, 0.5)]
    tie = Tie(blocks=(2,), start=(0.25, 0.2), end=(0.25, -1.0), strength=60e3)
    beam = wall_of(stones, 5.0, tie, fixed=(0, 1), compressive_strength=f_c)

    def left_over(R, S):
        N = W - R + S
        of_left, of_right = 0.5 - N / (2 * f_c * THICKNESS), 3.0 - R / (2 * f_c * THICKNESS)
        return N * of_left + R * of_right - W * 1.5 - S * 0.25

    found = -settle(beam, 1, radians(-90.0)).load_multiplier
    least = minimize_scalar(lambda S: brentq(left_over, 0.0, W, (S,)), (0.0, 60e3), (0.0, 60e3), method="bounded").fun
    assert least * (1 - EXACT) < found < least * (1 + LOSS)


def test_strengths_that_differ_by_decades():
    """A strong joint on a weak one: the weak one's closed form, whatever the strong one bears."""
    tie = Tie(blocks=(2,), start=(0.25, 0.75), end=(0.25, -1.0), strength=10e3)
    wall = wall_of([FLOOR, box(0.0, 0.0, 0.5, 0.5), box(0.0, 0.5, 0.5, 0.5)], 5.0, tie, compressive_strength=0.5e6)
    strong = np.where(wall.joints.i == 0, 1.0, 1e6) * np.array(wall.joints.compressive_strength)
    strong[2] = wall.joints.compressive_strength[2]
    found = multipliers(replace(wall, joints=replace(wall.joints, compressive_strength=read_only(strong))))
    assert_just_below(found, of_a_tied_block(0.5, 0.5e6, 10e3))

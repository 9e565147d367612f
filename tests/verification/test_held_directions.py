"""A pier of width b and height h that is pushed down aslant turns about its edge under
lambda = b / (h sin a - b cos a), a from the vertical: none where tan a = b / h, in which it is held by any load."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace

import pytest

from orchestrator.basis.errors import CaseError
from orchestrator.geometry.polyhedra import box
from orchestrator.limit_analysis.gravity import refuse_what_cannot_be_analysed
from orchestrator.loads import LoadSettings
from orchestrator.loads import loads_on as loads_in_plane
from orchestrator.loads.block_loads import LiveLoad
from orchestrator.masonry.joints import JointSettings
from orchestrator.masonry.joints import find_joints as joints_in_plane
from orchestrator.masonry.wall import Block, Wall
from orchestrator.space.analysis import SpaceLimitSettings, analyse
from orchestrator.space.contacts import find_joints
from orchestrator.space.loads import SpaceLoadSettings, loads_on
from orchestrator.space.resistance import UnresistedError
from tests.support.space_walls import GROUND, wall_of
from tests.support.walls import rectangle

WIDTH, HEIGHT = 0.4, 2.0
HELD_AT = HEIGHT / WIDTH
"""how far down a load goes for 1 along, in which the pier is held"""
BEYOND = (0.0, 1e-9, 1e-8, 1e-7, 1e-6)
"""parts of it by which a load lies beside that direction, and is told to be held"""


def multiplier(down: float) -> float:
    """lambda of a load that goes `down` for 1 along."""
    size = math.hypot(1.0, down)
    return WIDTH / (HEIGHT / size - WIDTH * down / size)


def in_space(down: float, scale: float, states: str = "none"):
    halves = [(0.0, 0.5), (0.5, 1.0)]
    shapes = [
        box((0.0, 0.0, scale * HEIGHT * low), (scale, scale * WIDTH, scale * HEIGHT * high)) for low, high in halves
    ]
    assemblage = find_joints(wall_of([GROUND, *shapes], 0.6))
    loads = loads_on(assemblage.wall, SpaceLoadSettings(direction=(0.0, 1.0, -down)))
    return analyse(assemblage, loads, replace(SpaceLimitSettings(), states=states))


def in_plane(down: float, scale: float):
    outlines = [
        rectangle(-1.0, -1.0, 3.0, 1.0), *(rectangle(0.0, HEIGHT * k / 2, WIDTH, HEIGHT / 2) for k in (0, 1))
    ]  # fmt: skip
    blocks = tuple(Block(k, scale * outline, k == 0, 20e3) for k, outline in enumerate(outlines))
    assemblage = joints_in_plane(Wall("pier", blocks, scale, 0.6), JointSettings())
    loads = loads_in_plane(assemblage.wall, LoadSettings("+x", inclination=-math.atan(down)))
    return refuse_what_cannot_be_analysed(assemblage, loads)


@pytest.mark.parametrize("beyond", BEYOND)
@pytest.mark.parametrize("scale", [0.01, 1.0])
def test_a_direction_in_which_a_pier_is_held_but_for_rounding_is_refused(beyond, scale):
    down = HELD_AT * (1.0 - beyond)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(UnresistedError, match="no load in this direction, however large, moves the wall"):
            in_space(down, scale, "range")
        with pytest.raises(CaseError, match="no live load in this direction brings it down"):
            in_plane(down, scale)


@pytest.mark.parametrize("down", [0.0, 4.0, 4.99, 4.999, 4.9999])
def test_a_pier_that_is_all_but_held_has_its_multiplier(down):
    """Up to 50,989, 2e-5 beside the direction in which it is held."""
    assert in_space(down, 1.0).associative.load_multiplier == pytest.approx(multiplier(down), rel=1e-5)
    assert in_plane(down, 1.0).load_multiplier == pytest.approx(multiplier(down), rel=1e-5)


def test_a_load_that_is_small_beside_the_weight_has_its_multiplier():
    """A force of a ten-millionth of the weight, at the middle of the pier: no multiplier is too large by itself."""
    assemblage = find_joints(wall_of([GROUND, box((0.0, 0.0, 0.0), (1.0, WIDTH, HEIGHT))], 0.6))
    weight = float(assemblage.wall.weights[1])
    live = SpaceLoadSettings(direction="+y", distribution="per_block", live=(LiveLoad((1,), 1e-7 * weight),))
    found = analyse(assemblage, loads_on(assemblage.wall, live), replace(SpaceLimitSettings(), states="none"))
    assert found.associative.load_multiplier == pytest.approx(1e7 * WIDTH / HEIGHT, rel=1e-5)


@pytest.mark.parametrize(("torsion", "remedy"), [("corners", "reach no more than λ = "), ("uniform", None)])
def test_a_load_that_joints_hold_only_if_they_bear_at_their_corners(torsion, remedy):
    """Down by 2 for 1 along, 0.45 m off the middle of a pier of 1 m: the pressure that it makes grows with it, and
    forces at the corners twist with it, where a uniform pressure gives way."""
    pier, beam = box((-0.5, -0.5, -1.0), (0.5, 0.5, 0.0)), box((-0.5, -0.5, 0.0), (1.5, 0.5, 0.2))
    assemblage = find_joints(wall_of([pier, beam, box((0.35, -0.1, 0.2), (0.55, 0.1, 0.4))], 0.6))
    live = (LiveLoad((2,), 1e3),)
    loads = loads_on(
        assemblage.wall, SpaceLoadSettings(direction=(0.0, 1.0, -2.0), distribution="per_block", live=live)
    )
    settings = SpaceLimitSettings(states="none", torsion=torsion)
    if remedy is None:
        found = analyse(assemblage, loads, settings)
        assert math.isfinite(found.associative.load_multiplier)
        assert found.other_torsion == math.inf
    else:
        with pytest.raises(UnresistedError, match="however large") as error:
            analyse(assemblage, loads, settings)
        assert remedy in error.value.remedy

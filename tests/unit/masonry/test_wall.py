from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from orchestrator.basis.arrays import read_only
from orchestrator.basis.errors import CaseError
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import running_bond
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import Block, Wall, check_wall
from tests.support.paths import DATA


def box(number, left, right, bottom, top, fixed=False):
    return Block(number, read_only([[left, bottom], [right, bottom], [right, top], [left, top]]), fixed, 2e4)


GROUND = box(0, -1, 3, -1, 0, fixed=True)
STONE = box(1, 0, 1, 0, 1)
PAIR = Wall("pair", (GROUND, STONE, box(2, 1, 2, 0, 1)), 0.3, 0.6)


CLOCKWISE = "block 2: its polygon runs clockwise; list its corners the other way round"


def with_second(block):
    return replace(PAIR, blocks=(GROUND, STONE, block))


@pytest.mark.parametrize("path", sorted(DATA.glob("*.json")), ids=lambda path: path.stem)
def test_every_wall_of_the_collection_is_accepted(path):
    wall = read_blocks(path)
    assert len(wall.blocks) > 1
    check_wall(wall)


@given(angle=st.floats(-np.pi, np.pi), scale=st.floats(0.1, 10), x=st.floats(-1e3, 1e3), y=st.floats(-1e3, 1e3))
@settings(max_examples=30, deadline=None)
@example(angle=-2.2250738585e-313, scale=0.1, x=128.0, y=0.0)
def test_rounding_of_a_turned_moved_wall_is_no_overlap_but_a_millimetre_is(angle, scale, x, y):
    turn = scale * np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    moved = running_bond(3, 3)
    moved = replace(moved, blocks=tuple(replace(b, polygon=read_only(b.polygon @ turn + (x, y))) for b in moved.blocks))
    check_wall(moved)
    pushed = replace(moved.blocks[2], polygon=read_only(moved.blocks[2].polygon - 1e-3 * turn[0] / scale))
    with pytest.raises(CaseError, match="block 1: overlaps block 2"):
        check_wall(replace(moved, blocks=(*moved.blocks[:2], pushed, *moved.blocks[3:])))


@pytest.mark.parametrize(
    ("wall", "complaint"),
    [
        (with_second(box(2, 1 - 1e-3, 2, 0, 1)), r"block 1: overlaps block 2 by 0\.001 m2, 1 mm deep"),
        (with_second(box(2, 0.9, 2, 0.2, 0.5)), r"block 1: overlaps block 2 by 0\.03 m2, 100 mm deep"),
        (with_second(box(2, 0.2, 0.4, 0.2, 0.4)), r"block 1: overlaps block 2 by 0\.04 m2"),
        (with_second(STONE), "block 1: two blocks have this id"),
        (with_second(box(2, 1, 1, 0, 1)), "block 2: its polygon"),
        (with_second(box(2, 1, 2, 0, 1.9e-5)), "block 2: its polygon is thinner than 3.54e-05 m"),
        (with_second(replace(box(2, 1, 2, 0, 1), unit_weight=np.inf)), "block 2: unit_weight inf"),
        (with_second(box(2, 1, 1e7, 0, 1e-6)), "block 2: its polygon has no area"),
        (with_second(box(2, 1, np.nan, 0, 1)), "block 2: a coordinate is not a finite number"),
        (with_second(replace(box(2, 1, 2, 0, 1), unit_weight=-1.0)), "block 2: unit_weight -1"),
        (with_second(replace(STONE, id=2, polygon=read_only([[1, 0], [2, 1], [2, 0], [1, 1]]))), "block 2: .*crosses"),
        (with_second(replace(box(2, 1, 2, 0, 1), polygon=read_only(box(2, 1, 2, 0, 1).polygon[::-1]))), CLOCKWISE),
        (with_second(replace(STONE, id=2, polygon=[[1, 0], [2, 0, 0]])), r"block 2: its polygon is no array \(n, 2\)"),
        (with_second(replace(STONE, id=2, polygon=np.zeros((4, 3)))), r"block 2: its polygon is no array \(n, 2\)"),
        (with_second(replace(STONE, id=2, polygon=np.zeros((2, 2)))), "block 2: its polygon has 2 corners"),
        (with_second(replace(box(2, 1, 2, 0, 1), thickness=0.0)), "block 2: thickness 0 is not a positive number"),
        (with_second(replace(box(2, 1, 2, 0, 1), friction=np.nan)), "block 2: friction nan is not a positive number"),
        (with_second(replace(box(2, 1, 2, 0, 1), elastic_modulus=-1.0)), "block 2: elastic_modulus -1 is not a pos"),
        (with_second(replace(box(2, 1, 2, 0, 1), poisson_ratio=0.5)), r"block 2: poisson_ratio 0\.5 is not from 0 to"),
        (replace(PAIR, blocks=PAIR.blocks[1:]), "blocks: no block is a support"),
        (replace(PAIR, blocks=(GROUND,)), "blocks: every block is a support"),
        (replace(PAIR, thickness=0.0), "thickness: 0 is not a positive number"),
        (replace(PAIR, friction=-0.1), "friction: -0.1 is not a positive number"),
        (replace(PAIR, friction=float("nan")), "friction: nan is not a positive number"),
    ],
)
def test_refusals_name_the_block(wall, complaint):
    assert find_joints(PAIR, JointSettings()).joints.count == 3
    for use in (check_wall, lambda wall: find_joints(wall, JointSettings())):
        with pytest.raises(CaseError, match=complaint):
            use(wall)


def test_tolerance_decides_what_is_rounding():
    touching = with_second(box(2, 1 - 5e-6, 2, 0, 1))
    check_wall(touching, tolerance=1e-5)
    with pytest.raises(CaseError, match="overlaps"):
        check_wall(touching, tolerance=1e-6)


def test_a_stone_of_40_micrometres_beside_one_of_a_metre_is_one():
    check_wall(with_second(box(2, 1, 2, 0, 4e-5)))


def test_a_few_square_centimetres_of_a_small_stone_in_a_long_one_are_an_overlap():
    """Rounding is measured along the shorter outline: 1e-3 m2 is less than a strip of 1e-5 m along the long one."""
    long, small = box(1, 0, 1000, 0, 1), box(2, 500, 500.04, 0.5, 0.54)
    with pytest.raises(CaseError, match=r"block 1: overlaps block 2 by 0\.0016 m2"):
        check_wall(Wall("long", (box(0, 0, 1000, -1, 0, fixed=True), long, small), 0.3, 0.6))


def test_arrays_are_private_copies():
    corners = np.zeros((3, 2))
    frozen = read_only(corners)
    corners[0] = 1.0
    assert (frozen == 0).all()
    with pytest.raises(ValueError, match="read-only"):
        frozen[0] = 1.0

"""Walls in pictures: straight joints between stones of pixels, and the multiplier of the wall that was painted."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from PIL import Image, ImageDraw

from orchestrator.basis.errors import CaseError
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.sources.drawing import Drawing, HealingSettings, wall_of
from orchestrator.masonry.sources.picture import PictureSettings, read_picture
from tests.support.intake import (
    MATERIAL,
    PUBLISHED,
    WALL_1,
    areas,
    associative,
    joint_lengths,
    painted,
    rubble,
    touching_pairs,
)


@pytest.mark.parametrize(("mortar", "colours"), [(0.0125, ("white", "black")), (0.01, ("black", "white"))])
def test_wall_1_comes_back_from_a_picture(tmp_path, mortar, colours):
    """2.5 mm a pixel, joints of 10 and 12.5 mm (4 and 5 pixels): an odd joint goes to one side, 2.5 mm at most.

    The outer joint is not stone: the wall is smaller by half a joint all round, as painted.
    """
    scale = 0.0025
    path = painted(tmp_path / "wall.png", WALL_1, scale, mortar, *colours)
    settings = PictureSettings(scale, 0.015, colours[1])
    wall, _ = wall_of(read_picture(path, settings), "wall", MATERIAL, HealingSettings(1.5 * scale, 0.2))
    assert len(wall.blocks) == 34
    outer = 2 * mortar / 2 + scale
    assert areas(wall) == pytest.approx(areas(WALL_1), abs=(0.4 + 0.175) * outer)
    assert areas(wall).sum() == pytest.approx((2.0 - mortar) * (1.05 - mortar), abs=2 * 3.05 * scale)
    assert touching_pairs(wall) == touching_pairs(WALL_1) == 83
    assert joint_lengths(wall)[1] == pytest.approx(joint_lengths(WALL_1)[1], rel=0.02)
    assert associative(wall) == pytest.approx(PUBLISHED, rel=0.02)


def test_slanted_stones_keep_one_common_edge(tmp_path):
    """Two halves of a square cut along a slant, joint of 3 pixels: one straight joint between them, and the ground."""
    image = Image.new("L", (300, 240), 255)
    ImageDraw.Draw(image).polygon([(50, 20), (128, 20), (168, 219), (50, 219)], fill=0)
    ImageDraw.Draw(image).polygon([(132, 20), (249, 20), (249, 219), (172, 219)], fill=0)
    image.save(tmp_path / "cut.png")
    settings = PictureSettings(0.005, 0.02)
    wall, _ = wall_of(read_picture(tmp_path / "cut.png", settings), "cut", MATERIAL, HealingSettings(0.003, 0.2))
    assert len(wall.blocks) == 3
    assemblage = find_joints(wall, JointSettings())
    between = (assemblage.joints.i == 1) & (assemblage.joints.j == 2)
    assert assemblage.joints.length[between] == pytest.approx([0.005 * np.hypot(40, 200)], rel=0.03)
    assert areas(wall).sum() == pytest.approx(1.0, rel=0.02)


@pytest.mark.parametrize(("seed", "falling"), [(1, None), (3, 13), (4, None)])
def test_rubble_in_a_picture_keeps_straight_joints(tmp_path, seed, falling):
    """2.5 mm a pixel, joints of 12 mm: one straight joint between neighbours, which do not interlock by pixels.

    An end of a joint is off by up to 1.5 pixels, 1.5 % of a stone of 0.25 m: 5 % where few joints decide.
    """
    image = Image.new("L", (900, 700), 255)
    stones = rubble(seed)
    for stone in stones:
        inset = shapely.get_coordinates(shapely.Polygon(stone).buffer(-0.006, join_style="mitre"))
        ImageDraw.Draw(image).polygon([(50 + 400 * x, 650 - 400 * y) for x, y in inset], fill=0)
    image.save(tmp_path / "rubble.png")
    drawing = read_picture(tmp_path / "rubble.png", PictureSettings(0.0025, 0.02))
    wall, _ = wall_of(drawing, "rubble", MATERIAL, HealingSettings(1.5 * 0.0025, 0.2))
    exact, _ = wall_of(Drawing(tuple(stones)), "rubble", MATERIAL, HealingSettings(1e-3, 0.2))
    assert len(wall.blocks) == 41
    assert touching_pairs(wall) == pytest.approx(touching_pairs(exact), abs=2), "joints of a few pixels come and go"
    assert joint_lengths(wall)[0] <= 1.1 * touching_pairs(wall)
    assert areas(wall).sum() == pytest.approx(2.0 * 1.5, rel=0.015)
    if falling is None:
        assert associative(wall) == pytest.approx(associative(exact), rel=0.05)
        return
    for found in (wall, exact):  # in both the same stone has nothing that keeps it from sliding out
        with pytest.raises(CaseError, match=rf"cannot stand under its own weight: blocks? {falling} "):
            associative(found)


@pytest.mark.parametrize("content", [b"", b"not a picture", b"\x89PNG\r\n\x1a\n" + 40 * b"\0"])
def test_what_is_no_picture_is_refused(tmp_path, content):
    (tmp_path / "wall.png").write_bytes(content)
    with pytest.raises(CaseError, match=r"wall\.png: cannot be read as a picture"):
        read_picture(tmp_path / "wall.png", PictureSettings(0.001))


def test_a_picture_without_stones_is_refused(tmp_path):
    Image.new("L", (50, 50), 255).save(tmp_path / "white.png")
    with pytest.raises(CaseError, match=r"white\.png: no black stones found"):
        read_picture(tmp_path / "white.png", PictureSettings(0.01))

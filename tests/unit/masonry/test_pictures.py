"""Stones from label images and black-and-white pictures: counts, places, common edges."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from PIL import Image

from orchestrator.app.intake import import_wall
from orchestrator.basis.errors import CaseError
from orchestrator.masonry.sources.outlines import outlines
from orchestrator.masonry.sources.picture import PictureSettings, read_picture
from tests.support.drawn_stones import bond, polygons, saved

SCALE = 0.005
"""m a pixel"""


PLAIN = PictureSettings(SCALE)


@pytest.mark.parametrize("kind", ["colours", "palette", "transparent", "uint8", "uint16", "int32", "float32"])
@pytest.mark.parametrize("mortar", [0, 3])
def test_label_images_of_every_kind(tmp_path, kind, mortar):
    """Half-stones at the ends: 4 and 5 stones a course. Without mortar neighbours touch along whole edges."""
    number, count = bond(mortar=mortar)
    drawing = read_picture(
        saved(tmp_path, number, kind, "wall.tif" if kind in ("int32", "float32") else "wall.png"), PLAIN
    )
    assert len(drawing.stones) == count == 18
    assert "18 stones found" in drawing.remarks
    found = polygons(drawing)
    assert shapely.area(found).sum() == pytest.approx((240 - mortar) * (120 - mortar) * SCALE**2)
    assert shapely.total_bounds(found) == pytest.approx([0, 0, (240 - mortar) * SCALE, (120 - mortar) * SCALE])
    assert shapely.coverage_is_valid(found)
    assert shapely.union_all(found).geom_type == "Polygon"


def test_stones_are_where_they_were_painted(tmp_path):
    number, _ = bond()
    found = polygons(read_picture(saved(tmp_path, number), PLAIN))
    top_left = shapely.box(0, 90 * SCALE, 60 * SCALE, 120 * SCALE)
    assert any(polygon.equals(top_left) for polygon in shapely.set_precision(found, 1e-9).tolist())


def test_one_colour_in_two_patches_is_two_stones_and_said(tmp_path):
    number, count = bond()
    number[number == count] = 1
    drawing = read_picture(saved(tmp_path, number), PLAIN)
    assert len(drawing.stones) == 18
    assert any("1 colour in 2 separate patches: each patch is a stone" in remark for remark in drawing.remarks)


def test_chains_that_would_cross_when_simplified_keep_apart(tmp_path):
    """Stones of 2 and 3 pixels between wavy ones: simplified by 1.5 pixels each by itself, their chains cross."""
    rng = np.random.default_rng(5)
    points = rng.random((900, 2)) * 150
    y, x = np.mgrid[:150, :150]
    number = 1 + np.argmin((x[..., None] - points[:, 0]) ** 2 + (y[..., None] - points[:, 1]) ** 2, axis=-1)
    stones, rings, _ = outlines(number)
    found = np.array([shapely.Polygon(ring) for ring in rings])
    assert len(stones) == len(np.unique(number))
    assert shapely.is_valid(found).all()
    assert shapely.coverage_is_valid(found)
    assert shapely.area(found).sum() == pytest.approx(150**2, rel=2e-3), "pieces that hang on by a corner are lost"


@pytest.mark.parametrize("kind", ["L", "RGB"])
def test_blurred_black_and_white_stays_black_and_white(tmp_path, kind):
    """Reduced by Lanczos filter, and a JPEG of quality 60: greys at every edge are no colours of stones."""
    number, count = bond(mortar=5)
    picture = Image.fromarray(np.where(number > 0, 0, 255).astype(np.uint8)).resize(
        (700, 400), Image.Resampling.LANCZOS
    )
    for name, options in (("wall.png", {}), ("wall.jpg", {"quality": 60})):
        picture.convert(kind).save(tmp_path / name, **options)
        assert len(read_picture(tmp_path / name, PictureSettings(0.002)).stones) == count
    Image.open(tmp_path / "wall.jpg").save(tmp_path / "again.png")
    assert len(read_picture(tmp_path / "again.png", PictureSettings(0.002)).stones) == count


def test_colours_that_a_smaller_picture_blends_are_told(tmp_path):
    """Four stones; where their colours meet a resized picture has others, which are stones as far as it can tell."""
    number = np.kron([[1, 2], [3, 4]], np.ones((120, 160), int))
    colours = np.array([[0, 0, 0], [200, 30, 30], [30, 200, 30], [30, 30, 200], [200, 200, 30]], np.uint8)
    settings = PictureSettings(SCALE, stones="colours", background="none", smallest=1e-6)
    picture = Image.fromarray(colours[number])
    for size, blended in (((320, 240), False), ((200, 150), True)):
        picture.resize(size, Image.Resampling.BILINEAR).save(tmp_path / "wall.png")
        said = [one for one in read_picture(tmp_path / "wall.png", settings).remarks if "blended" in one]
        assert bool(said) == blended


def test_a_wall_that_is_refused_as_edges_are_smoothed_says_so(tmp_path):
    """Every shade between two stones counts as a stone, and one of these is what the refusal names."""
    number, count = bond(mortar=5)
    shades = np.random.default_rng(3).integers(40, 216, (count + 1, 3))
    shades[0] = 255
    picture = Image.fromarray(shades.astype(np.uint8)[number]).resize((210, 120), Image.Resampling.LANCZOS)
    picture.save(tmp_path / "wall.png")
    options = {"thickness": "0.3", "scale": "2 mm", "ground": "0.2", "stones": "colours", "smallest": "2 mm"}
    with pytest.raises(CaseError, match=r"reading it warned of a likely cause: .* stones have .* blended at the edges"):
        import_wall(tmp_path / "wall.png", options)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_a_picture_stands_as_its_exif_orientation_says(tmp_path, orientation):
    """A stone of 4 x 2 and one of 2 x 2 beside it, at its lower right: what a viewer shows."""
    upright = np.full((100, 200), 255, np.uint8)
    upright[20:90, 10:110], upright[50:90, 120:180] = 0, 0
    ways = [np.array, np.fliplr, lambda a: np.rot90(a, 2), np.flipud, np.transpose, np.rot90]
    ways += [lambda a: np.rot90(a, 2).T, lambda a: np.rot90(a, 3)]
    exif = Image.Exif()
    exif[0x0112] = orientation
    Image.fromarray(ways[orientation - 1](upright)).save(tmp_path / "wall.png", exif=exif)
    drawing = read_picture(tmp_path / "wall.png", PictureSettings(SCALE, stones="black"))
    first, second = sorted(drawing.stones, key=lambda ring: ring[:, 0].min())
    assert np.ptp(first, axis=0) == pytest.approx([100 * SCALE, 70 * SCALE])
    assert np.ptp(second, axis=0) == pytest.approx([60 * SCALE, 40 * SCALE])
    assert second[:, 1].min() == pytest.approx(first[:, 1].min())
    assert any("EXIF" in remark for remark in drawing.remarks) == (orientation > 1)


def test_what_may_be_either_is_refused_naming_the_option(tmp_path):
    """Three colours for 18 stones: materials, or a picture that is not black and white."""
    number, count = bond(mortar=3)
    path = saved(tmp_path, np.where(number > 0, 1 + number % 3, 0))
    with pytest.raises(CaseError, match=r"wall\.png: --stones: it cannot be told .*--stones black, white or colours"):
        read_picture(path, PLAIN)
    assert len(read_picture(path, PictureSettings(SCALE, stones="colours")).stones) == count
    Image.open(path).save(tmp_path / "wall.jpg")
    with pytest.raises(CaseError, match=r"wall\.jpg: --stones: .*save it as PNG"):
        read_picture(tmp_path / "wall.jpg", PictureSettings(SCALE, stones="colours"))


def test_background_must_be_clear(tmp_path):
    """Black joints on a white page: both are void, which nobody says."""
    number, count = bond(mortar=3)
    picture = np.asarray(Image.open(saved(tmp_path, number))).copy()
    picture[:20] = 255
    Image.fromarray(picture).save(tmp_path / "page.png")
    with pytest.raises(CaseError, match=r"page\.png: --background: black and white both occur"):
        read_picture(tmp_path / "page.png", PLAIN)
    drawing = read_picture(tmp_path / "page.png", PictureSettings(SCALE, background="#000000, #FFFFFF"))
    assert len(drawing.stones) == count
    assert any("mortar and void: #000000, #ffffff" in remark for remark in drawing.remarks)
    drawing = read_picture(tmp_path / "page.png", PictureSettings(SCALE, background="#000000"))
    assert len(drawing.stones) == count + 1, "the white strip is a stone then"
    with pytest.raises(CaseError, match=r"--background: 'grey' is no colour; give a colour"):
        read_picture(tmp_path / "page.png", PictureSettings(SCALE, background="grey"))


def test_a_picture_full_of_stones_has_no_background(tmp_path):
    number, count = bond()
    drawing = read_picture(saved(tmp_path, number[20:-20, 20:-20]), PLAIN)
    assert len(drawing.stones) == count
    assert any("mortar and void: none" in remark for remark in drawing.remarks)


def melted(tmp_path, bridge):
    """Save running bond with joints of 2 pixels, three of which (between stones 1 and 2, 6 and 7, 7 and 8) have a
    bridge of some pixels."""
    number, count = bond(mortar=2)
    stone = number > 0
    stone[30 : 30 + bridge, 75:85] = True
    stone[60 : 60 + bridge, 45:55] = True
    stone[60 : 60 + bridge, 105:115] = True
    Image.fromarray(np.where(stone, 0, 255).astype(np.uint8)).save(tmp_path / "melted.png")
    return tmp_path / "melted.png", count


@pytest.mark.parametrize(("bridge", "reach"), [(1, 1), (2, 1), (3, 2), (4, 2), (6, 4)])
def test_stones_that_run_together_are_told_and_parted(tmp_path, bridge, reach):
    path, count = melted(tmp_path, bridge)
    drawing = read_picture(path, PLAIN)
    assert len(drawing.stones) == count - 3
    warning = next(remark for remark in drawing.remarks if "run together" in remark)
    assert warning.startswith("WARNING: 2 patches look like several stones run together (5 stones, the largest at (")
    assert warning.endswith(f"use a finer picture, or --split {reach}")
    parted = read_picture(path, PictureSettings(SCALE, split=reach))
    assert len(parted.stones) == count
    assert f"3 stones more by parting patches with --split {reach}" in parted.remarks
    assert not any("run together" in remark for remark in parted.remarks)
    found = polygons(parted)
    assert shapely.coverage_is_valid(found)
    number, _ = bond(mortar=2)
    painted = polygons(read_picture(saved(tmp_path, number), PLAIN))
    for polygon in painted:
        nearest = found[np.argmax(shapely.area(shapely.intersection(found, polygon)))]
        assert shapely.hausdorff_distance(nearest, polygon) < 3 * SCALE


def test_stones_that_do_not_run_together_raise_no_alarm(tmp_path):
    """Irregular stones with joints of 2 pixels."""
    rng = np.random.default_rng(3)
    points = rng.random((60, 2)) * 400
    y, x = np.mgrid[:400, :400]
    far = np.sort((x[..., None] - points[:, 0]) ** 2 + (y[..., None] - points[:, 1]) ** 2, axis=-1)
    joint = np.sqrt(far[..., 1]) - np.sqrt(far[..., 0]) < 4
    Image.fromarray(np.where(joint, 255, 0).astype(np.uint8)).save(tmp_path / "rubble.png")
    drawing = read_picture(tmp_path / "rubble.png", PictureSettings(0.002))
    assert not any("WARNING" in remark for remark in drawing.remarks)
    assert len(drawing.stones) == 57, "three are smaller than 10 pixels by 10"


def test_a_joint_missing_over_most_of_a_stone_is_pointed_out(tmp_path):
    """No bridge: 15 of 28 pixels of the joint between stones 1 and 2 are missing, the others are void inside."""
    number, count = bond(mortar=2)
    stone = number > 0
    stone[20:35, 75:85] = True
    Image.fromarray(np.where(stone, 0, 255).astype(np.uint8)).save(tmp_path / "half.png")
    drawing = read_picture(tmp_path / "half.png", PLAIN)
    assert len(drawing.stones) == count - 1
    assert any(text.startswith("WARNING: 1 stone with void inside, as of a joint that") for text in drawing.remarks)


def test_a_patch_of_many_stones_is_pointed_out(tmp_path):
    """Courses 1 to 5 of 6 have no joints left at all."""
    number, _ = bond(6, mortar=2)
    number[52:, 20:260] = 1
    Image.fromarray(np.where(number > 0, 0, 255).astype(np.uint8)).save(tmp_path / "lost.png")
    drawing = read_picture(tmp_path / "lost.png", PLAIN)
    assert any("WARNING: the largest patch is 2" in text and "are joints missing?" in text for text in drawing.remarks)


def test_thin_grey_joints_ask_for_another_threshold(tmp_path):
    """Joints of lightness 100 are black by default; every joint is lost, and no bridge tells."""
    number, count = bond(mortar=2)
    grey = np.where(number > 0, 0, 100)
    grey[:20], grey[-20:], grey[:, :20], grey[:, -20:] = 255, 255, 255, 255
    Image.fromarray(grey.astype(np.uint8)).save(tmp_path / "grey.png")
    drawing = read_picture(tmp_path / "grey.png", PLAIN)
    assert any(f"1 stone at threshold 128, but {count} with --threshold 96" in text for text in drawing.remarks)
    assert len(read_picture(tmp_path / "grey.png", PictureSettings(SCALE, threshold=96)).stones) == count
    dim = Image.open(tmp_path / "grey.png").point(lambda value: value // 4)
    dim.save(tmp_path / "dim.png")
    with pytest.raises(
        CaseError, match=r"--threshold: 128 parts nothing: the picture's lightness is 0 to 63; give one"
    ):
        read_picture(tmp_path / "dim.png", PictureSettings(SCALE, stones="black"))


def test_white_stones_read_as_black_are_pointed_out(tmp_path):
    number, count = bond(mortar=3)
    Image.fromarray(np.where(number > 0, 255, 0).astype(np.uint8)).save(tmp_path / "inverse.png")
    remarks = read_picture(tmp_path / "inverse.png", PLAIN).remarks
    assert any(f"1 black patch, {count} white ones" in remark and "--stones white" in remark for remark in remarks)


def test_pictures_that_cannot_be_used(tmp_path):
    Image.fromarray(np.full((50, 50), np.nan, np.float32)).save(tmp_path / "nan.tif")
    Image.new("1", (6000, 6000)).save(tmp_path / "huge.png")
    Image.new("RGB", (50, 50), "red").save(tmp_path / "red.png")
    for name, complaint in (
        ("nan.tif", "its pixels are not whole numbers"),
        ("huge.png", "has more than 25000000 pixels"),
        ("none.png", "no such file"),
    ):
        with pytest.raises(CaseError, match=rf"{name}: {complaint}; ") as caught:
            read_picture(tmp_path / name, PLAIN)
        assert "\n" not in str(caught.value)
    with pytest.raises(CaseError, match="--split: does not go with one colour a stone"):
        read_picture(tmp_path / "red.png", PictureSettings(SCALE, stones="colours", split=2))

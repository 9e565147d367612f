"""Stones from label images, black-and-white pictures, COCO annotations and SVG: counts, places, common edges."""

from __future__ import annotations

import json

import numpy as np
import pytest
import shapely
from PIL import Image

from orchestrator.basis.errors import CaseError
from orchestrator.masonry.sources.closed_outlines import Layers
from orchestrator.masonry.sources.coco import CocoSettings, holds_annotations, read_coco
from orchestrator.masonry.sources.outlines import outlines
from orchestrator.masonry.sources.picture import PictureSettings, read_picture
from orchestrator.masonry.sources.svg import read_svg

SCALE = 0.005
"""m a pixel"""
PLAIN = PictureSettings(SCALE)


def polygons(drawing):
    return np.array([shapely.Polygon(outline) for outline in drawing.stones])


def saved(tmp_path, number, kind="colours", name="wall.png"):
    """Save numbers of stones (rows, columns) as a picture in which every stone has a colour, or its number."""
    if kind == "colours":
        colours = np.random.default_rng(1).permutation(2**24 - 2)[: number.max() + 1] + 1
        colours[0] = 0
        code = colours[number]
        picture = Image.fromarray(np.stack([code >> 16, code >> 8 & 255, code & 255], axis=-1).astype(np.uint8))
    elif kind == "palette":
        picture = Image.fromarray(number.astype(np.uint8), mode="P")
        picture.putpalette([0, 0, 0] + np.random.default_rng(1).integers(40, 216, 765).tolist())
    elif kind == "transparent":
        code = np.stack([number * 20 % 256, number * 7 % 256, number, 255 * (number > 0)], axis=-1)
        picture = Image.fromarray(code.astype(np.uint8))
    else:
        picture = Image.fromarray(number.astype(kind))
    picture.save(tmp_path / name)
    return tmp_path / name


def bond(courses=4, mortar=0):
    """Return numbers of the stones of running bond, 60 by 30 pixels each, with void of 20 pixels around."""
    number = np.zeros((40 + 30 * courses, 40 + 240), int)
    count = 0
    for course in range(courses):
        for left in range(-30 * (course % 2), 240, 60):
            count += 1
            first, last = max(left, 0), min(left + 60, 240)
            rows = slice(20 + 30 * course, 20 + 30 * (course + 1) - mortar)
            number[rows, 20 + first : 20 + last - mortar] = count
    return number, count


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
    assert any(f"1 stones at threshold 128, but {count} with --threshold 96" in text for text in drawing.remarks)
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
    assert any(f"1 black patches, {count} white ones" in remark and "--stones white" in remark for remark in remarks)


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


STONES = [
    [(0, 0), (40, 0), (40, 20), (0, 20)],
    [(40, 0), (100, 0), (95, 20), (40, 20)],
    [(0, 20), (60, 20), (60, 50), (0, 45)],
    [(60, 20), (95, 20), (90, 55), (60, 50)],
]
"""corners in pixels, y downwards"""
GROUND = [(-10, 55), (110, 55), (110, 75), (-10, 75)]


def expected(scale, low=(0, 55)):
    return [(np.array(stone, float) - low) * scale * [1, -1] for stone in STONES]


def same(outline, other):
    return shapely.Polygon(outline).symmetric_difference(shapely.Polygon(other)).area


def run_lengths(mask):
    flat = mask.T.ravel()
    ends = [0, *(np.flatnonzero(flat[1:] != flat[:-1]) + 1), len(flat)]
    return [0] * bool(flat[0]) + [int(length) for length in np.diff(ends)]


def compressed(runs):
    """Return run lengths as the COCO API writes them (rleToString)."""
    text = ""
    for k, run in enumerate(runs):
        value = run - (runs[k - 2] if k > 2 else 0)
        more = True
        while more:
            bits, value = value & 31, value >> 5
            more = value != (-1 if bits & 16 else 0)
            text += chr(48 + (bits | 32 if more else bits))
    return text


def annotated(tmp_path, segmentations, categories=None, **more):
    names = sorted(set(categories or ["stone"]))
    record = {
        "images": [{"id": 7, "file_name": "wall.jpg", "width": 120, "height": 90}],
        "annotations": [
            {
                "id": k,
                "image_id": 7,
                "category_id": names.index((categories or ["stone"] * 99)[k]),
                "segmentation": given,
            }
            for k, given in enumerate(segmentations)
        ],
        "categories": [{"id": k, "name": name} for k, name in enumerate(names)],
    } | more
    (tmp_path / "wall.json").write_text(json.dumps(record))
    return tmp_path / "wall.json"


def flat(corners):
    return [float(number) for corner in corners for number in corner]


def test_coco_polygons_are_the_stones(tmp_path):
    path = annotated(tmp_path, [[flat(stone)] for stone in STONES])
    assert holds_annotations(path)
    drawing = read_coco(path, Layers(), CocoSettings(0.01))
    assert len(drawing.stones) == 4
    assert drawing.materials == ()
    assert "4 stones found" in drawing.remarks
    for outline, exact in zip(drawing.stones, expected(0.01), strict=True):
        assert same(outline, exact) == pytest.approx(0, abs=1e-12)


def test_coco_categories_are_roles_and_materials(tmp_path):
    names = ["stone", "brick", "stone", "stone", "supports", "Openings"]
    path = annotated(tmp_path, [[flat(shape)] for shape in [*STONES, GROUND, STONES[3]]], names)
    drawing = read_coco(path, Layers(), CocoSettings(0.01))
    assert drawing.materials == ("stone", "brick", "stone", "stone")
    assert len(drawing.openings) == 1
    assert same(drawing.supports[0], (np.array(GROUND) - [0, 55]) * 0.01 * [1, -1]) == pytest.approx(0, abs=1e-12)
    only = read_coco(path, Layers(blocks="brick"), CocoSettings(0.01))
    assert len(only.stones) == 1
    assert any("3 annotations of other categories left out: stone" in remark for remark in only.remarks)
    with pytest.raises(CaseError, match=r"no annotation has a category 'oak'; categories here: Openings, brick, stone"):
        read_coco(path, Layers(blocks="oak"), CocoSettings(0.01))


@pytest.mark.parametrize("form", [list, compressed])
def test_coco_masks_are_decoded(tmp_path, form):
    number, count = bond(mortar=2)
    masks = [{"size": list(number.shape), "counts": form(run_lengths(number == k))} for k in range(1, count + 1)]
    drawing = read_coco(annotated(tmp_path, masks), Layers(), CocoSettings(SCALE, 0.02))
    again = read_picture(saved(tmp_path, number), PLAIN)
    assert len(drawing.stones) == count
    by_place = [
        sorted(polygons(each), key=lambda p: (round(p.centroid.y, 6), p.centroid.x)) for each in (drawing, again)
    ]
    for one, other in zip(*by_place, strict=True):
        assert one.symmetric_difference(other).area == pytest.approx(0, abs=1e-12)


def test_coco_polygons_with_mortar_grow_until_they_touch(tmp_path):
    apart = [np.array(shapely.Polygon(stone).buffer(-1, join_style="mitre").exterior.coords)[:-1] for stone in STONES]
    names = ["stone", "brick", "stone", "stone"]
    path = annotated(tmp_path, [[flat(stone)] for stone in apart], names)
    assert shapely.union_all(polygons(read_coco(path, Layers(), CocoSettings(0.01)))).geom_type == "MultiPolygon"
    drawing = read_coco(path, Layers(), CocoSettings(0.01, 0.03))
    assert shapely.union_all(polygons(drawing)).geom_type == "Polygon"
    assert sorted(drawing.materials) == ["brick", "stone", "stone", "stone"]
    brick = drawing.stones[drawing.materials.index("brick")]
    assert same(brick, expected(0.01)[1]) < 0.2 * shapely.Polygon(STONES[1]).area * 0.01**2


def test_coco_parts_and_crossed_outlines_are_told(tmp_path):
    bow_tie = [(0, 0), (40, 20), (40, 0), (0, 21)]
    path = annotated(tmp_path, [[flat(STONES[0]), flat(STONES[1])], [flat(np.array(bow_tie) + [0, 30])]])
    drawing = read_coco(path, Layers(), CocoSettings(0.01))
    assert len(drawing.stones) == 3
    assert any("1 more outlines than annotations" in remark for remark in drawing.remarks)
    assert any("1 outlines cross themselves" in remark for remark in drawing.remarks)
    assert all(polygon.is_valid for polygon in polygons(drawing))


@pytest.mark.parametrize(
    ("segmentation", "complaint"),
    [
        ([[0, 0, 1, 0]], "at least three corners"),
        ([[0, 0, 1, 0, 1]], "at least three corners"),
        ([[0, 0, 1, 0, 1, float("nan")]], "at least three corners"),
        ([[0, 0, 1, 0, 1, 1e300]], "at least three corners"),
        ([["a", 0, 1, 0, 1, 1]], "at least three corners"),
        ([], "neither polygons nor run lengths"),
        (None, "neither polygons nor run lengths"),
        ({"size": [90, 120], "counts": [5, 5]}, "do not fill its size"),
        ({"size": [90, 120], "counts": [5, -5, 10800]}, "do not fill its size"),
        ({"size": [90, 120], "counts": "not run lengths"}, "do not fill its size"),
        ({"size": [90, 120], "counts": "~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~"}, "do not fill its size"),
        ({"size": [90000, 120000], "counts": [10800000000]}, "has more than 25000000 pixels"),
        ({"size": "large"}, "do not fill its size"),
    ],
)
def test_coco_annotations_that_cannot_be_read(tmp_path, segmentation, complaint):
    path = annotated(tmp_path, [[flat(STONES[0])], segmentation])
    with pytest.raises(CaseError, match=rf"wall\.json: annotations\[1\]\.segmentation: .*{complaint}") as caught:
        read_coco(path, Layers(), CocoSettings(0.01))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"images": 3}', "null", '{"images": [3], "annotations": []}', "[" * 9999]
)
def test_what_is_no_coco_file(tmp_path, text):
    (tmp_path / "wall.json").write_text(text)
    with pytest.raises(CaseError, match=r"wall\.json: .*; save it as COCO JSON"):
        read_coco(tmp_path / "wall.json", Layers(), CocoSettings(0.01))
    assert not holds_annotations(tmp_path / "wall.json") or '"annotations"' in text


def test_coco_of_several_images_is_refused_unless_one_has_annotations(tmp_path):
    images = [{"id": 7, "width": 9, "height": 9}, {"id": 8, "file_name": "b.jpg"}]
    path = annotated(tmp_path, [[flat(stone)] for stone in STONES], images=images)
    assert len(read_coco(path, Layers(), CocoSettings(0.01)).stones) == 4
    record = json.loads(path.read_text())
    record["annotations"][0]["image_id"] = 8
    path.write_text(json.dumps(record))
    with pytest.raises(
        CaseError, match=r"images: 2 images have annotations \(7, b\.jpg\); save the annotations of one"
    ):
        read_coco(path, Layers(), CocoSettings(0.01))


def svg(tmp_path, body, head='width="120mm" height="90mm" viewBox="0 0 120 90"'):
    spaces = 'xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
    (tmp_path / "wall.svg").write_text(f"<svg {spaces} {head}>{body}</svg>")
    return tmp_path / "wall.svg"


def as_path(stone, command="M"):
    (x, y), *rest = stone
    return f"{command} {x},{y} " + " ".join(f"L{a},{b}" for a, b in rest) + " z"


def as_polygon(stone):
    return " ".join(f"{x},{y}" for x, y in stone)


@pytest.mark.parametrize(
    "body",
    [
        "".join(f'<path d="{as_path(stone)}"/>' for stone in STONES),
        f'<path d="{" ".join(as_path(stone) for stone in STONES)}"/>',
        "".join(f'<polygon points="{as_polygon(stone)}"/>' for stone in STONES),
        "".join(f'<polyline points="{as_polygon([*stone, stone[0]])}"/>' for stone in STONES),
        '<g transform="translate(5 7) scale(.5)"><g transform="matrix(0 2 -2 0 0 0)">'
        + "".join(f'<path transform="rotate(-90)" d="{as_path(stone)}"/>' for stone in STONES)
        + "</g></g>",
        '<path d="m0 0h40v20H0zm40 0 h60l-5 20h-55zM0 20l60-0 0 3e1-60-5z"/>'
        '<path d="M60,20 95,20 90,55 60,50Z" style="fill:none"/>',
        "".join(
            f'<line x1="{a[0]}" y1="{a[1]}" x2="{b[0]}" y2="{b[1]}"/>'
            for stone in STONES
            for a, b in zip(stone, [*stone[1:], stone[0]], strict=True)
        ),
    ],
    ids=["paths", "one path", "polygons", "polylines", "transforms", "relative", "lines"],
)
def test_svg_shapes_are_the_stones(tmp_path, body):
    drawing = read_svg(svg(tmp_path, body), Layers(), 1e-5)
    assert len(drawing.stones) == 4
    for exact in expected(0.001):
        assert min(same(outline, exact) for outline in drawing.stones) == pytest.approx(0, abs=1e-12)


def test_svg_groups_are_roles_and_materials(tmp_path):
    one, two, three, four = (f'<path d="{as_path(stone)}"/>' for stone in STONES)
    body = (
        f'<g inkscape:groupmode="layer" inkscape:label="stone" id="layer1">{one}{two}<g id="g12">{three}</g></g>'
        f'<g id="timber">{four}</g><g id="supports"><path d="{as_path(GROUND)}"/></g>'
        f'<g id="notes">{one}<text>wall</text></g><g id="stone" style="display: none">{one}</g>'
        f'<defs><g id="stone">{four}</g></defs>'
    )
    drawing = read_svg(svg(tmp_path, body), Layers("stone, timber"), 1e-5)
    assert drawing.materials == ("stone", "stone", "stone", "timber")
    assert len(drawing.supports) == 1
    assert any("1 elements passed over: text" in remark for remark in drawing.remarks)
    with pytest.raises(
        CaseError, match=r"nothing is drawn in a group 'blocks'; .*groups: notes, stone, supports, timber"
    ):
        read_svg(svg(tmp_path, body), Layers(), 1e-5)


@pytest.mark.parametrize(
    ("head", "scale", "unit"),
    [
        ('width="12cm" height="9cm" viewBox="0 0 120 90"', None, 1e-3),
        ('width="120" height="90" viewBox="0 0 120 90"', 0.02, 0.02),
        ('width="120mm" height="90mm" viewBox="0 0 240 180"', None, 0.5e-3),
        ('width="120mm" height="90mm"', None, 0.0254 / 96),
        ('width="120mm" height="90mm" viewBox="-7 -9 120 90"', 0.01, 0.01),
    ],
)
def test_svg_units(tmp_path, head, scale, unit):
    body = "".join(f'<path d="{as_path(stone)}"/>' for stone in STONES)
    drawing = read_svg(svg(tmp_path, body, head), Layers(), 1e-5, scale)
    for outline, exact in zip(drawing.stones, expected(unit), strict=True):
        assert same(outline, exact) == pytest.approx(0, abs=1e-9 * unit)


@pytest.mark.parametrize(
    ("body", "area"),
    [
        ('<circle cx="50" cy="40" r="20"/>', np.pi * 20**2),
        ('<ellipse cx="50" cy="40" rx="20" ry="10" transform="rotate(30 50 40)"/>', np.pi * 200),
        ('<rect x="10" y="10" width="60" height="40" rx="10"/>', 60 * 40 - (4 - np.pi) * 100),
        ('<rect x="10" y="10" width="60" height="40"/>', 60 * 40),
        ('<path d="M10 10A20 20 0 0150 10z"/>', np.pi * 200),
        ('<path d="M10 10a20 20 0 1 0 40 0z"/>', np.pi * 200),
        ('<path d="M30 10 A20 20 0 1 1 10 30 z"/>', 0.75 * np.pi * 400 + 200),
        ('<path d="M0 0 Q 30 60 60 0 z"/>', 60 * 60 / 3),
        ('<path d="M0 0 Q 15 30 30 30 T 60 0 z"/>', 2 * (30 * 30 - 30 * 30 / 3)),
        ('<path d="M0 0 C 0 40 60 40 60 0 z"/>', 60 * 40 * 0.6),
        ('<path d="M0 0 C 10 20 20 30 30 30 S 50 20 60 0 z"/>', 2 * 30 * 20),
        ('<path d="M0 0 h60 v60 h-60z M20 20 h20 v20 h-20z"/>', 3600),
    ],
)
def test_svg_curves_are_as_fine_as_asked(tmp_path, body, area):
    drawing = read_svg(svg(tmp_path, body), Layers(), 1e-6)
    assert len(drawing.stones) == 1
    found = polygons(drawing)[0]
    assert found.area == pytest.approx(area * 1e-6, abs=1e-6 * found.length)
    coarse = polygons(read_svg(svg(tmp_path, body), Layers(), 1e-4))[0]
    assert shapely.hausdorff_distance(found, coarse) < 1.1e-4


@pytest.mark.parametrize(
    ("body", "head", "complaint"),
    [
        (f'<path d="{as_path(STONES[0])}"/>', 'width="120" height="90"', "--scale: the drawing does not say"),
        (f'<path d="{as_path(STONES[0])}"/>', 'width="9furlong" height="9mm"', "--scale: the drawing does not say"),
        (f'<path d="{as_path(STONES[0])}"/>', 'width="9mm" height="9mm" viewBox="0 0 0 9"', "viewBox: is not four"),
        (
            f'<path d="{as_path(STONES[0])}"/>',
            'width="9mm" height="9mm" viewBox="0 0 a 9"',
            "viewBox: '0 0 a 9' is not",
        ),
        ("", None, "blocks: nothing is drawn"),
        ('<path id="p1" d="M 0 0 L 5 nan z"/>', None, "path p1: path data cannot be read at 'nan z'"),
        ('<path d="M 0 0 L 5 z"/>', None, "path: path data have 1 numbers after 'L'"),
        ('<path d="5 5 L 5 z"/>', None, "path: path data have 2 numbers after 'no command'"),
        ('<path d="M0 0 L1e14 0 L 0 5z"/>', None, "a coordinate is not a number below 1e9 m"),
        ('<path d="M0 0 L1e999 0 L 0 5z"/>', None, "path: a number is not below 1e+15"),
        ('<path d="M0 0 C 0 1e8 1e8 0 5 5z"/>', None, "a curve needs more than 1000 chords"),
        ('<g transform="spin(3)"><path d="M0 0"/></g>', None, "transform: 'spin' with 1 numbers cannot be read"),
        ('<g transform="scale(x)"><path d="M0 0"/></g>', None, "transform: 'x' is not a list of numbers"),
        ("<g>" * 200 + "</g>" * 200, None, "nested more than 100 deep"),
    ],
)
def test_svg_drawings_that_cannot_be_used(tmp_path, body, head, complaint):
    path = svg(tmp_path, body, head) if head else svg(tmp_path, body)
    with pytest.raises(CaseError) as caught:
        read_svg(path, Layers(), 1e-3)
    assert "wall.svg: " in str(caught.value)
    assert complaint in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "content",
    [b"", b"not xml", b"<svg>", b"<html/>", b"\x00\xff", b'<?xml version="1.0" encoding="nothing"?><svg/>'],
)
def test_what_is_no_svg(tmp_path, content):
    (tmp_path / "wall.svg").write_bytes(content)
    with pytest.raises(CaseError, match=r"wall\.svg: is not an SVG drawing"):
        read_svg(tmp_path / "wall.svg", Layers(), 1e-3)


def test_svg_entities_are_refused_before_they_expand(tmp_path):
    bomb = "".join(f'<!ENTITY e{k + 1} "{10 * f"&e{k};"}">' for k in range(9))
    (tmp_path / "wall.svg").write_text(f'<!DOCTYPE svg [<!ENTITY e0 "lol">{bomb}]><svg>&e9;</svg>')
    with pytest.raises(CaseError, match="declares entities, which are not read; save it as plain SVG"):
        read_svg(tmp_path / "wall.svg", Layers(), 1e-3)

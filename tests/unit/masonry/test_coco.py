"""Stones from COCO annotations: polygons, run lengths, categories."""

from __future__ import annotations

import json

import numpy as np
import pytest
import shapely

from orchestrator.basis.errors import CaseError
from orchestrator.masonry.sources.closed_outlines import Layers
from orchestrator.masonry.sources.coco import CocoSettings, holds_annotations, read_coco
from orchestrator.masonry.sources.picture import PictureSettings, read_picture
from tests.support.drawn_stones import GROUND, STONES, bond, expected, polygons, same, saved


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


def test_annotations_that_are_lost_are_counted(tmp_path):
    """Two of an image and one of a category that the file does not list, one with an empty mask."""
    file = annotated(tmp_path, [[flat(stone)] for stone in STONES])
    record = json.loads(file.read_text())
    one = record["annotations"][0]
    record["annotations"][3]["category_id"] = 12
    record["annotations"] += [one | {"image_id": 8}, one | {"image_id": 9}]
    record["annotations"] += [one | {"segmentation": {"size": [90, 120], "counts": [90 * 120]}}]
    file.write_text(json.dumps(record))
    drawing = read_coco(file, Layers(), CocoSettings(0.01))
    assert len(drawing.stones) == 4
    assert drawing.materials == ("stone", "stone", "stone", "category 12")
    said = [remark for remark in drawing.remarks if "WARNING" in remark]
    assert said == [
        "WARNING: 2 annotations of images that the file does not list, left out",
        "WARNING: 1 annotation with an empty mask left out",
        "WARNING: 1 annotation of a category that the file does not list: category 12",
    ]


def test_a_file_without_categories_is_one_of_stones(tmp_path):
    file = annotated(tmp_path, [[flat(stone)] for stone in STONES])
    file.write_text(json.dumps(json.loads(file.read_text()) | {"categories": []}))
    drawing = read_coco(file, Layers(), CocoSettings(0.01))
    assert drawing.materials == ()
    assert not [remark for remark in drawing.remarks if "WARNING" in remark]


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
    drawing = read_coco(annotated(tmp_path, masks), Layers(), CocoSettings(0.005, 0.02))
    again = read_picture(saved(tmp_path, number), PictureSettings(0.005))
    assert len(drawing.stones) == count
    by_place = [
        sorted(polygons(each), key=lambda p: (round(p.centroid.y, 6), p.centroid.x)) for each in (drawing, again)
    ]
    for one, other in zip(*by_place, strict=True):
        assert one.symmetric_difference(other).area == pytest.approx(0, abs=1e-12)


def test_a_mask_of_another_size_than_the_image_is_told(tmp_path):
    """Masks of a smaller copy of the picture: `--scale` is of its pixels, or the wall is as much too small."""
    mask = np.zeros((90, 120), dtype=int)
    mask[20:60, 30:90] = 1
    whole, half = ({"size": list(one.shape), "counts": run_lengths(one == 1)} for one in (mask, mask[::2, ::2]))
    drawing = read_coco(annotated(tmp_path, [half]), Layers(), CocoSettings(0.01))
    assert sum(shape.area for shape in polygons(drawing)) == pytest.approx(0.3 * 0.2)
    (said,) = (said for said in drawing.remarks if "size" in said)
    assert said.startswith("WARNING: 1 annotation with a mask of another size than the image: ")
    right = read_coco(annotated(tmp_path, [whole]), Layers(), CocoSettings(0.01))
    assert not any("size" in said for said in right.remarks)


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


@pytest.mark.parametrize("mortar", [0.0, 0.03])
def test_a_coco_polygon_on_one_line_is_no_stone(tmp_path, mortar):
    line = [0, 40, 20, 40, 20, 40, 0, 40]
    path = annotated(tmp_path, [[flat(stone)] for stone in STONES] + [[line]])
    assert len(read_coco(path, Layers(), CocoSettings(0.01, mortar)).stones) == len(STONES)


def test_coco_parts_and_crossed_outlines_are_told(tmp_path):
    bow_tie = [(0, 0), (40, 20), (40, 0), (0, 21)]
    path = annotated(tmp_path, [[flat(STONES[0]), flat(STONES[1])], [flat(np.array(bow_tie) + [0, 30])]])
    drawing = read_coco(path, Layers(), CocoSettings(0.01))
    assert len(drawing.stones) == 3
    assert any("1 more outlines than annotations" in remark for remark in drawing.remarks)
    assert any("1 outline crosses itself, its largest part is kept" in remark for remark in drawing.remarks)
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


def test_an_image_and_its_annotations_may_be_without_ids(tmp_path):
    path = annotated(tmp_path, [[flat(STONES[0])]])
    record = json.loads(path.read_text())
    for row in (*record["images"], *record["annotations"]):
        row.pop("id", None), row.pop("image_id", None)
    path.write_text(json.dumps(record))
    assert len(read_coco(path, Layers(), CocoSettings(0.01)).stones) == 1


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

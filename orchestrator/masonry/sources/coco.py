"""Stones annotated in an image (COCO JSON, object detection) -> Drawing: polygons, or masks as run lengths, in pixels.

Polygons are outlines as they are. Given a width of mortar, and where there are masks, they are filled into a label
image and read as such. Categories whose names match are supports and openings; of several others, the category is a
stone's material.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import shapely
from annotated_types import Ge, Gt
from scipy import ndimage

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError, naming
from orchestrator.basis.printed import counted
from orchestrator.basis.units import Unit
from orchestrator.masonry.sources.block_files import json_in, refuse_what_is_no_file
from orchestrator.masonry.sources.closed_outlines import Layers, is_chosen
from orchestrator.masonry.sources.drawing import Drawing
from orchestrator.masonry.sources.outlines import outlines
from orchestrator.masonry.sources.picture import drawing_of_numbers, lower_left, upright
from orchestrator.masonry.sources.pixels import LARGEST_PICTURE
from orchestrator.masonry.sources.segmentation import large_patches
from orchestrator.masonry.wall import LARGEST_COUNT

LARGEST_FILE = 500_000_000
"""bytes"""
LARGEST_PIXEL = 1e6
"""pixels"""
OTHER_SIZE = "with a mask of another size than the image: --scale is taken for the side of its own pixels"


@dataclass(frozen=True, slots=True)
class CocoSettings(Checked):
    """What turns annotations into stones."""

    scale: Annotated[float, Gt(0), Unit("m")]
    """side of a pixel"""
    mortar: Annotated[float, Ge(0), Unit("m")] = 0.0
    """widest joint between stones that is closed; 0: polygons are kept as they are"""
    smallest: Annotated[float, Gt(0), Unit("m")] = 0.02
    """annotations of less area than a square of this side are dirt"""


@dataclass(frozen=True, eq=False, slots=True)
class Shape:
    """One annotated patch of a category: its outline (n, 2) in pixels, y downwards, or its `mask` (rows, columns), the
    first pixel of which is at `corner` (column, row)."""

    category: str
    outline: FloatArray | None = None
    mask: BoolArray | None = None
    corner: tuple[int, int] = (0, 0)


def holds_annotations(path: Path) -> bool:
    """Return whether the JSON file `path` is one of annotations, not of blocks; False for what cannot be read."""
    try:
        refuse_what_is_no_file(path, LARGEST_FILE, "")
        record = json.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError, RecursionError, CaseError):
        return False
    return isinstance(record, dict) and "images" in record and "annotations" in record


def read_coco(path: Path, layers: Layers, settings: CocoSettings) -> Drawing:
    """Return what is annotated in `path` in m, y upwards, the lower left corner of its stones at (0, 0).

    layers: names of categories. Raises CaseError naming file and remedy.
    """
    with naming(path):
        shapes, remarks = _shapes(_record(path))
        return _drawing(shapes, remarks, layers, settings)


def _record(path: Path) -> dict[str, Any]:
    record = json_in(path, "a file of annotations", LARGEST_FILE, "save it as COCO JSON")
    for key in ("images", "annotations"):
        rows = record.get(key) if isinstance(record, dict) else None
        if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
            raise CaseError(key, "is not a list of objects", "save it as COCO JSON, object detection")
    return dict(record)


def _shapes(record: dict[str, Any]) -> tuple[list[Shape], list[str]]:
    """Return what is annotated in the one image that has annotations, and remarks."""
    annotated = {str(row.get("image_id")) for row in record["annotations"]}
    images = [row for row in record["images"] if str(row.get("id")) in annotated]
    if len(images) != 1:
        names = ", ".join(str(row.get("file_name", row.get("id")))[:40] for row in images[:5])
        problem = f"{len(images)} images have annotations" + f" ({names})" * bool(images)
        raise CaseError("images", problem, "save the annotations of one image")
    rows = [
        (k, row) for k, row in enumerate(record["annotations"]) if str(row.get("image_id")) == str(images[0].get("id"))
    ]
    categories = record.get("categories", [])
    if not isinstance(categories, list) or not all(isinstance(row, dict) for row in categories):
        raise CaseError("categories", "is not a list of objects", "save it as COCO JSON, object detection")
    name = {row.get("id"): str(row.get("name", "")) for row in categories if isinstance(row.get("id"), int | str)}
    unlisted = {k: _unlisted(row, name) for k, row in rows}
    shapes = [
        (f"annotations[{k}]", unlisted[k] or name.get(row.get("category_id"), ""), part)
        for k, row in rows
        for part in _parts(row.get("segmentation"), f"annotations[{k}]")
    ]
    if len(shapes) > LARGEST_COUNT:
        raise CaseError("annotations", f"more than {LARGEST_COUNT}", "import the wall in parts")
    parts = len(shapes) - len({key for key, _, _ in shapes})
    remarks = [f"WARNING: {parts} more outlines than annotations: each part is taken for a stone"] if parts else []
    read = [_shape(part, category, key) for key, category, part in shapes]
    return [shape for some in read for shape in some], [
        *remarks,
        *_said_lost(len(record["annotations"]) - len(rows), "of images that the file does not list, left out"),
        *_said_lost(sum(not some for some in read), "with an empty mask left out"),
        *_said_lost(sum(_is_of_another_size(part, images[0]) for _, _, part in shapes), OTHER_SIZE),
        *(
            text
            for one in sorted({*unlisted.values()} - {""})
            for text in _said_lost([*unlisted.values()].count(one), f"of a category that the file does not list: {one}")
        ),
    ]


def _is_of_another_size(part: Any, image: dict[str, Any]) -> bool:
    """Return whether a mask has another size than its image, where the file says both."""
    size = part.get("size") if isinstance(part, dict) else None
    return size is not None and None not in (stated := [image.get("height"), image.get("width")]) and size != stated


def _unlisted(row: dict[str, Any], name: dict[int | str, str]) -> str:
    """Return a name for the category of an annotation where the file lists some and not this one; else none."""
    category = row.get("category_id")
    return f"category {category}"[:40] if name and not (isinstance(category, int | str) and category in name) else ""


def _said_lost(number: int, what: str) -> list[str]:
    return [f"WARNING: {counted(number, 'annotation')} {what}"] if number else []


def _parts(segmentation: Any, key: str) -> list[Any]:
    """Return the polygons (flat lists) or the one mask of an annotation."""
    if isinstance(segmentation, dict):
        return [segmentation]
    if isinstance(segmentation, list) and segmentation and all(isinstance(part, list) for part in segmentation):
        return segmentation
    remedy = "annotate polygons or masks, not only boxes"
    raise CaseError(f"{key}.segmentation", "is neither polygons nor run lengths", remedy)


def _shape(part: Any, category: str, key: str) -> list[Shape]:
    if isinstance(part, dict):
        mask, corner = _mask(part, key)
        return [Shape(category, None, mask, corner)] if mask.any() else []
    try:
        numbers = np.array(part, dtype=float)
    except (ValueError, TypeError, OverflowError):
        numbers = np.zeros(0)
    if numbers.ndim != 1 or len(numbers) < 6 or len(numbers) % 2 or not (np.abs(numbers) < LARGEST_PIXEL).all():
        problem = f"is not a list of at least three corners below {LARGEST_PIXEL:g} pixels"
        raise CaseError(f"{key}.segmentation", problem, "write [x1, y1, x2, y2, x3, y3]")
    corners = numbers.reshape(-1, 2)
    return [Shape(category, corners[np.any(corners != np.roll(corners, 1, axis=0), axis=1)])]


def _mask(part: dict[str, Any], key: str) -> tuple[BoolArray, tuple[int, int]]:
    """Return a mask from its run lengths, cut to its columns, and the column and row of its first pixel."""
    size, counts = part.get("size"), part.get("counts")
    wrong = CaseError(f"{key}.segmentation", "its run lengths do not fill its size", "annotate polygons instead")
    if not isinstance(size, list) or len(size) != 2 or not all(type(n) is int and n > 0 for n in size):
        raise wrong
    height, width = size
    if height * width > LARGEST_PICTURE:
        raise CaseError(f"{key}.segmentation", f"has more than {LARGEST_PICTURE} pixels", "reduce the image")
    runs = np.array(_expanded(counts) if isinstance(counts, str) else counts, dtype=object)
    if runs.ndim != 1 or not all(type(n) is int and 0 <= n <= height * width for n in runs):
        raise wrong
    ends = np.cumsum(runs.astype(np.int64))
    if not len(ends) or ends[-1] != height * width:
        raise wrong
    first, last = ends[0:-1:2], ends[1::2]
    if not len(first):
        return np.zeros((1, 1), bool), (0, 0)
    left, right = int(first[0]) // height, -(-int(last[-1]) // height)
    change = np.zeros((right - left) * height + 1, np.int8)
    np.add.at(change, first - left * height, 1)
    np.add.at(change, last - left * height, -1)
    return (np.cumsum(change[:-1]) > 0).reshape(-1, height).T, (left, 0)


def _expanded(text: str) -> list[int]:
    """Return run lengths from their compressed form: 5 bits a letter from "0" on, the sixth says that more follow, the
    fifth of the last is the sign; from the fourth run on the difference to the run two before (rleFrString of the COCO
    API)."""
    runs: list[int] = []
    value = shift = 0
    for letter in text:
        code = ord(letter) - 48
        value |= (code & 31) << shift
        shift += 5
        if code & 32 and shift <= 60:
            continue
        value -= (1 << shift) if code & 16 else 0
        runs.append(value + (runs[-2] if len(runs) > 2 else 0))
        value = shift = 0
    return runs


def _drawing(shapes: list[Shape], remarks: list[str], layers: Layers, settings: CocoSettings) -> Drawing:
    on, left_out = _by_role(shapes, layers)
    smallest = (settings.smallest / settings.scale) ** 2
    stones = on["blocks"]
    if settings.mortar or any(shape.mask is not None for shape in stones):
        drawing, low, category = _filled(stones, settings, smallest)
        outlined, said = list(drawing.stones), list(drawing.remarks)
    else:
        polygons, said = _polygons(stones, smallest)
        corners = np.vstack([outline for _, outline in polygons])
        low = np.array([corners[:, 0].min(), corners[:, 1].max()])
        outlined = [upright(outline, low, settings.scale) for _, outline in polygons]
        category = [name for name, _ in polygons]
        said = [f"{counted(len(outlined), 'stone')} found", *said]
    rest = {
        role: tuple(upright(outline, low, settings.scale) for _, outline in _polygons(on[role], smallest)[0])
        for role in ("supports", "openings")
        if on[role]
    }
    materials = tuple(category) if len(set(category)) > 1 else ()
    remarks = [*said, *remarks, *left_out]
    return Drawing(tuple(outlined), rest.get("supports", ()), rest.get("openings", ()), tuple(remarks), materials)


def _by_role(shapes: list[Shape], layers: Layers) -> tuple[dict[str, list[Shape]], list[str]]:
    """Return the shapes by role; where no category has the blocks' usual name, all others are blocks."""
    on: dict[str, list[Shape]] = {"openings": [], "supports": [], "blocks": [], "": []}
    for shape in shapes:
        roles = (
            role for role in ("openings", "supports", "blocks") if is_chosen(shape.category, getattr(layers, role))
        )
        on[next(roles, "")].append(shape)
    if layers.blocks == Layers().blocks and not on["blocks"]:
        on["blocks"], on[""] = on[""], []
    if not on["blocks"]:
        names = ", ".join(sorted({shape.category for shape in shapes})[:20]) or "none with annotations"
        raise CaseError("blocks", f"no annotation has a category {layers.blocks!r}", f"categories here: {names}")
    names = ", ".join(sorted({shape.category for shape in on[""]})[:20])
    return on, [f"{len(on[''])} annotations of other categories left out: {names}"] if on[""] else []


def _polygons(shapes: list[Shape], smallest: float) -> tuple[list[tuple[str, FloatArray]], list[str]]:
    """Return category and outline (n, 2) in pixels of each shape of at least `smallest` pixels, and remarks."""
    outlines, repaired, dirt = [], 0, 0
    for shape in shapes:
        for outline in [shape.outline] if shape.outline is not None else _traced(shape, smallest):
            polygon = shapely.Polygon(outline) if len(outline) > 2 else shapely.Polygon()
            if not polygon.is_valid:
                pieces = shapely.get_parts(shapely.make_valid(polygon, method="structure", keep_collapsed=False))
                polygon = max(pieces, key=lambda piece: piece.area, default=shapely.Polygon())
                repaired += 1
            if polygon.area < smallest:
                dirt += 1
            else:
                outlines.append((shape.category, shapely.get_coordinates(polygon.exterior)[:-1]))
    if not outlines:
        raise CaseError("annotations", "none is as large as a stone", "see --scale and --smallest")
    cross = "1 outline crosses itself, its" if repaired == 1 else f"{repaired} outlines cross themselves, their"
    remarks = [f"WARNING: {cross} largest part is kept"] if repaired else []
    left_out = f"{counted(dirt, 'annotation')} smaller than the smallest stone left out"
    return outlines, remarks + ([left_out] if dirt else [])


def _traced(shape: Shape, smallest: float) -> list[FloatArray]:
    """Return the outlines of a mask."""
    assert shape.mask is not None
    number, _ = large_patches(shape.mask, smallest)
    return [outline + shape.corner for outline in outlines(number)[1]] if number.any() else []


def _filled(shapes: list[Shape], settings: CocoSettings, smallest: float) -> tuple[Drawing, IntArray, list[str]]:
    """Return the shapes filled into a label image, small ones above large ones, and read from it; also the corner
    (x, y) of its stones in pixels, and the category of each."""
    masks = [patch for shape in shapes for patch in _masks(shape, smallest)]
    if not masks:
        raise CaseError("annotations", "none is as large as a stone", "see --scale and --smallest")
    masks.sort(key=lambda each: -int(np.count_nonzero(each[1])))
    first = np.array([corner for _, _, corner in masks])
    beyond = first + np.array([mask.shape[::-1] for _, mask, _ in masks])
    origin, size = first.min(axis=0), beyond.max(axis=0) - first.min(axis=0)
    if np.prod(size) > LARGEST_PICTURE:
        raise CaseError("annotations", f"reach over more than {LARGEST_PICTURE} pixels", "reduce the image")
    number: IntArray = np.zeros(size[::-1], np.int32)
    for k, (_, mask, (x, y)) in enumerate(masks, start=1):
        number[y - origin[1] :, x - origin[0] :][: mask.shape[0], : mask.shape[1]][mask] = k
    drawing, stones = drawing_of_numbers(number, settings.scale, settings.mortar)
    return drawing, lower_left(number) + origin, [masks[stone - 1][0] for stone in stones]


def _masks(shape: Shape, smallest: float) -> list[tuple[str, BoolArray, tuple[int, int]]]:
    """Return category, mask and place (column, row) of the patches of a shape that are not too small."""
    from skimage.draw import polygon2mask

    mask, (left, top) = shape.mask, shape.corner
    if shape.outline is not None:
        low = np.floor(shape.outline.min(axis=0)).astype(int)
        high = np.maximum(np.ceil(shape.outline.max(axis=0)).astype(int), low + 1)  # on one line: a row of pixels
        if np.prod(high - low) > LARGEST_PICTURE:
            raise CaseError("annotations", f"one has more than {LARGEST_PICTURE} pixels", "reduce the image")
        mask, (left, top) = polygon2mask(tuple(high - low)[::-1], (shape.outline - low - 0.5)[:, ::-1]), tuple(low)
    assert mask is not None
    number, _ = large_patches(mask, smallest)
    patches: list[tuple[slice, slice]] = ndimage.find_objects(number)
    return [
        (shape.category, number[rows, columns] == k, (left + columns.start, top + rows.start))
        for k, (rows, columns) in enumerate(patches, start=1)
    ]

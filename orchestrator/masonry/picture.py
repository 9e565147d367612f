"""A black-and-white picture of the stones, with a scale -> Drawing (scikit-image).

Each connected patch of stone colour is a stone. Mortar between stones is closed: stones grow until they touch, nowhere
beyond what closes joints narrower than the given width. Outlines follow the edges between pixels and are simplified
together, so that neighbours keep one common edge.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
import shapely
from annotated_types import Ge, Gt
from scipy import ndimage

from orchestrator.errors import CaseError
from orchestrator.masonry.drawing import Drawing
from orchestrator.masonry.readers import refuse_what_is_no_file
from orchestrator.masonry.wall import FloatArray, IntArray
from orchestrator.units import Unit

LARGEST_FILE = 1_000_000_000
"""bytes"""
LARGEST_PICTURE = 25_000_000
"""pixels"""
STRAIGHT = 1.5
"""pixels: how far the steps of a straight edge may lie from it (Douglas and Peucker 1973). Steps that are left
interlock: stones stand that would slide out"""


@dataclass(frozen=True, slots=True)
class PictureSettings:
    """What turns pixels into stones."""

    scale: Annotated[float, Unit("m"), Gt(0)]
    """side of a pixel"""
    mortar: Annotated[float, Unit("m"), Ge(0)] = 0.02
    """widest joint between stones that is closed"""
    stones: Literal["black", "white"] = "black"
    """colour of the stones"""
    smallest: Annotated[float, Unit("m"), Gt(0)] = 0.02
    """patches of less area than a square of this side are dirt"""


def read_picture(path: Path, settings: PictureSettings) -> Drawing:
    """Return the stones in the picture `path` in m, y upwards, the lower left corner of its stones at (0, 0).

    Raises CaseError naming file and remedy.
    """
    try:
        return drawing_of(_pixels(path) == (settings.stones == "white"), settings)
    except CaseError as error:
        raise error.in_file(str(path)) from None


def _pixels(path: Path) -> npt.NDArray[np.bool_]:
    """Return which pixels (rows from the top, columns) are white."""
    from PIL import Image

    try:
        refuse_what_is_no_file(path, LARGEST_FILE, "reduce it; a joint needs about 3 pixels")
        with Image.open(path) as image:
            if image.width * image.height > LARGEST_PICTURE:
                raise CaseError(
                    "", f"has more than {LARGEST_PICTURE} pixels", "reduce it; a joint needs about 3 pixels"
                )
            canvas = Image.new("RGBA", image.size, "white")
            canvas.alpha_composite(image.convert("RGBA"))
            return np.asarray(canvas.convert("L")) >= 128
    except FileNotFoundError:
        raise CaseError("", "no such file", "give the path of a picture") from None
    except CaseError:
        raise
    except Exception as error:  # damaged pictures fail with whatever the decoder of their format raises
        problem = f"cannot be read as a picture ({type(error).__name__}: {str(error)[:100]})"
        raise CaseError("", problem, "save it as PNG") from None


def drawing_of(is_stone: npt.NDArray[np.bool_], settings: PictureSettings) -> Drawing:
    """Return the stones among the pixels `is_stone` (rows from the top, columns)."""
    from skimage.measure import label

    patches: IntArray = label(np.pad(is_stone, 1), connectivity=1)
    area = np.bincount(patches.ravel()) * settings.scale**2
    stones = np.flatnonzero(area >= settings.smallest**2)[1 if area[0] >= settings.smallest**2 else 0 :]
    if not len(stones):
        raise CaseError("", f"no {settings.stones} stones found", "see --scale and --stones black|white")
    dirt = len(area) - 1 - len(stones)
    number = np.zeros(len(area), np.int64)
    number[stones] = np.arange(1, len(stones) + 1)
    outlines = _outlines(_grown(number[patches], settings.mortar / settings.scale))
    corners = np.vstack([outline for outline, _ in outlines])
    low = np.array([corners[:, 0].min(), corners[:, 1].max()])
    turned = tuple((outline - low) * settings.scale * [1.0, -1.0] for outline, _ in outlines)
    remarks = [f"pixels of {1e3 * settings.scale:.4g} mm: outlines are no better than that"]
    remarks += [f"{dirt} patches smaller than {1e3 * settings.smallest:g} mm squared left out"] if dirt else []
    holes = sum(count for _, count in outlines)
    remarks += [f"WARNING: {holes} holes in stones filled"] if holes else []
    return Drawing(turned, remarks=tuple(remarks))


def _grown(number: IntArray, mortar: float) -> IntArray:
    """Return the stones' numbers (rows, columns) with joints up to `mortar` pixels wide shared out between them."""
    from skimage.segmentation import expand_labels

    width = int(np.ceil(mortar))
    if width == 0:
        return number
    padded = np.pad(number, width + 1)
    closed = ndimage.grey_closing((padded > 0).astype(np.uint8), size=(width + 1, width + 1)) > 0
    return np.where(closed, expand_labels(padded, 2 * width), 0)


def _outlines(number: IntArray) -> list[tuple[FloatArray, int]]:
    """Return for each stone its simplified outline (n, 2) in pixels and how many holes it had."""
    y, x = np.nonzero(number[:, 1:] != number[:, :-1])
    upright = np.stack([np.column_stack([x + 1, y]), np.column_stack([x + 1, y + 1])], axis=1)
    y, x = np.nonzero(number[1:] != number[:-1])
    level = np.stack([np.column_stack([x, y + 1]), np.column_stack([x + 1, y + 1])], axis=1)
    edges = shapely.linestrings(np.concatenate([upright, level]).astype(float))
    common = shapely.get_parts(shapely.line_merge(shapely.union_all(edges)))  # from corner to corner of three stones
    faces = np.array(shapely.get_parts(shapely.polygonize(shapely.simplify(common, STRAIGHT))))
    inside = shapely.get_coordinates(shapely.point_on_surface(faces)).astype(int)
    owner = number[inside[:, 1], inside[:, 0]]
    largest: dict[int, shapely.Polygon] = {}  # a stone in two pieces that touch at a corner only is its larger piece
    for face, stone in zip(faces, owner, strict=True):
        if stone and face.area > getattr(largest.get(stone), "area", 0.0):
            largest[stone] = face
    stones = [largest[stone] for stone in sorted(largest)]
    return [(shapely.get_coordinates(stone.exterior)[:-1], len(stone.interiors)) for stone in stones]

"""A picture file -> the colour and the lightness of its pixels (Pillow)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from orchestrator.basis.arrays import BoolArray, IntArray
from orchestrator.basis.errors import CaseError
from orchestrator.masonry.sources.block_files import refuse_what_is_no_file

LARGEST_FILE = 1_000_000_000
"""bytes"""
LARGEST_PICTURE = 25_000_000
"""pixels"""
SMALLER = "reduce it; a joint needs about 3 pixels"
"""remedy for a picture that is too large"""


@dataclass(frozen=True, eq=False, slots=True)
class Pixels:
    """A picture (rows from the top, columns): each pixel's colour 0xRRGGBB or number, and its lightness 0 to 255."""

    code: IntArray
    lightness: npt.NDArray[np.uint8]
    clear: BoolArray | None = None
    """transparent pixels, none if there are none"""
    numbers: bool = False
    """the code is a number, not a colour"""
    lossy: bool = False
    """saved by a format that blurs colours"""
    remarks: tuple[str, ...] = ()


def read_pixels(path: Path) -> Pixels:
    """Return the pixels of the first page of the picture `path`. Raises CaseError."""
    from PIL import Image

    try:
        refuse_what_is_no_file(path, LARGEST_FILE, SMALLER)
        with Image.open(path) as image:
            if image.width * image.height > LARGEST_PICTURE:
                raise CaseError("", f"has more than {LARGEST_PICTURE} pixels", SMALLER)
            return _decoded(*_turned(image))
    except FileNotFoundError:
        raise CaseError("", "no such file", "give the path of a picture") from None
    except CaseError:
        raise
    except Image.DecompressionBombError:
        raise CaseError("", f"has more than {LARGEST_PICTURE} pixels", SMALLER) from None
    except Exception as error:  # damaged pictures fail with whatever the decoder of their format raises
        problem = f"cannot be read as a picture ({type(error).__name__}: {str(error)[:100]})"
        raise CaseError("", problem, "save it as PNG") from None


def _turned(image: Any) -> tuple[Any, str, tuple[str, ...]]:
    """Return an opened picture as its EXIF orientation says it stands, its format, and remarks."""
    from PIL import ExifTags, ImageOps

    pages = getattr(image, "n_frames", 1)
    remarks = (f"WARNING: {pages} pages, the first is read",) if pages > 1 else ()
    if image.getexif().get(ExifTags.Base.Orientation, 1) == 1:
        return image, image.format, remarks
    return ImageOps.exif_transpose(image), image.format, (*remarks, "turned or mirrored as its EXIF orientation says")


def _decoded(image: Any, kind: str, remarks: tuple[str, ...]) -> Pixels:
    """Return the pixels of an opened picture; kind: its format."""
    from PIL import Image

    if image.mode == "F" or image.mode.startswith("I"):
        return _of_numbers(np.asarray(image), remarks)
    indices = np.asarray(image) if image.mode == "P" else None
    coloured = image.convert("RGBA")
    clear = np.asarray(coloured.getchannel("A")) < 128
    canvas = Image.new("RGBA", image.size, "white")
    canvas.alpha_composite(coloured)
    red, green, blue = (np.asarray(canvas.getchannel(band)).astype(np.int32) for band in "RGB")
    code = (red << 16) | (green << 8) | blue
    lightness = np.asarray(canvas.convert("L"))
    if indices is not None and _same_colours(indices, code):
        return Pixels(indices.astype(np.int32), lightness, None, True, False, remarks)
    lossy = kind in ("JPEG", "MPO", "JPEG2000", "WEBP")
    return Pixels(code, lightness, clear if clear.any() else None, False, lossy, remarks)


def _of_numbers(values: npt.NDArray[Any], remarks: tuple[str, ...]) -> Pixels:
    """Return a picture of 16 or 32 bits: a label image, or black and white up to its largest number."""
    if not np.isfinite(values).all() or (values != np.rint(values)).any() or np.abs(values).max(initial=0) >= 2**31:
        raise CaseError("", "its pixels are not whole numbers", "save it with 8 or 16 bits a pixel")
    code = values.astype(np.int64)
    low, high = int(code.min()), int(code.max())
    return Pixels(code, ((code - low) * 255 // max(high - low, 1)).astype(np.uint8), None, True, False, remarks)


def _same_colours(indices: npt.NDArray[Any], code: IntArray) -> bool:
    """Return whether a palette shows different indices in the same colour."""
    shown = np.full(256, -1, np.int64)
    shown[indices.ravel()] = code.ravel()
    used = shown[shown >= 0]
    return len(np.unique(used)) < len(used)

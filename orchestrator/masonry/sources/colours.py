"""Pictures in which every stone has its colour or number (label images, masks) -> the stone of each pixel.

Whether a picture is one is told by its patches of one colour: of several colours, hardly more patches than colours, and
no transitions between them. Black, white and transparent patches, or those of number 0, are mortar and void.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import BoolArray, IntArray
from orchestrator.basis.errors import CaseError
from orchestrator.masonry.sources.pixels import Pixels
from orchestrator.masonry.sources.segmentation import large

BLACK = 0x000000
"""0xRRGGBB"""
WHITE = 0xFFFFFF
"""0xRRGGBB"""
CLEAR = -(2**40)
"""stands for a transparent pixel: no colour and no label is as low"""
NEAR_GREY = 32
"""of 255: colours this near to black or white are meant as such, and greys if they are this near to grey"""
SHARP = 0.98
"""share of the pixels that have the colour of some patch, above which colours have no transitions between them"""
NEGLIGIBLE_COLOUR = 0.05
"""share of the picture in patches of a colour that makes no difference"""
BLENDED = 0.02
"""pixels of a stone over those of a mean one, large ones counting more, below which it may be of no stone's colour"""
SINGLE = 2.0
"""patches a colour up to which every stone may have a colour of its own"""


@dataclass(frozen=True, eq=False, slots=True)
class Patches:
    """Connected pixels of one colour: the patch `of` each pixel (rows, columns), from 0; each patch's colour and area
    in pixels (n,), and whether it is a stone (n,)."""

    of: IntArray
    code: IntArray
    area: IntArray
    is_stone: BoolArray


def are_labels(pixels: Pixels, smallest: float) -> bool:
    """Return whether every stone has its colour, rather than all being black; CaseError in doubt.

    smallest: pixels of the smallest stone.
    """
    if pixels.lossy:
        if np.mean(_saturation(pixels.code) > 2 * NEAR_GREY) > 4 * NEGLIGIBLE_COLOUR:
            raise _doubt()
        return False
    void = _void(pixels, "")
    patches = _patches(pixels, void, smallest)
    colours, count = np.unique(patches.code[patches.is_stone], return_counts=True)
    if len(colours) < 2:
        return False
    single = count.sum() <= SINGLE * len(colours)
    shade = _shade(pixels, patches.code)
    black, white, between = (
        patches.area[shade == end].sum() > NEGLIGIBLE_COLOUR * patches.area.sum() for end in (-1, 1, 0)
    )
    if black and white and not between:
        if single and len(colours) > 2:
            raise _doubt()
        return False
    sharp = patches.area[np.isin(patches.code, np.append(colours, void))].sum() >= SHARP * patches.area.sum()
    if sharp and single:
        return True
    grey = not pixels.numbers and not (_saturation(patches.code[patches.is_stone]) > NEAR_GREY).any()
    if not sharp and (
        grey or patches.area[patches.is_stone & (shade == 0)].sum() <= NEGLIGIBLE_COLOUR * patches.area.sum()
    ):
        return False
    raise _doubt()


def _doubt() -> CaseError:
    problem = "it cannot be told whether the stones are black, or whether every stone has its colour"
    return CaseError("--stones", problem, "say so, with --stones black, white or colours")


def stones_by_colour(pixels: Pixels, smallest: float, background: str) -> tuple[IntArray, int, list[str]]:
    """Return the number of the stone (rows, columns; 0: none) of each pixel, how many patches have fewer than
    `smallest` pixels, and remarks.

    background: colours of mortar and void, separated by commas, or "none"; "": transparent, else black or white, or 0.
    """
    void = _void(pixels, background)
    if set(void) == {BLACK, WHITE} and not background:
        problem = "black and white both occur, and one or both are mortar and void"
        raise CaseError("--background", problem, 'say which, as in "#000000" or "#000000, #ffffff"')
    patches = _patches(pixels, void, smallest)
    number, dirt = large(
        np.where(np.isin(patches.code, void), 0, np.arange(1, len(patches.code) + 1))[patches.of], smallest
    )
    if not patches.is_stone.any():
        raise CaseError("", "no coloured stones found", "see --scale, --background and --smallest")
    remarks = [f"one colour a stone; mortar and void: {_words(void, pixels)}"]
    return number, dirt, remarks + _said_blended(patches) + _said_twice(patches.code[patches.is_stone])


def _said_blended(patches: Patches) -> list[str]:
    """Return a warning of a picture most of whose stones are far smaller than the others, or none."""
    area = patches.area[patches.is_stone].astype(float)
    small = int(np.sum(area < BLENDED * (area @ area) / area.sum()))
    if small <= 0.5 * len(area):
        return []
    cause = "are colours blended at the edges, as in a picture that was resized or smoothed?"
    return [f"WARNING: {small} of {len(area)} stones have less than 1/50 of the others' pixels: {cause}"]


def _patches(pixels: Pixels, void: list[int], smallest: float) -> Patches:
    from skimage.measure import label

    shown = pixels.code if pixels.clear is None else np.where(pixels.clear, CLEAR, pixels.code.astype(np.int64))
    of: IntArray = label(shown, connectivity=1, background=CLEAR - 1) - 1
    code = np.zeros(int(of.max()) + 1, np.int64)
    code[of.ravel()] = shown.ravel()
    area = np.bincount(of.ravel())
    return Patches(of, code, area, (area >= smallest) & ~np.isin(code, void))


def _bands(code: IntArray) -> IntArray:
    return np.stack([code >> 16 & 255, code >> 8 & 255, code & 255])


def _saturation(code: IntArray) -> IntArray:
    """Return how far colours are from grey, 0 to 255."""
    saturation: IntArray = np.ptp(_bands(code), axis=0)
    return saturation


def _shade(pixels: Pixels, code: IntArray) -> IntArray:
    """Return for each colour -1 if it is nearly black, 1 if nearly white or clear, else 0, as numbers are."""
    bands = _bands(code)
    shade = 1 * (bands.min(axis=0) >= 255 - NEAR_GREY) - (bands.max(axis=0) <= NEAR_GREY)
    return np.where(code == CLEAR, 1, 0 if pixels.numbers else shade)


def _void(pixels: Pixels, background: str) -> list[int]:
    """Return the codes of mortar and void, as given or as usual."""
    clear = [CLEAR] if pixels.clear is not None else []
    if background == "none":
        return clear
    if background:
        return clear + [_code(text.strip(), pixels.numbers) for text in background.split(",")]
    usual = [0] if pixels.numbers else [BLACK, WHITE]
    return clear or [code for code in usual if (pixels.code == code).any()]


def _code(text: str, number: bool) -> int:
    """Return the code of a background as written."""
    if number and re.fullmatch(r"-?\d{1,9}(\.0)?", text):
        return int(float(text))
    if not number and re.fullmatch(r"#[0-9a-fA-F]{6}", text):
        return int(text[1:], 16)
    right = "a number, as in 0" if number else 'a colour, as in "#000000"'
    raise CaseError("--background", f"{text[:40]!r} is no {'number' if number else 'colour'}", f"give {right}, or none")


def _said_twice(code: IntArray) -> list[str]:
    """Return a remark on colours that occur in several patches."""
    count = np.unique(code, return_counts=True)[1]
    several = count[count > 1]
    what = f"{len(several)} colour{'s' * (len(several) > 1)} in {several.sum()} separate patches"
    return [f"{what}: each patch is a stone"] if len(several) else []


def _words(void: list[int], pixels: Pixels) -> str:
    words = ["transparent" if code == CLEAR else str(code) if pixels.numbers else f"#{code:06x}" for code in void]
    return ", ".join(words) or "none"

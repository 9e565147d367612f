"""Row notation (text): block widths per course, from the bottom -> Wall.

    # lengths in this unit; a number with its own unit may be written too
    unit = mm
    thickness = 100
    unit_weight = 25 kN/m3
    friction = 0.65
    support = 200                 # the ground reaches this far beyond the wall on both sides
    175: 200 400 400 400 400 200  # height of the course, then widths from the left
    175: 400 400 -400 400 400     # negative: opening
    175: 200 1600/timber 200      # a block of another material

Courses stand on each other; each begins at x = 0, the lowest at y = 0.
"""

from __future__ import annotations

import difflib
import re
from pathlib import Path

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.errors import CaseError, naming
from orchestrator.basis.units import Unit
from orchestrator.masonry.sources.block_files import refuse_what_is_no_file, unreadable
from orchestrator.masonry.wall import LARGEST_COUNT, Block, Wall

UNITS = {"thickness": "m", "support": "m", "unit_weight": "N/m3", "friction": ""}
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", re.ASCII)
Course = tuple[float, list[tuple[float, str]]]
"""height in m; width in m and material of each block, a negative width for an opening"""
LARGEST_FILE = 10_000_000
"""bytes; a course of twenty blocks takes about a hundred"""


def read_rows(path: Path) -> Wall:
    """Return the wall in the row notation file `path`. Raises CaseError naming file, line and remedy."""
    with naming(path):
        return parse_rows(_text(path), path.stem)


def _text(path: Path) -> str:
    try:
        refuse_what_is_no_file(path, LARGEST_FILE, "is this row notation?")
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise CaseError("", "no such file", "give the path of a text file in row notation") from None
    except (OSError, UnicodeDecodeError) as error:
        raise unreadable(error, "give a text file in row notation") from None


def parse_rows(text: str, name: str) -> Wall:
    """Return the wall that `text` describes (see above); blocks are numbered from 1, the support is 0."""
    unit, header, courses = "", dict[str, float](), list[Course]()
    for number, line in enumerate(text.split("\n"), 1):
        words, place = line.partition("#")[0].strip(), f"line {number}"
        if "=" in words:
            key, _, value = (part.strip() for part in words.partition("="))
            if key in header or (key == "unit" and unit):
                raise CaseError(f"{place}: {key}", "is given twice", "keep one of them")
            if key == "unit":
                unit = _length_unit(value, place)
            else:
                header[key] = _setting(key, value, unit, place)
        elif words:
            courses.append(_course(words, unit, place))
    for key in UNITS:
        if key not in header:
            raise CaseError(key, "is missing", f"write it on a line of its own, as in {key} = ...")
    if not courses:
        raise CaseError("courses", "there are none", "write one line a course: height: width width ...")
    return _stacked(name, courses, header)


def uneven_courses(wall: Wall) -> list[str]:
    """Return a remark on courses of a wall in row notation that end before the longest, numbered from the bottom."""
    ends: dict[float, float] = {}
    for block in wall.blocks:
        if not block.fixed:
            bottom = float(block.polygon[:, 1].min())
            ends[bottom] = max(ends.get(bottom, 0.0), float(block.polygon[:, 0].max()))
    longest = max(ends.values())
    short = [(n, end) for n, (_, end) in enumerate(sorted(ends.items()), 1) if end < longest * (1.0 - 1e-9)]
    if not short:
        return []
    first, end = short[0]
    others = f" and {len(short) - 1} more" if len(short) > 1 else ""
    return [
        f"course {first} from the bottom{others} ends at {end:g} m, the longest at {longest:g} m: is a stone missing?"
    ]


def _stacked(name: str, courses: list[Course], header: dict[str, float]) -> Wall:
    polygons: list[FloatArray] = []
    materials: list[str] = []
    level = 0.0
    for height, stones in courses:
        ends = np.concatenate([[0.0], np.cumsum([abs(width) for width, _ in stones])])
        for left, right, (width, material) in zip(ends[:-1], ends[1:], stones, strict=True):
            if width > 0:
                polygons.append(_rectangle(left, right, level, level + height))
                materials.append(material)
        if len(polygons) > LARGEST_COUNT:
            raise CaseError("courses", f"more than {LARGEST_COUNT} blocks", "divide the wall")
        level += height
    if not polygons:
        raise CaseError("courses", "they hold openings only", "write the width of a block without a minus sign")
    length, beyond = max(sum(abs(width) for width, _ in stones) for _, stones in courses), header["support"]
    ground = _rectangle(-beyond, length + beyond, -courses[0][0], 0.0)
    of = zip([ground, *polygons], ["", *materials], strict=True)
    blocks = tuple(Block(n, p, n == 0, header["unit_weight"], material) for n, (p, material) in enumerate(of))
    return Wall(name, blocks, header["thickness"], header["friction"])


def _course(words: str, unit: str, place: str) -> Course:
    first, *rest = words.replace(":", " ", 1).split() or ["0"]
    pairs = [(first, "", ""), *(word.partition("/") for word in rest)]
    numbers = [_number(number, place) for number, _, _ in pairs]
    if len(numbers) < 2 or numbers[0] <= 0 or 0.0 in numbers:
        wrong = [
            pair[0] for pair, number in zip(pairs, numbers, strict=True) if number == 0.0 or number == numbers[0] < 0
        ]
        problem = f"is not a course{f': {wrong[0][:40]!r} is no size' if wrong else ''}"
        raise CaseError(place, problem, "write its height above 0, then widths: 175: 400 -800 400")
    for number, (_, slash, material) in zip(numbers, pairs, strict=True):
        if slash and (not material or number < 0):
            remedy = "write it behind the width of a block, as in 1600/timber"
            raise CaseError(place, f"{material[:40]!r} is no block's material", remedy)
    height, *widths = (number * _factor(unit, place) for number in numbers)
    return height, list(zip(widths, [material for _, _, material in pairs[1:]], strict=True))


def _setting(key: str, value: str, unit: str, place: str) -> float:
    if key not in UNITS:
        near = difflib.get_close_matches(key, [*UNITS, "unit"], 1)
        known = f"did you mean {near[0]}?" if near else f"known keys are unit, {', '.join(UNITS)}"
        raise CaseError(place, f"{key[:40]!r} is not a known key", known)
    if not UNITS[key] or (UNITS[key] == "m" and NUMBER.fullmatch(value)):
        number = _number(value, place) * (_factor(unit, place) if UNITS[key] else 1.0)
    else:
        try:
            number = Unit(UNITS[key]).parse(value)
        except ValueError as error:
            problem, _, remedy = str(error).partition("; ")
            raise CaseError(f"{place}: {key}", problem, remedy) from None
    if not 0 < number < 1e12:
        raise CaseError(f"{place}: {key}", f"{value[:40]} is not a positive number", "give a value above 0")
    return number


def _number(word: str, place: str) -> float:
    if not NUMBER.fullmatch(word) or not abs(float(word)) < 1e12:
        raise CaseError(
            place, f"{word[:40]!r} is not a number", "separate numbers by spaces, with a point for decimals"
        )
    return float(word)


def _length_unit(symbol: str, place: str) -> str:
    try:
        Unit("m").factor(symbol)
    except ValueError as error:
        problem, _, remedy = str(error).partition("; ")
        raise CaseError(f"{place}: unit", problem, remedy) from None
    return symbol


def _factor(unit: str, place: str) -> float:
    if not unit:
        raise CaseError(place, "a length before its unit is known", "begin the file with a line such as unit = mm")
    return Unit("m").factor(unit)


def _rectangle(left: float, right: float, bottom: float, top: float) -> FloatArray:
    return read_only([[left, bottom], [right, bottom], [right, top], [left, top]])

"""Shapes of an SVG drawing -> chains of lines and Bezier curves, in the shape's own user units (SVG 1.1)."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from xml.etree.ElementTree import Element

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import CaseError

NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
COMMAND = re.compile(rf"([MmZzLlHhVvCcSsQqTtAa])|({NUMBER.pattern})|[\s,]+|(.)", re.DOTALL)
ARITY = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
LARGEST_NUMBER = 1e15
"""user units"""
Curve = FloatArray
"""control points (2, 3 or 4, 2): a line, a quadratic or a cubic Bezier curve"""


def numbers(text: str, key: str) -> list[float]:
    """Return the numbers in a list separated by white space and commas."""
    if NUMBER.sub("", text).strip(" ,\t\r\n"):
        raise CaseError(key, f"{text[:40]!r} is not a list of numbers in user units", "save it as plain SVG")
    values = [float(number) for number in NUMBER.findall(text)]
    _refuse_large(values, key)
    return values


def _refuse_large(values: list[float], key: str) -> None:
    if not all(abs(number) < LARGEST_NUMBER for number in values):
        raise CaseError(key, f"a number is not below {LARGEST_NUMBER:g}", "correct the drawing")


def transform(text: str) -> FloatArray:
    """Return the matrix (3, 3) of a list of transformations."""
    matrix = np.eye(3)
    for name, inner in re.findall(r"([a-zA-Z]+)\s*\(([^)]*)\)", text):
        matrix = matrix @ _single(name, numbers(inner, "transform"))
    if re.sub(r"[a-zA-Z]+\s*\([^)]*\)", "", text).strip(" ,\t\r\n"):
        raise CaseError("transform", f"{text[:40]!r} cannot be read", "save it as plain SVG")
    return matrix


def nested_view(element: Element) -> FloatArray:
    """Return the matrix (3, 3) from the user units in an svg element within another to those around it (section 7.11).

    Raises CaseError for one whose size is not in user units where its viewBox needs it.
    """
    place = place_of(element, "nested svg")
    x, y = (_in_user_units(element.get(key, "0"), place) for key in ("x", "y"))
    matrix = np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])
    box = numbers(element.get("viewBox", ""), f"{place}: viewBox")
    if not box:
        return matrix
    width, height = (_in_user_units(element.get(key, ""), place) for key in ("width", "height"))
    if len(box) != 4 or not min(box[2], box[3], width, height) > 0:
        raise CaseError(place, "its size or its viewBox is not above 0", "ungroup it, or save as plain SVG")
    size, room = np.array(box[2:]), np.array([width, height])
    align, _, how = element.get("preserveAspectRatio", "").strip().partition(" ")
    scale = room / size
    if align != "none":
        scale[:] = scale.max() if how.strip() == "slice" else scale.min()
    part = [0.0 if f"{axis}Min" in align else 1.0 if f"{axis}Max" in align else 0.5 for axis in ("x", "Y")]
    offset = part * (room - scale * size) - scale * box[:2]
    return matrix @ np.array([[scale[0], 0.0, offset[0]], [0.0, scale[1], offset[1]], [0.0, 0.0, 1.0]])


def _in_user_units(text: str, place: str) -> float:
    if not NUMBER.fullmatch(text.strip().removesuffix("px")):
        problem = f"its place or size {text[:20]!r} is not in user units"
        raise CaseError(place, problem, "ungroup it, or save as plain SVG")
    return float(text.strip().removesuffix("px"))


def _single(name: str, values: list[float]) -> FloatArray:
    counts = {"matrix": (6,), "translate": (1, 2), "scale": (1, 2), "rotate": (1, 3), "skewX": (1,), "skewY": (1,)}
    if len(values) not in counts.get(name, ()):
        raise CaseError("transform", f"{name[:20]!r} with {len(values)} numbers cannot be read", "save it as plain SVG")
    matrix = np.eye(3)
    if name == "matrix":
        matrix[:2] = np.reshape(values, (3, 2)).T
    elif name == "translate":
        matrix[:2, 2] = [*values, 0.0][:2]
    elif name == "scale":
        matrix[0, 0], matrix[1, 1] = values[0], values[-1]
    elif name == "rotate":
        c, s = math.cos(math.radians(values[0])), math.sin(math.radians(values[0]))
        matrix[:2, :2] = [[c, -s], [s, c]]
        if len(values) == 3:
            centre = np.array(values[1:])
            matrix[:2, 2] = centre - matrix[:2, :2] @ centre
    else:
        matrix[(0, 1) if name == "skewX" else (1, 0)] = math.tan(math.radians(values[0]))
    return matrix


def subpaths(element: Element, tag: str) -> Iterator[list[Curve]]:
    """Yield the subpaths of a shape, each a chain of curves."""
    try:
        yield from (curves for curves in _shape_paths(element, tag) if curves)
    except (OverflowError, ZeroDivisionError, ValueError):
        raise CaseError(place_of(element, tag), "has numbers that cannot be drawn", "correct the drawing") from None


def place_of(element: Element, tag: str) -> str:
    """Return how an element is named in what is said of it."""
    return f"{tag} {element.get('id', '')[:40]}".strip()


def _shape_paths(element: Element, tag: str) -> list[list[Curve]]:
    place = place_of(element, tag)
    if tag == "path":
        return _path(element.get("d", ""), place)
    if tag in ("polygon", "polyline"):
        points = numbers(element.get("points", ""), place)
        corners = np.array(points[: len(points) // 2 * 2]).reshape(-1, 2)
        closed = np.vstack([corners, corners[:1]]) if tag == "polygon" else corners
        return [_lines(closed)]

    def number(key: str, usual: float = 0.0) -> float:
        values = numbers(element.get(key, "").strip().removesuffix("px"), place)
        return values[0] if values else usual

    if tag == "line":
        return [_lines(np.array([[number("x1"), number("y1")], [number("x2"), number("y2")]]))]
    if tag == "rect":
        x, y, width, height = (number(key) for key in ("x", "y", "width", "height"))
        rx = min(number("rx", number("ry")), width / 2)
        ry = min(number("ry", number("rx")), height / 2)
        if width <= 0 or height <= 0:
            return []
        if rx <= 0 or ry <= 0:
            corners = np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height], [x, y]])
            return [_lines(corners)]
        arc = f"a{rx!r} {ry!r} 0 0 1 "
        d = f"M{x + rx!r} {y!r} h{width - 2 * rx!r} {arc}{rx!r} {ry!r} v{height - 2 * ry!r} {arc}{-rx!r} {ry!r} "
        return _path(d + f"h{2 * rx - width!r} {arc}{-rx!r} {-ry!r} v{2 * ry - height!r} {arc}{rx!r} {-ry!r} z", place)
    if tag in ("circle", "ellipse"):
        rx, ry = (number("r"), number("r")) if tag == "circle" else (number("rx"), number("ry"))
        if rx <= 0 or ry <= 0:
            return []
        x, y = number("cx"), number("cy")
        half = f"a{rx!r} {ry!r} 0 0 1 "
        return _path(f"M{x - rx!r} {y!r} {half}{2 * rx!r} 0 {half}{-2 * rx!r} 0 z", place)
    return []


def _lines(corners: FloatArray) -> list[Curve]:
    """Return the edges between corners (n, 2) that differ."""
    differ = np.any(corners[1:] != corners[:-1], axis=1)
    return list(np.stack([corners[:-1], corners[1:]], axis=1)[differ])


def _path(d: str, place: str) -> list[list[Curve]]:
    """Return the subpaths that path data draw (SVG 1.1, chapter 8)."""
    paths: list[list[Curve]] = [[]]
    point = start = np.zeros(2)
    handle, before = point, ""
    for letter, values in _commands(d, place):
        kind = letter.upper()
        origin = point if letter.islower() else np.zeros(2)
        if kind == "M":
            paths.append([])
            point = start = origin + values
        elif kind == "Z":
            paths[-1] += _lines(np.array([point, start]))
            paths.append([])
            point = start
        elif kind == "A":
            curves = _arc(point, values, origin + values[5:])
            paths[-1] += curves
            point = origin + values[5:]
        else:
            if kind in "HV":
                axis = "HV".index(kind)
                end = point.copy()
                end[axis] = origin[axis] + values[0]
                control = np.array([point, end])
            else:
                control = np.vstack([point, origin + values.reshape(-1, 2)])
            if kind in "ST":
                mirrored = 2 * point - handle if before in ("CS" if kind == "S" else "QT") else point
                control = np.insert(control, 1, mirrored, axis=0)
            if np.any(control != control[0]):
                paths[-1].append(control)
            handle, point = control[-2], control[-1]
        before = kind
    return paths


def _commands(d: str, place: str) -> Iterator[tuple[str, FloatArray]]:
    """Yield each command of path data with its numbers; a repeated one is written out, M goes on as L."""
    letter = ""
    values: list[float] = []
    for command, more in [*_tokens(d, place), ("M", [])]:
        if command:
            yield from _written_out(letter, values, place)
            letter, values = command, []
        values += more


def _tokens(d: str, place: str) -> Iterator[tuple[str, list[float]]]:
    """Yield letters and numbers; the flags of an arc may stand without a space between them."""
    letter, position, count = "", 0, 0
    while position < len(d):
        if letter in "Aa" and letter and count % 7 in (3, 4) and d[position] in "01":
            yield "", [float(d[position])]
            position, count = position + 1, count + 1
            continue
        match = COMMAND.match(d, position)
        assert match is not None
        if match[3]:
            raise CaseError(place, f"path data cannot be read at {d[position : position + 20]!r}", "correct the path")
        if match[1]:
            letter, count = match[1], 0
            yield letter, []
        elif match[2]:
            yield "", [float(match[2])]
            count += 1
        position = match.end()


def _written_out(letter: str, numbers: list[float], place: str) -> Iterator[tuple[str, FloatArray]]:
    arity = ARITY.get(letter.upper(), 0)
    if (arity and (not numbers or len(numbers) % arity)) or (not arity and numbers):
        problem = f"path data have {len(numbers)} numbers after {letter or 'no command'!r}"
        raise CaseError(place, problem, "correct the path")
    _refuse_large(numbers, place)
    if letter in ("Z", "z"):
        yield letter, np.zeros(0)
    for k in range(0, len(numbers), max(arity, 1)):
        yield letter, np.array(numbers[k : k + arity])
        letter = {"M": "L", "m": "l"}.get(letter, letter)


def _arc(start: FloatArray, values: FloatArray, end: FloatArray) -> list[Curve]:
    """Return an elliptical arc as cubic curves of 45 degrees at most (off by 5e-6 of the radius).

    values: rx, ry, rotation in degrees, large, sweep; formulas of SVG 1.1, appendix F.6.
    """
    rx, ry = abs(values[0]), abs(values[1])
    if rx == 0 or ry == 0 or np.array_equal(start, end):
        return _lines(np.array([start, end]))
    c, s = math.cos(math.radians(values[2])), math.sin(math.radians(values[2]))
    turn = np.array([[c, -s], [s, c]])
    x, y = turn.T @ (start - end) / 2
    enlarged = max(1.0, math.hypot(x / rx, y / ry))
    rx, ry = rx * enlarged, ry * enlarged
    u, v = x / rx, y / ry
    off = math.sqrt(max(0.0, 1.0 / (u * u + v * v) - 1.0)) * (-1.0 if bool(values[3]) == bool(values[4]) else 1.0)
    cu, cv = off * v, -off * u
    first, last = math.atan2(v - cv, u - cu), math.atan2(-v - cv, -u - cu)
    sweep = (last - first) % (2 * math.pi) if values[4] else -((first - last) % (2 * math.pi))
    angles = np.linspace(first, first + sweep, max(1, math.ceil(abs(sweep) / (math.pi / 4) - 1e-9)) + 1)
    reach = 4 / 3 * math.tan((angles[1] - angles[0]) / 4)
    on = np.column_stack([np.cos(angles), np.sin(angles)])
    along = np.column_stack([-np.sin(angles), np.cos(angles)]) * reach
    control = np.stack([on[:-1], on[:-1] + along[:-1], on[1:] - along[1:], on[1:]], axis=1)
    curves = (control + [cu, cv]) * [rx, ry] @ turn.T + (start + end) / 2
    curves[0, 0], curves[-1, -1] = start, end
    return list(curves)

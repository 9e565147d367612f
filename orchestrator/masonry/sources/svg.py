"""SVG drawings -> Drawing: closed paths, and lines that close, in the groups of the blocks (standard library only).

Groups are chosen by name as the layers of a DXF drawing are: by the label that Inkscape gives, else by id. The drawing
is in user units; width and height in mm and the viewBox say how long one is, or the scale does. Curves become chords.
Text, images, clones (`use`) and what is hidden are passed over and counted; what is clipped is read whole and counted. https://www.w3.org/TR/SVG11/
"""

from __future__ import annotations

import math
import re
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

import numpy as np
import shapely

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import CaseError, naming
from orchestrator.basis.printed import counted
from orchestrator.masonry.sources.block_files import refuse_what_is_no_file, unreadable
from orchestrator.masonry.sources.closed_outlines import CHORD, LARGEST_CORNERS, ROLES, Layers, drawing_of, is_chosen
from orchestrator.masonry.sources.drawing import Drawing
from orchestrator.masonry.sources.other_layers import said_of_other_layers
from orchestrator.masonry.sources.svg_shapes import NUMBER, Curve, nested_view, numbers, place_of, subpaths, transform
from orchestrator.masonry.sources.svg_styles import is_clipped, is_taken_out, is_unseen, moved_by, rules_in

LARGEST_FILE = 100_000_000
"""bytes"""
LARGEST_STEPS = 1000
"""chords of one curve"""
DEEPEST_NESTING = 100
"""groups within groups, at most"""
LENGTHS = {"mm": 1e-3, "cm": 1e-2, "in": 0.0254, "pt": 0.0254 / 72, "pc": 0.0254 / 6, "q": 0.25e-3, "m": 1.0}
"""m by unit of width and height; px is none: what a pixel measures nobody knows"""
CSS_PIXEL = 0.0254 / 96
"""m: a user unit where width and height are lengths and there is no viewBox (CSS)"""
PASSED_OVER = ("defs", "clipPath", "mask", "symbol", "pattern", "marker", "style", "metadata", "namedview", "title")
UNREAD = ("use", "text", "image", "foreignObject")
INKSCAPE_LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
AUTOMATIC = re.compile(r"(g|svg|layer|group)[-_]?\d+([-_]\d+)*", re.IGNORECASE)
"""ids that nobody gave"""


@dataclass(frozen=True, eq=False, slots=True)
class Drawn:
    """A subpath: names of what it is in, from inside; its curves in user units; `path`: which element it is from."""

    names: tuple[str, ...]
    curves: tuple[Curve, ...]
    path: int


def read_svg(path: Path, layers: Layers, tolerance: float, scale: float | None = None) -> Drawing:
    """Return the outlines in the drawing `path` in m, y upwards, the lower left corner of the blocks at (0, 0).

    tolerance in m: ends of lines nearer than this meet, curves become chords no farther off. scale: m a user unit,
    instead of what the file says. Raises CaseError naming file, group or place, and remedy.
    """
    with naming(path):
        return _drawing(_root(path), layers, tolerance, scale)


def _root(path: Path) -> Element:
    """Return the root element; a document that declares entities is refused (they may expand without end)."""
    try:
        refuse_what_is_no_file(path, LARGEST_FILE, "keep only the groups of the wall")
        content = path.read_bytes()
    except FileNotFoundError:
        raise CaseError("", "no such file", "give the path of an SVG drawing") from None
    except OSError as error:
        raise unreadable(error, "give the path of an SVG drawing") from None
    builder = TreeBuilder()
    parser = expat.ParserCreate(namespace_separator="}")
    depth = 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > DEEPEST_NESTING:
            raise CaseError("", f"groups are nested more than {DEEPEST_NESTING} deep", "ungroup them")
        builder.start(_qualified(tag), {_qualified(key): value for key, value in attributes.items()})

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(_qualified(tag))

    def entity(*_: object) -> None:
        raise CaseError("", "declares entities, which are not read", "save it as plain SVG")

    parser.StartElementHandler, parser.EndElementHandler, parser.EntityDeclHandler = start, end, entity
    parser.CharacterDataHandler = builder.data
    try:
        parser.Parse(content, True)
        root = builder.close()
    except (expat.ExpatError, AssertionError, ValueError, LookupError) as error:
        raise CaseError("", f"is not an SVG drawing ({str(error)[:100]})", "save it as plain SVG") from None
    if _tag(root) != "svg":
        raise CaseError("", f"is not an SVG drawing but <{_tag(root)[:40]}>", "save it as plain SVG")
    return root


def _qualified(name: str) -> str:
    return "{" + name if "}" in name else name


def _tag(element: Element) -> str:
    return element.tag.rpartition("}")[2]


def _drawing(root: Element, layers: Layers, tolerance: float, scale: float | None) -> Drawing:
    unit, remarks = _unit(root, scale)
    drawn, said = _all_drawn(root)
    remarks += said
    on = _by_role(drawn, layers, said)
    points = {
        role: [(name, _flat(one, CHORD * tolerance / unit) * unit * [1.0, -1.0], one.path) for name, one in members]
        for role, members in on.items()
    }
    corners = [outline for members in points.values() for _, outline, _ in members]
    if sum(map(len, corners)) > LARGEST_CORNERS:
        raise CaseError("", f"more than {LARGEST_CORNERS} corners", "raise --tolerance or import it in parts")
    if not all((np.abs(outline) < 1e9).all() for outline in corners):
        raise CaseError("", "a coordinate is not a number below 1e9 m", "correct the drawing, or give --scale")
    low = np.vstack([outline for _, outline, _ in points["blocks"]]).min(axis=0)
    outer = {}
    for role, members in points.items():
        outer[role], holes = _without_holes([(name, outline - low, path) for name, outline, path in members])
        remarks += [f"{role}: WARNING: {counted(holes, 'hole')} in outlines filled"] if holes else []
    curved = any(len(control) > 2 for members in on.values() for _, one in members for control in one.curves)
    drawing = drawing_of(outer, tolerance, remarks, curved)
    taken = {id(one) for members in on.values() for _, one in members}
    left = [one for one in drawn if one.names and id(one) not in taken]
    ends = [np.vstack([one.curves[0][:1], *(curve[-1:] for curve in one.curves)]) for one in left]  # without chords
    others = [(one.names[0], at * unit * [1.0, -1.0] - low) for one, at in zip(left, ends, strict=True)]
    told = said_of_other_layers(others, drawing, layers, tolerance)
    return replace(drawing, remarks=(f"{counted(len(drawing.stones), 'stone')} found", *drawing.remarks, *told))


def _unit(root: Element, scale: float | None) -> tuple[float, list[str]]:
    """Return m per user unit, and where that comes from."""
    if scale is not None:
        return scale, [f"user unit {1e3 * scale:.6g} mm, as given"]
    lengths = [_length(root.get(key, "")) for key in ("width", "height")]
    if None in lengths:
        problem = "the drawing does not say how long a user unit is (its width and height have no unit of length)"
        raise CaseError("--scale", problem, 'give the length of a user unit, as in --scale "1 mm"')
    box = numbers(root.get("viewBox", ""), "viewBox")
    if not box:
        return CSS_PIXEL, [f"user unit {1e3 * CSS_PIXEL:.6g} mm, 96 to the inch, as there is no viewBox"]
    if len(box) != 4 or not (0 < box[2] < math.inf and 0 < box[3] < math.inf):
        raise CaseError("viewBox", "is not four numbers, the last two above 0", "correct it, or give --scale")
    across, upward = (length / size for length, size in zip(lengths, box[2:], strict=True) if length is not None)
    if root.get("preserveAspectRatio", "").strip().startswith("none") and abs(across / upward - 1) > 1e-3:
        raise CaseError("viewBox", "stretches the drawing", "give it the proportions of width and height")
    unit = max(across, upward) if "slice" in root.get("preserveAspectRatio", "") else min(across, upward)
    if not 0 < unit < 1e6:
        raise CaseError("viewBox", f"makes a user unit {unit:.3g} m long", "correct it, or give --scale")
    return unit, [f"user unit {1e3 * unit:.6g} mm, from width, height and viewBox"]


def _length(text: str) -> float | None:
    """Return a length in m; none for a text without a unit of length."""
    match = re.fullmatch(rf"\s*({NUMBER.pattern})\s*([a-zA-Z]+)\s*", text)
    return float(match[1]) * LENGTHS[match[2].lower()] if match and match[2].lower() in LENGTHS else None


@dataclass(frozen=True, eq=False, slots=True)
class Place:
    """Where an element is: from its user units to the drawing's (3, 3), names around it, and whether it is hidden:
    `out` with all that is in it, `unseen` unless something in it is shown again; `clipped`: part of it is hidden."""

    matrix: FloatArray
    names: tuple[str, ...] = ()
    out: bool = False
    unseen: bool = False
    clipped: bool = False


def _all_drawn(root: Element) -> tuple[list[Drawn], list[str]]:
    """Return the subpaths of everything that is shown, and remarks on what is not read or hidden."""
    drawn: list[Drawn] = []
    passed: Counter[str] = Counter()
    whole = 0
    rules, unread = rules_in(["".join(each.itertext()) for each in root.iter() if _tag(each) == "style"])
    stack: list[tuple[Element, Place]] = [(root, Place(np.eye(3)))]
    while stack:
        element, around = stack.pop()
        tag = _tag(element)
        if tag in PASSED_OVER:
            continue
        out = around.out or is_taken_out(element, tag, rules)
        unseen = is_unseen(element, tag, rules, around.unseen)
        if tag in UNREAD:
            passed["hidden " * (out or unseen) + tag] += 1
            continue
        if by := moved_by(element, tag, rules):
            remedy = "write it as the attribute transform, or save as plain SVG"
            raise CaseError(place_of(element, tag), f"is moved by {by}, which is not read", remedy)
        matrix = around.matrix @ transform(element.get("transform", ""))
        if tag == "svg" and element is not root:
            matrix = matrix @ nested_view(element)
        clipped = around.clipped or is_clipped(element, tag, rules)
        place = Place(matrix, (*_names(element, tag), *around.names), out, unseen, clipped)
        stack += [(child, place) for child in reversed(element)]
        shapes = [*subpaths(element, tag)]
        if shapes and (out or unseen):
            passed[f"hidden {tag}"] += 1
            continue
        whole += bool(shapes and clipped)
        for curves in shapes:
            placed = tuple(c @ matrix[:2, :2].T + matrix[:2, 2] for c in curves)
            drawn.append(Drawn(place.names, placed, id(element)))
    styles = [f"WARNING: style of {one!r} hides or moves something and is not read" for one in unread]
    return drawn, [*_said(passed, whole), *styles]


def _said(passed: Counter[str], whole: int) -> list[str]:
    """Return one line on what is passed over, a warning where something that is shown is among it; and one on how many
    shapes are read as a `whole` though part of them is hidden."""
    said = []
    if passed:
        warning = "WARNING: " * any(not kind.startswith("hidden") for kind in passed)
        said.append(f"{warning}passed over: {', '.join(f'{number} {kind}' for kind, number in sorted(passed.items()))}")
    if whole:
        many = f"{counted(whole, 'shape')} with a clip-path or mask read as if without"
        said.append(f"WARNING: {many}: delete what it hides, or cut the shapes there")
    return said


def _names(element: Element, tag: str) -> list[str]:
    """Return the label that somebody gave a group or a shape, or the id that somebody gave a group."""
    if label := element.get(INKSCAPE_LABEL):
        return [label]
    name = element.get("id", "") if tag in ("g", "a") else ""
    return [name] if name and not AUTOMATIC.fullmatch(name) else []


def _by_role(drawn: list[Drawn], layers: Layers, said: list[str]) -> dict[str, list[tuple[str, Drawn]]]:
    """Return name and subpath by role: the innermost name that is chosen counts. Without names all are blocks. said: of
    what is not read, told where nothing is left."""
    on: dict[str, list[tuple[str, Drawn]]] = {role: [] for role in ROLES}
    if layers.blocks == Layers().blocks and not any(one.names for one in drawn):
        on["blocks"] = [("", one) for one in drawn]
    for one in drawn:
        chosen = (
            (role, name)
            for name in (*one.names, "")
            for role in ("openings", "supports", "blocks")
            if is_chosen(name, getattr(layers, role))
        )
        for role, name in [*chosen][:1]:
            on[role].append((name, one))
    if not on["blocks"]:
        groups = ", ".join(sorted({name for one in drawn for name in one.names})[:20]) or "none with paths"
        problem = "; ".join([f"nothing is drawn in a group {layers.blocks!r}", *said]).replace("WARNING: ", "")
        raise CaseError("blocks", problem, f"choose one with --blocks NAME; the drawing's groups: {groups}")
    return on


def _without_holes(drawn: list[tuple[str, FloatArray, int]]) -> tuple[list[tuple[str, FloatArray]], int]:
    """Return name and points without closed subpaths inside another of the same path, and how many those are."""
    of: dict[int, list[int]] = {}
    for k, (_, outline, path) in enumerate(drawn):
        if len(outline) > 3 and np.array_equal(outline[0], outline[-1]):
            of.setdefault(path, []).append(k)
    holes = set()
    for members in of.values():
        if len(members) > 1:
            polygons = np.array([shapely.Polygon(drawn[k][1]) for k in members])
            valid = shapely.is_valid(polygons)
            inner, outer = shapely.STRtree(polygons[valid]).query(polygons[valid], predicate="within")
            larger = shapely.area(polygons[valid])[outer] > shapely.area(polygons[valid])[inner]
            holes |= {np.array(members)[valid][k] for k in inner[larger]}
    return [(name, outline) for k, (name, outline, _) in enumerate(drawn) if k not in holes], len(holes)


def _flat(drawn: Drawn, chord: float) -> FloatArray:
    """Return the points (n, 2) of a subpath whose chords are no farther than `chord` from its curves."""
    pieces = [drawn.curves[0][:1]]
    for control in drawn.curves:
        degree = len(control) - 1
        bend = np.abs(np.diff(control, 2, axis=0)).max(initial=0.0) * math.sqrt(2)
        steps = math.sqrt(degree * (degree - 1) / 8 * bend / chord)
        if not steps < LARGEST_STEPS:
            raise CaseError("", f"a curve needs more than {LARGEST_STEPS} chords", "raise --tolerance, or give --scale")
        t = np.linspace(0.0, 1.0, max(1, math.ceil(steps)) + 1)[1:, None]
        pieces.append(
            sum(math.comb(degree, k) * t**k * (1 - t) ** (degree - k) * control[k] for k in range(degree + 1))
        )
    return np.vstack(pieces)

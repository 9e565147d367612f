"""What all pictures share: colours, a figure of the wall's proportions in m, text that cannot break out, saving.

Colours of lines are those of Okabe and Ito (2008), distinguishable by colour-blind readers; where two kinds of line
must be told apart in print without colour, their width or dashes differ too.
"""

from __future__ import annotations

import textwrap
import warnings
from collections import defaultdict
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.collections import LineCollection, PathCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.patheffects import withStroke
from matplotlib.textpath import TextPath
from matplotlib.transforms import Affine2D

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.atomic_files import together, write_bytes
from orchestrator.present.plots.words import LINE, tell, write_title
from orchestrator.settings.project import Language

STONE = "#f2ece1"
"""fill of stones"""
SUPPORT = "#d5d5d5"
"""fill of supports"""
FAINT = "#b5b5b5"
"""outlines of what is no longer there"""
INK = "#333333"
"""outlines and limit analysis"""
VERMILLION = "#d55e00"
"""this and the next four: Okabe and Ito, distinguishable by colour-blind readers"""
BLUE = "#0072b2"
"""of Okabe and Ito"""
GREEN = "#009e73"
"""of Okabe and Ito"""
ORANGE = "#e69f00"
"""of Okabe and Ito"""
PURPLE = "#cc79a7"
"""of Okabe and Ito"""
DOTS_PER_INCH = 150
"""of PNG pictures"""
QUICK = 3
"""of compressing a PNG, 0 to 9: two thirds of the time of 6, for a tenth more bytes"""
LARGEST_DRAWING = (7.0, 7.5)
"""largest drawing of a wall, inches"""
SMALLEST_NUMBER = 3.0
"""points"""
DIGIT_WIDTH = 0.636
"""from one digit to the next, part of a font's size, in DejaVu Sans, which comes with matplotlib"""
DIGIT_HEIGHT = 0.729
"""of a digit, part of a font's size, in DejaVu Sans"""
SMALLEST_WIDTH = 5.0
"""inches; a title and a legend need them"""


def wall_figure(points: FloatArray, title: str, name: str) -> tuple[Figure, Axes]:
    """Return a figure with axes in m that shows all `points` (n, 2); `name` of the wall goes above the title, unless it
    is ""."""
    low, high, scale = _frame(points)
    extent = high - low
    height = scale * extent[1] + 1.5 + LINE * (title.count("\n") - (not name))
    figure = Figure(figsize=(max(SMALLEST_WIDTH, scale * extent[0] + 0.8), height))
    figure.set_layout_engine("constrained")
    axes = figure.add_subplot()
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    axes.ticklabel_format(useOffset=False)
    write_title(axes, title, name)
    wrapped = axes.get_title().count("\n") - title.count("\n") - bool(name)
    figure.set_figheight(height + LINE * wrapped)
    return figure, axes


def _frame(points: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return the corners (2,) in m of axes around points (n, 2), and their scale in inches per m."""
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.04 * float(np.max(high - low))
    low, high = low - margin, high + margin
    return low, high, float(np.min(np.array(LARGEST_DRAWING) / (high - low)))


def text_ends(points: FloatArray, place: FloatArray, side: int, text: str, size: float) -> FloatArray:
    """Return the ends (2, 2) in m of a text of a size in points, in a `wall_figure` of points (n, 2) and these ends.

    side: 1 to the right of its `place` (2,), -1 to the left of it, 0 centred on it.
    """
    width = TextPath((0.0, 0.0), text, size=size).get_extents().width / 72
    ends = np.stack([place, place])
    for _ in range(3):  # the wider the figure, the smaller its scale
        scale = _frame(np.vstack([points, ends]))[2]
        ends = place + 0.5 * width / scale * np.array([[side - 1.0, 0.0], [side + 1.0, 0.0]])
    return ends


def draw_polygons(
    axes: Axes, polygons: Sequence[FloatArray], fill: str | Sequence[str], edge: str = INK, width: float = 0.7
) -> PolyCollection:
    """Draw polygons, each (n, 2) in m, in one colour or one each."""
    drawn = PolyCollection(list(polygons), facecolors=fill, edgecolors=edge, linewidths=width)
    axes.add_collection(drawn, autolim=False)
    return drawn


def draw_supports(axes: Axes, polygons: Sequence[FloatArray]) -> PolyCollection:
    """Draw supports, hatched."""
    drawn = draw_polygons(axes, polygons, SUPPORT, "#777777")
    drawn.set_hatch("////")
    drawn.set_label("support")
    return drawn


def draw_segments(
    axes: Axes, segments: FloatArray | Sequence[FloatArray], colour: str, width: float, label: str = ""
) -> LineCollection:
    """Draw segments (k, 2, 2) in m above everything that is filled."""
    drawn = LineCollection(list(segments), colors=colour, linewidths=width, zorder=3, capstyle="round")
    drawn.set_label(label or "_")
    axes.add_collection(drawn, autolim=False)
    return drawn


def write_number(axes: Axes, position: FloatArray, number: int, size: float) -> None:
    """Write a number at `position` (2,) in m, with a halo that keeps it readable on hatches and lines; size in
    points."""
    x, y = position
    halo = [withStroke(linewidth=2.0, foreground="white", alpha=0.8)]
    text = axes.text(x, y, str(number), ha="center", va="center", fontsize=size, zorder=4, path_effects=halo)
    text.set_in_layout(False)  # it lies within the axes


def write_numbers(axes: Axes, positions: Sequence[FloatArray], numbers: Sequence[int], size: float) -> None:
    """Write numbers at `positions`, each (2,) in m; size in points.

    The smallest ones, of walls of a thousand stones, go without a halo and as outlines of digits, one collection for
    each digit and its place in a number: the picture of 1,460 stones takes 0.4 s of CPU for 1.8.
    """
    if size > SMALLEST_NUMBER:
        for position, number in zip(positions, numbers, strict=True):
            write_number(axes, position, number, size)
        return
    figure = axes.get_figure(root=True)
    assert figure is not None
    points_to_pixels = Affine2D().scale(1 / 72) + figure.dpi_scale_trans
    where: dict[tuple[str, float], list[FloatArray]] = defaultdict(list)
    for position, number in zip(positions, numbers, strict=True):
        digits = str(number)
        for k, digit in enumerate(digits):
            where[digit, k - 0.5 * len(digits)].append(position)
    for (digit, place), offsets in sorted(where.items()):
        shape = TextPath((place * DIGIT_WIDTH * size, -0.5 * DIGIT_HEIGHT * size), digit, size=size)
        drawn = PathCollection([shape], offsets=offsets, offset_transform=axes.transData, zorder=4)
        drawn.set(transform=points_to_pixels, facecolor="black", linewidth=0, in_layout=False)
        axes.add_collection(drawn, autolim=False)


def number_size(polygons: Sequence[FloatArray], axes: Axes) -> float:
    """Return the font size in points that suits the smallest side of the polygons' boxes, up to 9."""
    smallest = min(float(np.min(np.ptp(polygon, axis=0))) for polygon in polygons)
    figure = axes.get_figure(root=True)
    assert figure is not None
    points_per_metre = 72 * (figure.get_figwidth() - 0.8) / float(np.ptp(axes.get_xlim()))
    return float(np.clip(0.4 * smallest * points_per_metre, SMALLEST_NUMBER, 9.0))


def stamp_not_valid(place: Figure | Axes, size: float = 56.0) -> None:
    """Write NOT VALID across a picture, so that nobody who sees it can overlook it; size in points."""
    text = place.text(0.5, 0.5, "NOT VALID", ha="center", va="center", rotation=30)
    text.set(color=VERMILLION, alpha=0.35, fontsize=size, fontweight="bold", zorder=5)
    if isinstance(place, Axes):
        text.set_transform(place.transAxes)


def label_of(text: str, letters: int = 40) -> str:
    """Return a name from a file as the label of a legend: short, `$` only a dollar, and not left out for its `_`."""
    short = textwrap.shorten(text, letters, placeholder="…").replace("$", r"\$")
    return f" {short}" if short.startswith("_") else short


def lay_out(figure: Figure) -> None:
    """Make room for title, labels and legend, at the resolution of PNG pictures: lines of text are whole pixels high,
    and legends of many would not fit at another.

    Where a wall's height decides the scale, matplotlib measures the title over axes that it moves up only afterwards:
    one pass cuts off its upper line by up to 10 pixels, three do not. Most figures keep their places in the second.
    """
    figure.set_dpi(DOTS_PER_INCH)
    engine = figure.get_layout_engine()
    if isinstance(engine, ConstrainedLayoutEngine):
        for spine in [spine for axes in figure.axes for spine in axes.spines.values()]:
            spine.set_in_layout(False)  # half a line's width; measuring it takes a quarter of the time
        places = np.array([])
        for _ in range(3):
            engine.execute(figure)
            before, places = places, np.array([axes.get_position().bounds for axes in figure.axes])
            if np.array_equal(places, before):
                break


def save(figure: Figure, folder: Path, name: str, language: Language = "en") -> list[Path]:
    """Write `name`.png and `name`.svg to `folder` in a language, both or neither; equal figures give equal files."""
    tell(figure, language)
    pixels, lines = BytesIO(), BytesIO()
    packed = {"compress_level": QUICK}
    with warnings.catch_warnings(), matplotlib.rc_context({"svg.hashsalt": name}):
        warnings.filterwarnings("ignore", "Glyph")  # of letters that no font has: boxes are drawn for them
        lay_out(figure)
        figure.set_layout_engine("none")  # once is enough, for both files
        drawn = FigureCanvasAgg(figure)  # `savefig` draws twice
        drawn.print_png(pixels, metadata={"Software": None}, pil_kwargs=packed)
        FigureCanvasSVG(figure).print_svg(lines, metadata={"Date": None})
    paths = [folder / f"{name}.png", folder / f"{name}.svg"]
    with together():
        for path, content in zip(paths, (pixels, lines), strict=True):
            write_bytes(path, content.getvalue())
    return paths

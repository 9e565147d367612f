"""What a figure of the wall shows: outlines, lines, words, pixels."""

from __future__ import annotations

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_hex


def polygons(figure, collection):
    """Corners of a PolyCollection of the first axes, without the closing point."""
    found = [c for c in figure.axes[0].collections if isinstance(c, PolyCollection)]
    return [path.vertices[:-1] for path in found[collection].get_paths()]


def segments(figure, colour):
    """Segments of all line collections of one colour."""
    found = [c for c in figure.axes[0].collections if isinstance(c, LineCollection)]
    chosen = [c for c in found if to_hex(c.get_color()[0]) == to_hex(colour)]
    return [segment for c in chosen for segment in c.get_segments()]


def shown(figure):
    """All texts of the axes and the labels of the legend."""
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    return [text.get_text() for text in figure.axes[0].texts], legend


def drawn(figure):
    """The canvas after drawing: positions are final, pixels exist (a bare figure's canvas draws nothing)."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return canvas


def pixel(figure, x, y):
    """Colour drawn at x, y in m."""
    canvas = drawn(figure)
    across, up = figure.axes[0].transData.transform((x, y))
    return to_hex(np.asarray(canvas.buffer_rgba())[-1 - int(up), int(across)] / 255)

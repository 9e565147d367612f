"""The words of pictures: titles, legends, and all of them in the language of a report.

A picture is drawn in English. `tell` says what is written in it in another language, from the same table as the page
(phrases.py), and only then is there a layout: titles are wrapped again, legends get as few rows as fit. What comes
from the input (names of walls, materials, load cases) and what the table does not know stays as it is.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.text import Text
from matplotlib.ticker import Formatter

from orchestrator.present.phrases import in_language, phrases
from orchestrator.settings.project import Language

COLUMNS = 5
"""of a legend at most"""
EQUALS = "\u00a0=\u00a0"
"""a sign of equality that no line is broken at"""
LINE = 0.2
"""inches, of a title or a legend"""


def write_title(axes: Axes, title: str, name: str) -> None:
    """Write the wall's name (shortened; none: left out) and the lines of the title, wrapped to fit; `$` in a name is
    only a dollar. Name and lines as they were before are the title's label, for `tell`."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    letters = int(figure.get_figwidth() * 11)
    together = title.replace(" = ", EQUALS)  # no line ends within "λ = 1"
    wrapped = [part.replace(EQUALS, " = ") for line in together.splitlines() for part in textwrap.wrap(line, letters)]
    head = [textwrap.shorten(name, letters, placeholder="…")] if name else []
    text = "\n".join([*head, *wrapped])
    axes.set_title(text, y=1.0, fontsize=10, parse_math=False)  # left to itself it looks for ticks at the top each time
    axes.title.set_label("\n".join([" ".join(name.split()), *title.splitlines()]))


def legend_below(axes: Axes, columns: int = 4) -> None:
    """Put the legend of everything labelled below the axes; the figure grows with its rows."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    _grow(figure, LINE * (write_legend(figure, columns) - 1))


def write_legend(figure: Figure, columns: int) -> int:
    """Put the legend of everything labelled in a figure at its foot, in as few rows as fit; return how many."""
    handles = _labelled(figure)
    names = [str(handle.get_label()) for handle in handles]
    rows = max(-(-len(handles) // columns), 1)
    while True:
        columns = max(-(-len(handles) // rows), 1)
        legend = figure.legend(handles, names, loc="outside lower center", ncols=columns, fontsize=8, frameon=False)
        if columns == 1 or legend.get_window_extent().width <= figure.bbox.width:
            return rows
        legend.remove()
        rows += 1


def _labelled(figure: Figure) -> list[Artist]:
    """Return what a legend shows, in the order of the axes."""
    return [handle for axes in figure.axes for handle in axes.get_legend_handles_labels()[0]]


def tell(figure: Figure, language: Language) -> None:
    """Say all that is written in a finished figure in a language; English stays as it is."""
    if language == "en":
        return

    def say(text: str) -> str:
        return in_language(phrases(language)(text), language)

    titled = [axes for axes in figure.axes if "\n" in str(axes.title.get_label())]
    apart = {axes.title for axes in titled} | {text for legend in figure.legends for text in legend.get_texts()}
    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        if text not in apart and any(letter.isalpha() for letter in text.get_text()):
            text.set_text(say(text.get_text()))
    for axis in figure.findobj(Axis):
        assert isinstance(axis, Axis)
        axis.set_major_formatter(_Told(axis.get_major_formatter(), say))
    for axes in titled:
        _tell_title(axes, say)
    for legend in list(figure.legends):
        _tell_legend(figure, legend, say)


def _tell_title(axes: Axes, say: Callable[[str], str]) -> None:
    """Say the lines below the wall's name, wrapped again; the figure grows with the lines."""
    name, *lines = str(axes.title.get_label()).split("\n")
    before = axes.get_title().count("\n")
    write_title(axes, "\n".join(map(say, lines)), name)
    _grow(axes.get_figure(root=True), LINE * (axes.get_title().count("\n") - before))


def _tell_legend(figure: Figure, legend: Legend, say: Callable[[str], str]) -> None:
    """Say the labels and write the legend again; the figure grows with its rows."""
    before = legend.get_window_extent().height
    legend.remove()
    for handle in _labelled(figure):
        handle.set_label(say(str(handle.get_label())))
    write_legend(figure, COLUMNS)
    _grow(figure, (figure.legends[-1].get_window_extent().height - before) / figure.dpi)


def _grow(figure: Figure | None, inches: float) -> None:
    assert figure is not None
    figure.set_figheight(figure.get_figheight() + inches)


class _Told(Formatter):
    """What an axis writes at its ticks, said in a language."""

    def __init__(self, written: Formatter, say: Callable[[str], str]) -> None:
        self.written, self.say = written, say

    def set_axis(self, axis: Axis | None) -> None:  # type: ignore[override]
        super().set_axis(axis)
        self.written.set_axis(axis)

    def __call__(self, x: float, pos: int | None = None) -> str:
        return self.say(self.written(x, pos))

    def format_ticks(self, values: list[float]) -> list[str]:
        return [self.say(text) for text in self.written.format_ticks(values)]

    def get_offset(self) -> str:
        return self.say(self.written.get_offset())

    def set_locs(self, locs: list[float]) -> None:
        self.written.set_locs(locs)

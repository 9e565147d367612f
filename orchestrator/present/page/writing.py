"""Stored run -> report.html (Jinja2, everything from the input escaped)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from orchestrator.basis.printed import FORMS, Figure, marked, printed
from orchestrator.present.environment import environment_of
from orchestrator.present.page.contents import contents, picture
from orchestrator.present.page.seismic_page import spectrum_words
from orchestrator.present.page.verdict_page import verdict_contents
from orchestrator.present.phrases import in_language, phrases
from orchestrator.present.verdict import Verdict
from orchestrator.present.weights import Sums, multiplier_words
from orchestrator.settings.project import Language, ProjectSettings
from orchestrator.storage.files import plain, write_text
from orchestrator.storage.stored_run import read_run
from orchestrator.storage.summary import IN_BRACKETS

if TYPE_CHECKING:
    from jinja2 import Environment

IN_FULL = 1e6
"""below it a number is written without a power of ten, which engineers' reports have no use for"""


def write(folder: Path) -> Path:
    """Write report.html of the run in `folder` and return its path. Raises CaseError where there is none."""
    path = folder / "report.html"
    write_text(path, render(contents(read_run(folder))))
    return path


def write_index(
    folder: Path,
    case: str,
    rows: Sequence[dict[str, Any]],
    verdict: Verdict,
    project: ProjectSettings,
    verified: dict[str, Any] | None,
) -> Path:
    """Write report.html of a run of several load cases: the verdict on them, their table (rows of load_cases.csv),
    their curves (figures/curves), what they were `verified` for (the record of one of them, None: nothing was asked),
    and a link to the report of each. Return its path."""
    language = project.language
    path = folder / "report.html"
    reports = {row["load_case"]: f"{quote(row['load_case'])}/report.html" for row in rows if row["model"]}
    curves = picture(folder / "figures" / "curves.png")
    values: dict[str, Any] = {"case": case, "rows": rows, "reports": reports, "curves": curves, "language": language}
    values["verdict"] = verdict_contents(verdict, language)
    seismic = verified and {"states": verified["limit_states"], "spectrum": spectrum_words(verified)}
    values |= {"weights": _weights(rows), "project": project, "seismic": seismic}
    write_text(path, _environment(language).get_template("load_cases.html.j2").render(values))
    return path


def _weights(rows: Sequence[dict[str, Any]]) -> dict[str, list[str]]:
    """Return what λ is and the weights in words, with the load cases that have them."""
    cases: dict[str, list[str]] = {}
    for row in rows:
        if row["model"]:
            words = multiplier_words(Sums(*(row[f"{field.name}_N"] for field in fields(Sums))))
            cases.setdefault(words, []).append(row["load_case"])
    return {words: list(dict.fromkeys(names)) for words, names in cases.items()}


def render(values: dict[str, Any]) -> str:
    """Return the page."""
    return _environment(values["language"]).get_template("report.html.j2").render(plain_collapse(values))


def _environment(language: Language) -> Environment:
    environment = environment_of("orchestrator.present.page")
    filters: dict[str, Callable[..., str]] = {
        "shown": shown,
        "fixed": fixed,
        "small": small,
        "printed": _printed,
        "marked": _marked,
    }
    for name, filtering in filters.items():
        environment.filters[name] = _localised(filtering, language)
    environment.globals |= {
        "t": _told(phrases(language)),
        "factor_of": _factor_of,
        "infinite": inf,
        "BRACKETS": IN_BRACKETS,
    }
    return environment


def _told(say: Callable[[str], str]) -> Callable[..., str]:
    """Return what the templates call: a phrase in the language of the page, its places filled with what is given.

    The phrase is escaped, and so is what fills it, as everywhere on the page; what a macro made is not escaped again.
    """
    from markupsafe import escape  # comes with jinja2

    return lambda text, **values: escape(say(text)).format(**values) if values else say(text)


def _localised(filtering: Callable[..., str], language: Language) -> Callable[..., str]:
    return lambda *values, **options: in_language(filtering(*values, **options), language)


def plain_collapse(values: dict[str, Any]) -> dict[str, Any]:
    """Return the values with the collapse as plain lists and numbers."""
    return values | {"collapse": plain(values["collapse"])}


def _factor_of(kind: Figure) -> float:
    return FORMS[kind][0]


def _printed(value: float | None, kind: Figure) -> str:
    return printed(kind, value)


def _marked(value: float | None, kind: Figure, closed: bool) -> str:
    return marked(kind, value, closed)


def shown(value: float | None, digits: int = 4, factor: float = 1.0) -> str:
    """Return a number with so many significant digits, from 1 to IN_FULL without a power of ten; a count as it is, a
    dash for none."""
    if value is None or isinstance(value, int):
        return "–" if value is None else str(value)
    text = f"{value * factor:#.{digits}g}".removesuffix(".")
    if "e" not in text:
        return text
    return f"{float(text):.0f}" if 1.0 <= abs(value * factor) < IN_FULL else f"{value * factor:.{digits - 1}e}"


def fixed(value: float, decimals: int = 3, factor: float = 1.0) -> str:
    """Return a number with so many decimals, for columns of lengths."""
    return f"{round(value * factor, decimals) + 0.0:.{decimals}f}"


def small(value: float | None) -> str:
    """Return a residual, as in 2e-16."""
    return "–" if value is None else f"{value:.1e}"

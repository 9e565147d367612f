"""The phrases of the page in English, Italian and Portuguese, and numbers as each language writes them.

English is the key. What is not here is shown in English: remarks of the mechanics, clauses, names from the input.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable
from functools import cache
from importlib.resources import files

from orchestrator.settings.project import Language


@cache
def table() -> dict[str, tuple[str, str]]:
    """Return English -> Italian, Portuguese (template/phrases.csv)."""
    text = files("orchestrator.present.page").joinpath("template", "phrases.csv").read_text(encoding="utf-8")
    rows = list(csv.reader(text.splitlines()))
    return {english: (italian, portuguese) for english, italian, portuguese in rows[1:]}


def phrases(language: Language) -> Callable[[str], str]:
    """Return what turns an English phrase into one of a language; what it does not know it leaves in English."""
    if language == "en":
        return str
    place = ("it", "pt").index(language)
    return lambda text: table()[text][place] if text in table() else text


def in_language(text: str, language: Language) -> str:
    """Return a text with its numbers as a language writes them: decimal commas in Italian and Portuguese."""
    return text if language == "en" else re.sub(r"(?<=\d)\.(?=\d)", ",", text)

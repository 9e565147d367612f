"""The phrases of page and pictures in English, Italian and Portuguese, and numbers as each language writes them.

English is the key. What is not here is shown in English: most remarks of the mechanics, clauses, names from the input.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable
from functools import cache
from importlib.resources import files

from orchestrator.settings.project import Language

NUMBER = re.compile(r"[-+]?\d+\.\d+(e[-+]?\d+)?( ?(%|kN))?")
"""with the units that sentences have behind it"""


@cache
def table() -> dict[str, tuple[str, str]]:
    """Return English -> Italian, Portuguese (phrases.csv)."""
    text = files("orchestrator.present").joinpath("phrases.csv").read_text(encoding="utf-8")
    rows = list(csv.reader(text.splitlines()))
    return {english: (italian, portuguese) for english, italian, portuguese in rows[1:]}


def phrases(language: Language) -> Callable[[str], str]:
    """Return what turns an English phrase into one of a language; what it does not know it leaves in English.

    A phrase with places, as in "{count} more", keeps them. A sentence that was finished elsewhere, as in "5 more", is
    told by the phrase with places that it fits, of several by the one with most words of its own; so is what stands
    in its places. A number alone, or with its unit, is written as the language writes it. A list is told thing by thing
    where every one of them is known, and the first as well as the whole, if that is a sentence with a list in it.
    """
    if language == "en":
        return str
    column = ("it", "pt").index(language)

    def say(text: str) -> str:
        if text in table():
            return table()[text][column]
        if NUMBER.fullmatch(text):
            return in_language(text, language)
        things, found = text.split(", "), _phrase_of(text)
        if len(things) > 1 and len(_words_of(things[0])) >= len(_words_of(text)):
            told = [say(thing) for thing in things]
            if all(new != old for new, old in zip(told, things, strict=True)):
                return ", ".join(told)
        if found is None:
            return text
        english, filled = found
        return table()[english][column].format(**{name: say(part) for name, part in filled.groupdict().items()})

    return say


def in_language(text: str, language: Language) -> str:
    """Return a text with its numbers as a language writes them: decimal commas in Italian and Portuguese."""
    return text if language == "en" else re.sub(r"(?<=\d)\.(?=\d)", ",", text)


def _phrase_of(text: str) -> tuple[str, re.Match[str]] | None:
    """Return the phrase with places that a finished text fits, of several the one with most words of its own, and what
    stands in its places."""
    return next(((english, filled) for fits, english in _with_places() if (filled := fits.fullmatch(text))), None)


def _words_of(text: str) -> str:
    """Return the words that are the phrase's own in a finished text."""
    found = _phrase_of(text)
    return text if text in table() else re.sub(r"{\w+}", "", found[0] if found else "")


@cache
def _with_places() -> list[tuple[re.Pattern[str], str]]:
    """Return the phrases with places, each with what it looks like when they are filled, most words first."""
    phrases = [english for english in table() if "{" in english]
    own = {english: len(re.sub(r"{\w+}", "", english)) for english in phrases}
    return [(_filled(english), english) for english in sorted(phrases, key=lambda english: -own[english])]


def _filled(english: str) -> re.Pattern[str]:
    """Return what a phrase looks like when something stands in each of its places."""
    parts = re.split(r"{(\w+)}", english)
    return re.compile("".join(f"(?P<{part}>.+)" if n % 2 else re.escape(part) for n, part in enumerate(parts)))

"""What a report says of its project, and the language it is written in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from orchestrator.basis.checked import Checked

Language = Literal["en", "it", "pt"]


@dataclass(frozen=True, slots=True)
class ProjectSettings(Checked):
    """Project data on top of the report; what is left out is not shown. The wall's name is that of the case."""

    client: str = ""
    """for whom"""
    author: str = ""
    """who signs"""
    date: str = ""
    """as it shall be printed, as in "12 May 2026": the program has none of its own, equal inputs give equal pages"""
    place: str = ""
    """where the wall stands"""
    number: str = ""
    """of the project"""
    remarks: str = ""
    """a paragraph under the project data"""
    language: Language = "en"
    """of headings, tables, verdict and numbers: English, Italian or Portuguese"""

    @property
    def shown(self) -> list[tuple[str, str]]:
        """What was given, by its name, in the order of the pages; remarks stand under it."""
        names = ("number", "client", "place", "author", "date")
        return [(name, value) for name in names if (value := getattr(self, name))]

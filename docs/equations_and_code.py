"""Hook of mkdocs: equations become MathML, which browsers draw without a script, and links to modules lead to pages.

A link to ../orchestrator/X.py works where the repository is read as files; in the built pages it leads to code/X, the
module as a page. A link to a module that does not exist makes the build fail.
"""

from __future__ import annotations

import html
import re
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert
from mkdocs.structure.files import File, Files, InclusionLevel

PACKAGE = Path(__file__).parents[1] / "orchestrator"
LINK = re.compile(r"\]\(\.\./orchestrator/([\w/]+)\.py\)")
EQUATION = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.DOTALL)
TAG = re.compile(r"\\tag\{(.*?)\}")
BOLD = re.compile(r'<mi mathvariant="bold(?:-italic)?">(.*?)</mi>')
BOLD_LETTERS = {"A": 0x1D400, "a": 0x1D41A, "α": 0x1D6C2}
"""Unicode's bold alphabets: browsers do not know MathML's mathvariant"""


def on_files(files: Files, *, config: Any) -> Files:
    """Add a page for every module."""
    for path in sorted(PACKAGE.rglob("*.py")):
        name = path.relative_to(PACKAGE)
        content = f"---\nsearch:\n  exclude: true\n---\n# {name}\n\n~~~~ python\n{path.read_text()}\n~~~~\n"
        place = f"code/{name.with_suffix('.md')}"
        files.append(File.generated(config, place, content=content, inclusion=InclusionLevel.NOT_IN_NAV))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Let links to modules lead to their pages."""
    return LINK.sub(r"](code/\1.md)", markdown)


def on_page_content(content: str, **_: Any) -> str:
    """Replace TeX by MathML; the number of an equation stands beside it."""
    return EQUATION.sub(lambda found: _mathml(html.unescape(found[2]), found[1] == "div"), content)


def _mathml(tex: str, alone: bool) -> str:
    number = TAG.search(tex)
    shown = convert(TAG.sub("", tex).strip(), display="block" if alone else "inline")
    shown = BOLD.sub(lambda found: f"<mi>{_bold(html.unescape(found[1]))}</mi>", shown)
    beside = f'<div style="text-align: right">({number[1]})</div>' if number else ""
    return f'<div style="overflow: auto hidden">{shown}</div>{beside}' if alone else shown + beside


def _bold(letters: str) -> str:
    return "".join(_bold_letter(letter) for letter in letters)


def _bold_letter(letter: str) -> str:
    for first, bold in BOLD_LETTERS.items():
        if 0 <= ord(letter) - ord(first) < 26:
            return chr(bold + ord(letter) - ord(first))
    return letter

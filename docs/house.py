"""The house in one picture: the rooms of the program, what each is for, and which rooms it uses, read from its imports.

    python docs/house.py

writes docs/figures/house.svg. Rooms stand in the order of the import contract in pyproject.toml: a room uses only rooms
below it. Arcs lead to the rooms that a room uses, but for those that it reaches through another one anyway. Below
what a room is for stand its parts, in the order of its own contract.
"""

from __future__ import annotations

import ast
import sys
import tomllib
from html import escape
from pathlib import Path
from textwrap import wrap

import grimp

PROJECT = Path(__file__).parents[1]
PICTURE = PROJECT / "docs" / "figures" / "house.svg"
PACKAGE = "orchestrator"
ROW, LINE, LEFT, NAME, WIDTH, ARC = 26, 14, 110, 150, 1090, 18.0
"""sizes in px: height of a room without parts, of a line of parts, where the names begin, their width, width of the
picture, width of an arc over a room"""
LETTERS = 135
"""letters in a line of parts"""


def floors_of(place: str) -> list[list[str]]:
    """Return the floors of the house or a room from the roof down, each with its parts, as the contract has them."""
    contracts = tomllib.loads((PROJECT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    found = (contract["layers"] for contract in contracts if contract.get("containers") == [place])
    return [layer.split(" | ") for layer in next(found, [])]


def parts(room: str) -> list[str]:
    """Return the parts of a room in lines; floors stand between semicolons, packages have a stroke at their end."""
    folder = PROJECT / PACKAGE / room
    floors = floors_of(f"{PACKAGE}.{room}") or [sorted(path.stem for path in folder.glob("[!_]*.py"))]
    named = [[f"{name}/" if (folder / name).is_dir() else name for name in floor] for floor in floors]
    return wrap("; ".join(", ".join(floor) for floor in named), LETTERS)


def purpose(room: str) -> str:
    """Return the first sentence of what a room says of itself."""
    place = PROJECT / PACKAGE / room
    file = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
    said = ast.get_docstring(ast.parse(file.read_text())) or ""
    return " ".join(said.split("\n\n")[0].split())


def uses(names: list[str]) -> dict[str, set[str]]:
    """Return the rooms that each room imports, without those that it reaches through another one."""
    graph = grimp.build_graph(PACKAGE)
    for name in names:
        graph.squash_module(f"{PACKAGE}.{name}")
    direct = {
        name: {
            found.removeprefix(f"{PACKAGE}.") for found in graph.find_modules_directly_imported_by(f"{PACKAGE}.{name}")
        }
        & set(names) - {name}
        for name in names
    }
    reach: dict[str, set[str]] = {}
    for name in reversed(names):
        reach[name] = direct[name].union(*(reach[below] for below in direct[name]))
    return {name: {n for n in direct[name] if not any(n in reach[m] for m in direct[name])} for name in names}


def drawn() -> str:
    """Return the picture as SVG."""
    floors = floors_of(PACKAGE)
    names = [name for floor in floors for name in floor]
    below_each = {name: parts(name) for name in names}
    tall = {name: ROW + LINE * len(below_each[name]) for name in names}
    middle = {name: ROW + sum(tall[above] for above in names[:row]) for row, name in enumerate(names)}
    lines = []
    for row, floor in enumerate(floors):
        top, height = middle[floor[0]] - ROW / 2, sum(tall[name] for name in floor)
        shade = "#f4f4f0" if row % 2 else "#e8ece6"
        lines.append(f'<rect x="{LEFT}" y="{top:g}" width="{WIDTH - LEFT - 10}" height="{height}" fill="{shade}"/>')
    for name, used in uses(names).items():
        for below in sorted(used, key=names.index):
            begin, end = middle[name] + 3, middle[below] - 3
            bulge = LEFT - ARC * (names.index(below) - names.index(name))
            path = f"M {LEFT} {begin:g} C {bulge:g} {begin:g}, {bulge:g} {end:g}, {LEFT} {end:g}"
            lines.append(f'<path d="{path}" fill="none" stroke="#5a6f8c" stroke-width="1" marker-end="url(#arrow)"/>')
    for name in names:
        at = f'y="{middle[name] + 4:g}"'
        lines.append(f'<text x="{LEFT + 8}" {at} font-weight="bold">{name}</text>')
        lines.append(f'<text x="{LEFT + NAME}" {at}>{escape(purpose(name))}')
        step = f'<tspan x="{LEFT + NAME}" dy="{LINE}" font-size="11" fill="#555555">'
        lines[-1] += "".join(f"{step}{escape(text)}</tspan>" for text in below_each[name]) + "</text>"
    height = ROW + sum(tall.values())
    marker = '<marker id="arrow" viewBox="0 0 6 6" refX="6" refY="3" markerWidth="6" markerHeight="6" orient="auto">'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" viewBox="0 0 {WIDTH} {height}"'
    return "\n".join(
        [
            f'{head} font-family="sans-serif" font-size="12">',
            f'<defs>{marker}<path d="M 0 0 L 6 3 L 0 6 z" fill="#5a6f8c"/></marker></defs>',
            f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
            *lines,
            "</svg>\n",
        ]
    )


def main() -> None:
    """Write the picture."""
    sys.path.insert(0, str(PROJECT))  # the package is read where it stands, installed or not
    PICTURE.write_text(drawn())


if __name__ == "__main__":
    main()

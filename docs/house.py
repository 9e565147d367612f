"""The house in one picture: the rooms of the program, what each is for, and which rooms it uses, read from its imports.

    python docs/house.py

writes docs/figures/house.svg. Rooms stand in the order of the import contract in pyproject.toml: a room uses only rooms
below it. Arcs lead to the rooms that a room uses, but for those that it reaches through another one anyway.
"""

from __future__ import annotations

import ast
import sys
import tomllib
from html import escape
from pathlib import Path

import grimp

PROJECT = Path(__file__).parents[1]
PICTURE = PROJECT / "docs" / "figures" / "house.svg"
PACKAGE = "orchestrator"
ROW, LEFT, NAME, WIDTH, ARC = 26, 260, 150, 1240, 9.0
"""sizes in px: height of a row, where the names begin, their width, width of the picture, width of an arc over a row"""


def rooms() -> list[list[str]]:
    """Return the floors of the house from the roof down, each with its rooms, as the import contract has them."""
    contracts = tomllib.loads((PROJECT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    layers = next(contract["layers"] for contract in contracts if contract["type"] == "layers")
    return [layer.split(" | ") for layer in layers]


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
    floors = rooms()
    names = [name for floor in floors for name in floor]
    middle = {name: ROW * (row + 1.0) for row, name in enumerate(names)}
    lines = []
    for row, floor in enumerate(floors):
        top, height = middle[floor[0]] - ROW / 2, ROW * len(floor)
        shade = "#f4f4f0" if row % 2 else "#e8ece6"
        lines.append(f'<rect x="{LEFT}" y="{top:g}" width="{WIDTH - LEFT - 10}" height="{height}" fill="{shade}"/>')
    for name, used in uses(names).items():
        for below in sorted(used, key=names.index):
            begin, end = middle[name] + 3, middle[below] - 3
            bulge = LEFT - ARC * (end - begin) / ROW
            path = f"M {LEFT} {begin:g} C {bulge:g} {begin:g}, {bulge:g} {end:g}, {LEFT} {end:g}"
            lines.append(f'<path d="{path}" fill="none" stroke="#5a6f8c" stroke-width="1" marker-end="url(#arrow)"/>')
    for name in names:
        at = f'y="{middle[name] + 4:g}"'
        lines.append(f'<text x="{LEFT + 8}" {at} font-weight="bold">{name}</text>')
        lines.append(f'<text x="{LEFT + NAME}" {at}>{escape(purpose(name))}</text>')
    height = ROW * (len(names) + 1)
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

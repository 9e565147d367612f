"""A wall on its way to its curve, in one picture of four: stones, collapse mechanism, macroblocks, pushover curves.

    python docs/wall_to_curve.py results/benchmark1

writes docs/figures/wall_to_curve.png from the pictures of that run folder.
"""

from __future__ import annotations

import sys
from pathlib import Path

from PIL import Image

PICTURES = ("blocks", "mechanism", "macroblocks", "curves")
HEIGHT, GAP, COLOURS = 420, 24, 128
"""height of the pictures and space between them, px; colours of the palette"""


def main(run: Path, target: Path) -> None:
    """Scale the pictures to one height and put them side by side."""
    found = [Image.open(run / "figures" / f"{name}.png").convert("RGB") for name in PICTURES]
    scaled = [one.resize((round(one.width * HEIGHT / one.height), HEIGHT), Image.Resampling.LANCZOS) for one in found]
    width = sum(one.width for one in scaled) + GAP * (len(scaled) - 1)
    sheet = Image.new("RGB", (width, HEIGHT), "white")
    left = 0
    for one in scaled:
        sheet.paste(one, (left, 0))
        left += one.width + GAP
    sheet.quantize(COLOURS).save(target, optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(__file__).parent / "figures" / "wall_to_curve.png")

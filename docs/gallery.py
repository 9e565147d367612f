"""The pictures of gallery.md: runs the commands of that page, each as it stands there, and keeps one picture of each.

    python docs/gallery.py [NAME ...]

All take a quarter of an hour on a busy machine; results go to results/gallery, pictures to docs/figures/gallery.
"""

from __future__ import annotations

import re
import shlex
import sys
from pathlib import Path

from PIL import Image

from orchestrator.app.cli import main as orchestrator

DOCS = Path(__file__).parent
CALL = "    .venv/bin/python -m orchestrator "
WIDTH, COLOURS = 900, 128
"""of a picture, px, and of its palette"""


def entries(page: str) -> dict[str, tuple[list[str], Path]]:
    """Return by the name of its picture each wall's command and the picture that it leaves, named in the alternative
    text: ![wall: picture](figures/gallery/name.png)."""
    found = {}
    for section in page.split("\n## ")[1:]:
        command = re.search(rf"^{re.escape(CALL)}(.+)$", section, re.M)
        image = re.search(r"!\[.*\]\(figures/gallery/(\w+)\.png\)\n<!-- (\S+) -->", section)
        if command and image:
            found[image[1]] = (shlex.split(command[1]), Path(image[2]))
    return found


def keep(picture: Path, target: Path) -> None:
    """Make a picture of a run small enough for a page."""
    image = Image.open(picture).convert("RGB")
    image = image.resize((WIDTH, round(image.height * WIDTH / image.width)), Image.Resampling.LANCZOS)
    target.parent.mkdir(exist_ok=True)
    image.quantize(COLOURS, Image.Quantize.FASTOCTREE).save(target, optimize=True)


def main(wanted: list[str]) -> None:
    """Run the walls `wanted`, all without any."""
    for name, (command, picture) in entries((DOCS / "gallery.md").read_text(encoding="utf-8")).items():
        if not wanted or name in wanted:
            print(f"== {name}: {shlex.join(command)}", flush=True)
            if orchestrator([*command, *["--force"] * (command[0] in ("run", "import"))]) not in (0, 3):
                sys.exit(f"{name} failed")
            keep(picture, DOCS / "figures" / "gallery" / f"{name}.png")


if __name__ == "__main__":
    main(sys.argv[1:])

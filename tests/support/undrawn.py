"""Runs whose pictures nobody looks at: they are laid out and drawn for half of the time of a small run."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

import pytest
from PIL import Image

from orchestrator.basis.atomic_files import write_bytes
from orchestrator.present.plots import canvas


@contextmanager
def undrawn() -> Iterator[None]:
    """Within it every picture is one white point, in both its files."""
    point = BytesIO()
    Image.new("1", (1, 1), 1).save(point, "png")
    contents = {"png": point.getvalue(), "svg": b'<svg xmlns="http://www.w3.org/2000/svg" width="1" height="1"/>'}

    def saved(_: object, folder: Path, name: str, *__: object) -> list[Path]:
        paths = [folder / f"{name}.{kind}" for kind in contents]
        for path, content in zip(paths, contents.values(), strict=True):
            write_bytes(path, content)
        return paths

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(canvas, "save", saved)
        yield


if __name__ == "__main__":  # python -m tests.support.undrawn run ...: the program, for numbers on several ranks
    from orchestrator.app.cli import main

    with undrawn():
        sys.exit(main())

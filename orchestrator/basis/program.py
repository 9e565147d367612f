"""Which program this is: version, commit, sources. Works in a clone, in an archive without git, and from a wheel."""

from __future__ import annotations

import hashlib
import subprocess
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
COMMIT = PACKAGE / "commit.txt"
"""git archive (.gitattributes) and the wheel (setup.py) write the commit into it"""
PRESENTATION = (
    "app/cli.py", "app/commands.py", "app/wall_commands.py", "app/study_runs.py", "present/tables.py",
    "present/answer.py", "present/plots", "present/page",
)  # fmt: skip
"""sources that no number depends on"""


@cache
def program() -> dict[str, str]:
    """Return version, commit ("+changes" where the clone differs from it) and hash of the sources; what is unknown is
    left out."""
    identity = {}
    with suppress(PackageNotFoundError):  # sources that are not installed
        identity["orchestrator"] = version("orchestrator")
    if known := commit():
        identity["commit"] = known
    return identity | {"sources": sources()[:12]}


def commit() -> str:
    """Return the commit of the sources, "" where neither git nor the package knows it."""
    if (PACKAGE.parent / ".git").exists():
        command = [
            "git",
            "-C",
            str(PACKAGE.parent),
            "describe",
            "--always",
            "--exclude=*",
            "--abbrev=12",
            "--dirty=+changes",
        ]
        try:
            return subprocess.run(command, capture_output=True, text=True, check=True, timeout=10).stdout.strip()
        except (OSError, subprocess.SubprocessError):
            return ""
    text = COMMIT.read_text(encoding="ascii").strip() if COMMIT.exists() else ""
    return "" if text.startswith("$") else text[:12]


@cache
def sources() -> str:
    """Return a hash of the sources that results depend on, by their names and contents."""
    names = sorted(path.relative_to(PACKAGE) for path in PACKAGE.rglob("*.py"))
    total = hashlib.sha256()
    for name in names:
        if not any(name.is_relative_to(place) for place in PRESENTATION):
            total.update(name.as_posix().encode() + b"\0" + hashlib.sha256((PACKAGE / name).read_bytes()).digest())
    return total.hexdigest()

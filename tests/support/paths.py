"""Where things are in a checkout."""

from __future__ import annotations

from pathlib import Path

PROJECT = Path(__file__).parents[2]
DATA = PROJECT / "tests" / "data"

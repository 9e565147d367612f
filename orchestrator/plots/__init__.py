"""Pictures: each function takes values and returns a matplotlib Figure; `save` writes it as PNG and SVG."""

from orchestrator.plots.canvas import save, stamp_not_valid
from orchestrator.plots.pushover import curves, deformed, idealised
from orchestrator.plots.study import (
    Line,
    Panel,
    deformed_panel,
    load_case_curves,
    mechanism_panel,
    panels,
    study_curves,
)
from orchestrator.plots.walls import blocks, macroblocks, mechanism

__all__ = [
    "Line",
    "Panel",
    "blocks",
    "curves",
    "deformed",
    "deformed_panel",
    "idealised",
    "load_case_curves",
    "macroblocks",
    "mechanism",
    "mechanism_panel",
    "panels",
    "save",
    "stamp_not_valid",
    "study_curves",
]

"""Pictures: each function takes values and returns a matplotlib Figure; `save` writes it as PNG and SVG."""

from orchestrator.plots.canvas import save, stamp_not_valid
from orchestrator.plots.pushover import curves, deformed, idealised
from orchestrator.plots.study import Panel, deformed_panel, mechanism_panel, panels, study_curves
from orchestrator.plots.walls import blocks, macroblocks, mechanism

__all__ = [
    "Panel",
    "blocks",
    "curves",
    "deformed",
    "deformed_panel",
    "idealised",
    "macroblocks",
    "mechanism",
    "mechanism_panel",
    "panels",
    "save",
    "stamp_not_valid",
    "study_curves",
]

"""Pictures: each function takes values and returns a matplotlib Figure; `save` writes it as PNG and SVG."""

from orchestrator.plots.canvas import save
from orchestrator.plots.pushover import curves, deformed
from orchestrator.plots.walls import blocks, macroblocks, mechanism

__all__ = ["blocks", "curves", "deformed", "macroblocks", "mechanism", "save"]

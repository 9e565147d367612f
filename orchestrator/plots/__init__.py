"""Pictures: each function takes values and returns a matplotlib Figure; `save` writes it as PNG and SVG.

matplotlib takes a tenth of the time of `limit` to load: it is when the first picture is drawn.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from orchestrator.plots.canvas import save, stamp_not_valid
    from orchestrator.plots.first_page import given
    from orchestrator.plots.pushover import curves, deformed, idealised
    from orchestrator.plots.seismic import verification
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
    "given",
    "idealised",
    "load_case_curves",
    "macroblocks",
    "mechanism",
    "mechanism_panel",
    "panels",
    "save",
    "stamp_not_valid",
    "study_curves",
    "verification",
]


def __getattr__(name: str) -> Any:
    """Load the module that has the function (PEP 562)."""
    if name in __all__:
        for module in ("canvas", "first_page", "pushover", "seismic", "study", "walls"):
            if hasattr(found := import_module(f"{__name__}.{module}"), name):
                return getattr(found, name)
    raise AttributeError(f"module {__name__} has no {name}")

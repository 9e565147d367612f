"""Pictures: each function takes values and returns a matplotlib Figure; `save` writes it as PNG and SVG.

matplotlib takes a tenth of the time of `limit` to load: it is when the first picture is drawn.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from orchestrator.present.plots.canvas import save, stamp_not_valid
    from orchestrator.present.plots.collapse_dxf import mechanism_dxf
    from orchestrator.present.plots.first_page import given
    from orchestrator.present.plots.pushover_pictures import curves, deformed, idealised, rigid_pushover
    from orchestrator.present.plots.seismic_pictures import verification
    from orchestrator.present.plots.sensitivity_pictures import fragility_curve, tornado
    from orchestrator.present.plots.study_pictures import (
        ModelCurve,
        SmallWall,
        deformed_panel,
        load_case_curves,
        mechanism_panel,
        panels,
        study_curves,
    )
    from orchestrator.present.plots.wall_pictures import blocks, macroblocks, mechanism

__all__ = [
    "ModelCurve",
    "SmallWall",
    "blocks",
    "curves",
    "deformed",
    "deformed_panel",
    "fragility_curve",
    "given",
    "idealised",
    "load_case_curves",
    "macroblocks",
    "mechanism",
    "mechanism_dxf",
    "mechanism_panel",
    "panels",
    "rigid_pushover",
    "save",
    "stamp_not_valid",
    "study_curves",
    "tornado",
    "verification",
]


MODULES = (
    "canvas", "collapse_dxf", "first_page", "pushover_pictures", "seismic_pictures", "sensitivity_pictures",
    "study_pictures", "wall_pictures",
)  # fmt: skip


def __getattr__(name: str) -> Any:
    """Load the module that has the function (PEP 562)."""
    if name in __all__:
        for module in MODULES:
            if hasattr(loaded := import_module(f"{__name__}.{module}"), name):
                return getattr(loaded, name)
    raise AttributeError(f"module {__name__} has no {name}")

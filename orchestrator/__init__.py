"""Pushover analysis of historic masonry, stone by stone: micro limit analysis, macroblocks, FE contact.

From Python every stage is a function of the values before it:

    from orchestrator import analyse, find_joints, macroblocks_of, push, read_blocks

    assemblage = find_joints(read_blocks(Path("wall.json")), JointSettings())
    analysis = analyse(assemblage)
    partition = macroblocks_of(assemblage, analysis)
    pushed = push(assemblage, analysis, partition)

Complete examples are in docs/examples. A name is imported when it is first used: before the pushover neither finite
elements nor a mesh generator are needed.
"""

from importlib import import_module
from typing import Any

PUBLIC = {
    "app.pushed": ("Pushed", "push"),
    "app.refining": ("push_and_refine",),
    "assessment.capacity": ("Capacity", "find_capacity"),
    "basis.errors": ("CaseError", "CollapseError", "ConvergenceError", "ResultError"),
    "limit_analysis": (
        "LimitAnalysis", "LimitAnalysisSettings", "LimitState", "Mechanism", "analyse", "centres_of_rotation", "settle",
    ),
    "loads": ("DeadLoad", "LiveLoad", "LoadCase", "LoadSettings", "Loads", "load_cases", "loads_on"),
    "macroblocks.automatic": ("macroblocks_of",),
    "macroblocks.bodies": ("Bodies", "Body", "make_bodies"),
    "macroblocks.criteria": (
        "MacroblockSettings", "Partition", "merged", "one_body", "one_body_per_block", "partition_of",
    ),
    "masonry.interfaces": ("Interfaces",),
    "masonry.joints": ("Assemblage", "JointClass", "JointSettings", "check_assemblage", "find_joints"),
    "masonry.sources.block_files": ("read_blocks",),
    "masonry.wall": ("Block", "Wall", "check_wall"),
    "present.plots.pushover_pictures": ("plot_curves", "plot_deformed"),
    "present.plots.wall_pictures": ("plot_blocks", "plot_macroblocks", "plot_mechanism"),
    "pushover.increments": ("ContactStatus", "Increment", "PushoverCurve"),
    "pushover.meshing": ("BodyMeshes", "MeshSettings", "mesh_bodies"),
    "pushover.path.curve": ("pushover_increments",),
    "pushover.settings": ("ContactSettings", "ElasticSettings", "NewtonSettings", "SteppingSettings"),
    "settings.case": ("Case", "read_case", "read_wall"),
    "storage.stored_run": ("StoredModel", "StoredRun", "read_run"),
    "storage.summary": ("PushoverSummary", "Summary", "read_summary"),
}  # fmt: skip
"""module -> its public names"""
RENAMED = {
    "read_case": "read", "plot_blocks": "blocks", "plot_macroblocks": "macroblocks", "plot_mechanism": "mechanism",
    "plot_curves": "curves", "plot_deformed": "deformed",
}  # fmt: skip
"""public name -> its name in its module, where that is another"""

MODULE_OF = {name: module for module, names in PUBLIC.items() for name in names}

__all__ = sorted(MODULE_OF)


def __getattr__(name: str) -> Any:
    if name not in MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = import_module(f"{__name__}.{MODULE_OF[name]}")
    value = globals()[name] = getattr(module, RENAMED.get(name, name))
    return value


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})

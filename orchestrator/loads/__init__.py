"""What acts on the blocks: dead and live loads, load cases, their forces at the centroids."""

from orchestrator.loads.block_loads import LiveLoad, LoadCase, Loads, LoadSettings, loads_on
from orchestrator.loads.dead_loads import DeadLoad
from orchestrator.loads.load_cases import load_cases

__all__ = [
    "DeadLoad",
    "LiveLoad",
    "LoadCase",
    "LoadSettings",
    "Loads",
    "load_cases",
    "loads_on",
]

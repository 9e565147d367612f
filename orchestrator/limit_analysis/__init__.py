"""Micro limit analysis: rigid blocks, Coulomb joints, linear programs."""

from orchestrator.limit_analysis.analysis import analyse
from orchestrator.limit_analysis.dead_loads import DeadLoad
from orchestrator.limit_analysis.loads import LiveLoad, LoadCase, Loads, LoadSettings, load_cases, loads_on
from orchestrator.limit_analysis.mechanism import centres_of_rotation
from orchestrator.limit_analysis.sequence import LimitAnalysisSettings
from orchestrator.limit_analysis.settlement import settle
from orchestrator.limit_analysis.state import LimitAnalysis, LimitState, LinearProgramRecord, Mechanism

__all__ = [
    "DeadLoad",
    "LimitAnalysis",
    "LimitAnalysisSettings",
    "LimitState",
    "LinearProgramRecord",
    "LiveLoad",
    "LoadCase",
    "LoadSettings",
    "Loads",
    "Mechanism",
    "analyse",
    "centres_of_rotation",
    "load_cases",
    "loads_on",
    "settle",
]

"""Micro limit analysis: rigid blocks, Coulomb joints, linear programs."""

from orchestrator.limit_analysis.analysis import analyse
from orchestrator.limit_analysis.paper.limit_state import LimitAnalysis, LimitState, LinearProgramRecord, Mechanism
from orchestrator.limit_analysis.paper.mechanism import centres_of_rotation
from orchestrator.limit_analysis.paper.sequence import LimitAnalysisSettings
from orchestrator.limit_analysis.settlement import settle

__all__ = [
    "LimitAnalysis",
    "LimitAnalysisSettings",
    "LimitState",
    "LinearProgramRecord",
    "Mechanism",
    "analyse",
    "centres_of_rotation",
    "settle",
]

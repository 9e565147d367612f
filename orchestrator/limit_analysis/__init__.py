"""Micro limit analysis: rigid blocks, Coulomb joints, linear programs."""

from orchestrator.limit_analysis.analysis import analyse
from orchestrator.limit_analysis.mechanism import centres_of_rotation
from orchestrator.limit_analysis.sequence import LimitAnalysisSettings
from orchestrator.limit_analysis.state import LimitAnalysis, LimitState, LinearProgramRecord, Mechanism

__all__ = [
    "LimitAnalysis",
    "LimitAnalysisSettings",
    "LimitState",
    "LinearProgramRecord",
    "Mechanism",
    "analyse",
    "centres_of_rotation",
]

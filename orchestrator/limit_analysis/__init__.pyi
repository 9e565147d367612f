from .analysis import analyse
from .paper.limit_state import LimitAnalysis, LimitState, LinearProgramRecord, Mechanism
from .paper.mechanism import centres_of_rotation
from .paper.sequence import LimitAnalysisSettings
from .settlement import settle

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

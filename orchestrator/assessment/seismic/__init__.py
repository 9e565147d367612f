"""Seismic verification of a pushover curve (N2) and of a mechanism (kinematic approach)."""

from orchestrator.assessment.seismic.observed import Observed, StoredPushover
from orchestrator.assessment.seismic.seismic_verification import verify
from orchestrator.assessment.seismic.settings import LimitStateSettings, SeismicSettings, limit_states

__all__ = ["LimitStateSettings", "Observed", "SeismicSettings", "StoredPushover", "limit_states", "verify"]

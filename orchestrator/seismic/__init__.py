"""Seismic verification of a pushover curve (N2) and of a mechanism (kinematic approach)."""

from orchestrator.seismic.observed import Observed, Pushover
from orchestrator.seismic.settings import LimitStateSettings, SeismicSettings, limit_states
from orchestrator.seismic.verification import verify

__all__ = ["LimitStateSettings", "Observed", "Pushover", "SeismicSettings", "limit_states", "verify"]

"""Seismic verification of a pushover curve (N2) and of a mechanism (kinematic approach)."""

"""The run folder: every value <-> file. Knows all values; no value knows it. Only one rank may write."""

from orchestrator.results.files import (
    TEMPORARY,
    hash_file,
    logging_to,
    provenance,
    read_json,
    replacing,
    versions,
    write_bytes,
    write_csv,
    write_json,
    write_text,
)
from orchestrator.results.paraview import stress_and_pressure, write_paraview
from orchestrator.results.states import StateStore, load_increments
from orchestrator.results.summary import Effort, effort_of, pushover_summary, summary
from orchestrator.results.values import (
    read_curve,
    write_blocks,
    write_case,
    write_curve,
    write_joints,
    write_limit_analysis,
    write_macroblocks,
    write_summary,
)

__all__ = [
    "TEMPORARY",
    "Effort",
    "StateStore",
    "effort_of",
    "hash_file",
    "load_increments",
    "logging_to",
    "provenance",
    "pushover_summary",
    "read_curve",
    "read_json",
    "replacing",
    "stress_and_pressure",
    "summary",
    "versions",
    "write_blocks",
    "write_bytes",
    "write_case",
    "write_csv",
    "write_curve",
    "write_joints",
    "write_json",
    "write_limit_analysis",
    "write_macroblocks",
    "write_paraview",
    "write_summary",
    "write_text",
]

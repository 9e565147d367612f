"""The run folder: every value <-> file. Knows all values; no value knows it. Only one rank may write."""

from orchestrator.basis.atomic_files import TEMPORARY, locked, replacing, sweep, write_bytes
from orchestrator.basis.printed import printed
from orchestrator.storage.files import (
    hash_file,
    logging_to,
    provenance,
    read_json,
    versions,
    write_csv,
    write_json,
    write_text,
)
from orchestrator.storage.force_tables import write_forces
from orchestrator.storage.model_geometry import ContactPlaces, read_geometry, write_geometry
from orchestrator.storage.notes import reasons, remarks
from orchestrator.storage.outputs import refuse_overwriting_file, refuse_overwriting_run, try_folder
from orchestrator.storage.paraview import stress_and_pressure, write_paraview
from orchestrator.storage.reading import read_limit_analysis, read_macroblocks
from orchestrator.storage.stored_increments import StateStore, load_increments
from orchestrator.storage.summary import (
    Effort,
    Event,
    PushoverSummary,
    Summary,
    effort_of,
    limit_summary,
    pushover_summary,
    read_summary,
    summary,
    write_summary,
)
from orchestrator.storage.values import (
    read_curve,
    write_blocks,
    write_case,
    write_curve,
    write_joints,
    write_limit_analysis,
    write_macroblocks,
    write_ties,
)

__all__ = [
    "TEMPORARY",
    "ContactPlaces",
    "Effort",
    "Event",
    "PushoverSummary",
    "StateStore",
    "Summary",
    "effort_of",
    "hash_file",
    "limit_summary",
    "load_increments",
    "locked",
    "logging_to",
    "printed",
    "provenance",
    "pushover_summary",
    "read_curve",
    "read_geometry",
    "read_json",
    "read_limit_analysis",
    "read_macroblocks",
    "read_summary",
    "reasons",
    "refuse_overwriting_file",
    "refuse_overwriting_run",
    "remarks",
    "replacing",
    "stress_and_pressure",
    "summary",
    "sweep",
    "try_folder",
    "versions",
    "write_blocks",
    "write_bytes",
    "write_case",
    "write_csv",
    "write_curve",
    "write_forces",
    "write_geometry",
    "write_joints",
    "write_json",
    "write_limit_analysis",
    "write_macroblocks",
    "write_paraview",
    "write_summary",
    "write_text",
    "write_ties",
]

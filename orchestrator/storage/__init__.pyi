from .clearing import clear, remove_picture, remove_recorded, remove_what_some_have
from .effort import Effort, Event, effort_of
from .files import (
    hash_file,
    logging_to,
    provenance,
    read_json,
    versions,
    write_csv,
    write_json,
    write_text,
)
from .force_tables import write_forces, write_rigid_curve
from .model_geometry import ContactPlaces, read_geometry, write_geometry
from .notes import counts, reasons, remarks
from .outputs import holds_run, refuse_input, refuse_overwriting_run, refuse_run, try_file, try_folder
from .paraview import stress_and_pressure, write_paraview
from .parts import parts_in, refuse_other_parts
from .placing import Source, held, placed, refuse_other_points
from .reading import read_limit_analysis, read_macroblocks
from .stored_increments import IN_MEMORY, StateStore
from .summary import (
    AtPeak,
    PushoverSummary,
    Summary,
    limit_summary,
    read_summary,
    summarise,
    write_summary,
)
from .values import (
    read_curve,
    read_ties,
    write_blocks,
    write_case,
    write_curve,
    write_joints,
    write_limit_analysis,
    write_macroblocks,
    write_ties,
)

__all__ = [
    "IN_MEMORY",
    "AtPeak",
    "ContactPlaces",
    "Effort",
    "Event",
    "PushoverSummary",
    "Source",
    "StateStore",
    "Summary",
    "clear",
    "counts",
    "effort_of",
    "hash_file",
    "held",
    "holds_run",
    "limit_summary",
    "logging_to",
    "parts_in",
    "placed",
    "provenance",
    "read_curve",
    "read_geometry",
    "read_json",
    "read_limit_analysis",
    "read_macroblocks",
    "read_summary",
    "read_ties",
    "reasons",
    "refuse_input",
    "refuse_other_parts",
    "refuse_other_points",
    "refuse_overwriting_run",
    "refuse_run",
    "remarks",
    "remove_picture",
    "remove_recorded",
    "remove_what_some_have",
    "stress_and_pressure",
    "summarise",
    "try_file",
    "try_folder",
    "versions",
    "write_blocks",
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
    "write_rigid_curve",
    "write_summary",
    "write_text",
    "write_ties",
]

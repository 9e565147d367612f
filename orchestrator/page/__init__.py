"""report.html: one self-contained page, made from the files of a run folder alone."""

from orchestrator.page.contents import bilinear_of
from orchestrator.page.stored import StoredModel, StoredRun, read_run
from orchestrator.page.verdict import verdict_of, write_verdict
from orchestrator.page.writing import write, write_index

__all__ = ["StoredModel", "StoredRun", "bilinear_of", "read_run", "verdict_of", "write", "write_index", "write_verdict"]

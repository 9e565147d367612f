"""report.html: one self-contained page, made from the files of a run folder alone."""

from orchestrator.present.page.contents import bilinear_of
from orchestrator.present.page.verdict_page import verdict_of, write_verdict
from orchestrator.present.page.writing import write, write_index

__all__ = ["bilinear_of", "verdict_of", "write", "write_index", "write_verdict"]

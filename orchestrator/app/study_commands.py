"""Commands that run a wall many times: study, sensitivity. They print."""

from __future__ import annotations

import argparse
import logging
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console

from orchestrator import storage
from orchestrator.app import driver, load_cases, sensitivity_runs, study_runs
from orchestrator.app.terminal import Reporter
from orchestrator.assessment.sensitivity import UNITS, ranges
from orchestrator.basis.installed import refuse_missing
from orchestrator.basis.parallel import is_root, on_root
from orchestrator.present import tables
from orchestrator.settings import case as cases

if TYPE_CHECKING:
    from mpi4py import MPI


def study(options: argparse.Namespace, case: cases.Case, comm: MPI.Intracomm | None, console: Console) -> int:
    """Run the tolerance study; return the exit code."""
    load_cases.refuse_several(case, "study")
    cases.refuse_ties(case, "study")
    output = options.output or Path("results") / f"{options.case.stem}-study"
    on_root(comm, storage.try_folder, output)
    on_root(comm, storage.refuse_run, output)
    on_root(comm, load_cases.refuse_run, case)
    logging.getLogger("orchestrator").propagate = False
    with Reporter(console) as report:
        outcome = study_runs.study(case, output, comm, report, options.force)
    if outcome is None:
        return 0
    console.print(tables.study_table(case.name, outcome.rows))
    console.print(f"table: {output / 'table.csv'}; pictures: {output / 'figures'}", soft_wrap=True)
    if is_root(comm):
        for complaint in outcome.complaints:
            print(complaint, file=sys.stderr)
    return 3 if outcome.complaints else 0


def sensitivity(options: argparse.Namespace, case: cases.Case, comm: MPI.Intracomm | None, console: Console) -> int:
    """Run the ranges of [sensitivity]; return the exit code."""
    if case.sensitivity.analysis != "limit":
        refuse_missing("sensitivity")
    output = options.output or Path("results") / f"{options.case.stem}-sensitivity"
    on_root(comm, storage.try_folder, output)
    on_root(comm, storage.refuse_run, output)
    logging.getLogger("orchestrator").propagate = False
    with Reporter(console) as report:
        outcome = sensitivity_runs.sensitivity(case, output, comm, report, options.force)
    if outcome is None:
        return 0
    console.print(tables.sensitivity_table(case.name, outcome.quantity, outcome.base, outcome.kind, outcome.bars))
    for said in (*made_alike(case), *sensitivity_runs.words(outcome)):
        console.print(said, soft_wrap=True)
    console.print(f"points: {output / 'sensitivity.csv'}; pictures: {output / 'figures'}", soft_wrap=True)
    return 0


def made_alike(case: cases.Case) -> list[str]:
    """Return a warning of every range that is of all joints, or blocks, though these differ in the case as given."""
    assemblage, said = driver.check(case), list[str]()
    weights = np.array([block.unit_weight for block in assemblage.wall.blocks if not block.fixed])
    for name in ranges(case.sensitivity):
        given = weights if name == "unit_weight" else getattr(assemblage.joints, name, weights[:1])
        factor, unit = UNITS[name]
        low, high = (f"{float(end) * factor:.3g}" for end in (given.min(), given.max()))
        if low != high:
            of_all = "block" if name == "unit_weight" else "joint"
            as_given = f"as given they have {low} to {high} {unit}".rstrip()
            said.append(f"WARNING: sensitivity.{name} is of every {of_all} alike: {as_given}")
    return said


ACTIONS = {"study": study, "sensitivity": sensitivity}

"""Options -> one command; known errors -> one line and an exit code.

Exit codes: 0 done, 1 failed while running, 2 bad input, 3 finished but not valid, 130 interrupted.

What a command works with is imported here, after its case has been read: who is refused does not wait for it.
"""

from __future__ import annotations

import argparse
import gc
import shlex
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from orchestrator.basis.errors import GO_ON, CaseError, ConvergenceError, ResultError
from orchestrator.basis.installed import refuse_missing
from orchestrator.basis.interruption import end_in_order
from orchestrator.basis.parallel import Ending, all_ranks, is_root, on_root, started_as_rank, started_by_launcher

if TYPE_CHECKING:
    from mpi4py import MPI

    from orchestrator.settings.case import Case

PARALLEL = (None, "run", "study", "sensitivity")
"""commands that share their work between ranks; None: the shipped benchmark 1"""
FILES = ("import", "new", "schema", "export", "report")
"""commands that turn files into files"""
IN_SPACE = ("check", "limit")
"""commands that take walls in space"""
SAME_GOES_ON = ("study", "sensitivity")
"""commands that go on where they were interrupted when they are given again"""


def execute(options: argparse.Namespace) -> int:
    """Carry out one command, all ranks together, and return its exit code."""
    parallel = options.command in PARALLEL
    if not parallel and started_as_rank() > 0:
        return 0  # rank 0 does it alone
    comm = all_ranks() if parallel else None
    quiet = not is_root(comm) or getattr(options, "quiet", False)
    console = console_of(quiet=quiet)
    ending = Ending(comm)
    try:
        return ending.together(_carry_out(options, comm, console), "")
    except CaseError as error:
        return ending.together(2, str(error))
    except ResultError as error:
        return ending.together(3, str(error))
    except ConvergenceError as error:
        return ending.together(1, _one_line(str(error)))
    except OSError as error:
        return ending.together(1, _one_line(f"{error.filename or 'file system'}: {error.strerror or error}"))
    except KeyboardInterrupt as stopped:
        return ending.together(130, _interrupted(options, stopped))
    except Exception:  # an error of the program
        return ending.together(1, traceback.format_exc())


def _carry_out(options: argparse.Namespace, comm: MPI.Intracomm | None, console: Console) -> int:
    """Read the case of a command, import what the command works with, and carry it out."""
    _refuse_what_does_not_go_together(options)
    if options.command in FILES:
        gc.enable()
        from orchestrator.app import file_commands

        end_in_order()
        return file_commands.ACTIONS[options.command](options, console)
    if options.command is None:  # nobody asked for it by name
        command = shlex.join(["run", str(options.case), "--output", "results/benchmark1"])
        console.print(
            "No command given: this runs the shipped benchmark 1 into results/benchmark1, as "
            f"`python -m orchestrator {command}` does. --help lists all commands.",
            soft_wrap=True,
        )
    case = _read_case(options, comm)
    if case is None:
        gc.enable()
        return _in_space(options, console)
    from orchestrator.app import study_commands, wall_commands

    if not gc.isenabled():  # __main__.py switched it off
        gc.freeze()
    gc.enable()
    end_in_order()
    actions = wall_commands.ACTIONS | study_commands.ACTIONS
    return actions[options.command](options, case, comm, console)


def _in_space(options: argparse.Namespace, console: Console) -> int:
    """Carry out check or limit of a case in space."""
    from orchestrator import storage
    from orchestrator.app import space_check, space_commands
    from orchestrator.settings.case import record_in

    end_in_order()
    output = options.output or Path("results") / options.case.stem
    if options.command == "limit" and options.json:
        return space_commands.limit(options.case, options.set, output, True, console)
    storage.try_folder(output)
    if options.command == "check":
        return space_check.check(options.case, options.set, output, console)
    record = record_in(options.case, options.set)
    wall = record.get("wall")
    blocks = [options.case.parent / str(wall["blocks"])] if isinstance(wall, dict) and "blocks" in wall else []
    source = storage.Source("limit", record, tuple(dict.fromkeys([options.case, *blocks])))
    with storage.held(output, force=options.force), storage.placed([output], source, options.force):
        return space_commands.limit(options.case, options.set, output, False, console)


def _read_case(options: argparse.Namespace, comm: MPI.Intracomm | None) -> Case | None:
    """Return the case of a command, or None where it is one in space and the command takes such. Raises CaseError."""
    from orchestrator.settings.case import read
    from orchestrator.settings.plane_or_space import refuse_space, spatial

    settles = getattr(options, "settle", None) is not None
    if options.command in IN_SPACE and not settles:
        if spatial(options.case, options.set):
            return None
    else:
        refuse_space(options.case, options.set, "limit --settle" if settles else options.command)
    if options.command in PARALLEL and options.command != "sensitivity":
        refuse_missing(options.command or "run")
    return on_root(comm, read, options.case, options.set)


def _refuse_what_does_not_go_together(options: argparse.Namespace) -> None:
    """Raise CaseError for options of which one would be passed over."""
    if getattr(options, "resume", False) and options.force:
        raise CaseError("--resume", "does not go with --force, which removes what it would go on with", "leave one out")
    if getattr(options, "settle_angle", None) is not None and options.settle is None:
        raise CaseError("--settle-angle", "is of a settlement, and there is none", "give --settle ID with it")


def console_of(**options: Any) -> Console:
    """Return what commands print on: what names hold is printed as it is, in square brackets and between colons too."""
    if started_by_launcher():
        options |= {"force_terminal": False}  # mpirun hands rank 0 a terminal that is none
    return Console(highlight=False, markup=False, emoji=False, **options)


def _interrupted(options: argparse.Namespace, stopped: KeyboardInterrupt) -> str:
    """Return what is said of an interruption: what goes on with what was done, if anything was."""
    if options.command in SAME_GOES_ON:
        return "interrupted; the same command goes on"
    if GO_ON in getattr(stopped, "__notes__", ()) or getattr(options, "resume", False):
        return f"interrupted; {GO_ON}"
    return "interrupted before anything was written" if options.command in (None, "run") else "interrupted"


def _one_line(text: str) -> str:
    """Return a text without line breaks: PETSc's errors have many, names of files may have some."""
    return " ".join(text.split("\n"))

"""Serial stages and failures under two ranks, as mpirun starts them."""

from __future__ import annotations

import subprocess
import sys
from time import monotonic

import pytest

from orchestrator.basis.parallel import is_root, on_root
from tests.support.paths import DATA, PROJECT
from tests.support.ranks import on_ranks

TOWER = str(DATA / "tower_5_blocks.json")


SCRIPT = """
from mpi4py import MPI
from orchestrator.basis.errors import CaseError
from orchestrator.basis.parallel import is_root, on_root

comm = MPI.COMM_WORLD
def value(factor): return factor * (comm.rank + 1)
def failing(): raise CaseError("key", "problem", "remedy", "file")
found = on_root(comm, value, 7)
try:
    on_root(comm, failing)
except CaseError as error:
    said = str(error)
everything = comm.gather((found, said, is_root(comm)))
if is_root(comm):
    print(everything)
"""


def test_without_ranks_the_stage_is_simply_called():
    assert on_root(None, divmod, 7, 2) == (3, 1)
    assert is_root(None)
    with pytest.raises(ZeroDivisionError):
        on_root(None, divmod, 7, 0)


def test_value_and_error_of_rank_0_reach_every_rank():
    done = on_ranks(2, "-c", SCRIPT)
    said = "file: key: problem; remedy"
    assert done.stdout.strip() == str([(7, said, True), (7, said, False)]), done.stderr


def test_serial_commands_are_done_once():
    done = on_ranks(2, "-m", "orchestrator", "check", TOWER)
    assert done.returncode == 0
    assert done.stdout.count("5 blocks, 5 joints") == 1


def test_what_rank_0_refuses_is_said_once(tmp_path):
    (tmp_path / "taken").write_text("a file where the run folder should be")
    done = on_ranks(2, "-m", "orchestrator", "run", TOWER, "--output", str(tmp_path / "taken"))
    assert done.returncode == 2
    assert done.stderr.count("taken: --output: is a file; give a folder") == 1


ALONE = """
import sys
from dataclasses import replace
from mpi4py import MPI
from orchestrator.app import cli
from orchestrator.basis.errors import CaseError, ConvergenceError
from orchestrator.pushover.path import increment_solver
solve, calls = increment_solver.solve_increment, []
def changed(model, system, problem, first, *others):
    return model, system, problem, replace(first, displacement=first.displacement * (1 + 1e-12)), *others
def solved(*arguments):
    calls.append(1)
    if MPI.COMM_WORLD.rank == 1 and len(calls) == 4:
        {what}
    return solve(*arguments)
increment_solver.solve_increment = solved
sys.exit(cli.main(sys.argv[1:]))
"""
FAILURES = {
    "an error of the program": ("raise ValueError('alone')", "ValueError: alone", 1),
    "an error that is known": ("raise CaseError('key', 'alone', 'remedy')", "key: alone; remedy", 2),
    "no room on the disk": ("raise OSError(28, 'No space left', 'alone')", "alone: No space left", 1),
    "no convergence": ("raise ConvergenceError('Newton', 'alone')", "the ranks disagree on the increment", 1),
    "a bit that tips over": ("arguments = changed(*arguments)", "the ranks disagree on the increment", 1),
    "killed": ("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", "signal 9", 137),
}


@pytest.mark.parametrize("kind", FAILURES)
def test_what_one_rank_does_alone_ends_all_within_seconds_with_one_message(kind, tmp_path):
    what, said, code = FAILURES[kind]
    command = ["run", TOWER, "--output", str(tmp_path), "--model", "micro", "--set", "newton.distribute_above=0"]
    began = monotonic()
    done = on_ranks(2, "-c", ALONE.format(what=what), *command)
    assert monotonic() - began < 45, "of which 5 s waiting for the other rank; else it would never end"
    assert (done.returncode, done.stderr.count(said)) == (code, 1), done.stderr
    assert not (tmp_path / "summary.json").exists()


THREADS = """
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from orchestrator import JointSettings, SteppingSettings, analyse, find_joints, one_body_per_block, push, read_blocks

def pushed(displacement):
    done = push(assemblage, analysis, stones, stepping=SteppingSettings(final_displacement=displacement))
    return done.capacity.peak_multiplier

assemblage = find_joints(read_blocks(Path(sys.argv[1])), JointSettings())
analysis, stones = analyse(assemblage), one_body_per_block(assemblage)
with ThreadPoolExecutor(4) as threads:
    together = list(threads.map(pushed, (2e-4, 1e-4, 3e-4)))
print(together == [pushed(2e-4), pushed(1e-4), pushed(3e-4)])
"""


def test_threads_wait_for_each_other_where_libraries_know_one_only():
    """PETSc and gmsh end the process otherwise."""
    command = [sys.executable, "-c", THREADS, DATA / "tower_5_blocks.json"]
    done = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout) == (0, "True\n"), done.stderr


@pytest.mark.parametrize(("command", "ranks"), [("check", 2), ("limit", 1), ("import", 2), ("run", 1)])
def test_what_ranks_print_into_a_file_has_no_escape_codes(tmp_path, command, ranks):
    """mpirun hands rank 0 a terminal, wherever its own output goes."""
    short = ["--model", "macro", "--set", "stepping.final_displacement=0.1mm"] if command == "run" else []
    output = tmp_path / ("wall.json" if command == "import" else "out")
    done = on_ranks(ranks, "-m", "orchestrator", command, TOWER, *short, "--output", output)
    assert done.returncode == 0, done.stderr
    assert "block" in done.stdout
    assert "\x1b" not in done.stdout + done.stderr

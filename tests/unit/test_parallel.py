"""Serial stages and failures under two ranks, as mpirun starts them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from orchestrator.parallel import is_root, on_root

PROJECT = Path(__file__).parents[2]
TOWER = str(PROJECT / "tests" / "data" / "tower_5_blocks.json")
ENVIRONMENT = os.environ | {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMP_NUM_THREADS": "1",
}
SCRIPT = """
from mpi4py import MPI
from orchestrator.errors import CaseError
from orchestrator.parallel import is_root, on_root

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


def two_ranks(*arguments):
    command = ["mpirun", "--oversubscribe", "-n", "2", sys.executable, *arguments]
    return subprocess.run(command, cwd=PROJECT, env=ENVIRONMENT, capture_output=True, text=True, timeout=60)


def test_without_ranks_the_stage_is_simply_called():
    assert on_root(None, divmod, 7, 2) == (3, 1)
    assert is_root(None)
    with pytest.raises(ZeroDivisionError):
        on_root(None, divmod, 7, 0)


def test_value_and_error_of_rank_0_reach_every_rank():
    done = two_ranks("-c", SCRIPT)
    said = "file: key: problem; remedy"
    assert done.stdout.strip() == str([(7, said, True), (7, said, False)]), done.stderr


def test_serial_commands_are_done_once():
    done = two_ranks("-m", "orchestrator", "check", TOWER)
    assert done.returncode == 0
    assert done.stdout.count("5 blocks, 5 joints") == 1


def test_a_rank_that_fails_alone_does_not_leave_the_other_waiting(tmp_path):
    (tmp_path / "taken").write_text("a file where the run folder should be")
    done = two_ranks("-m", "orchestrator", "run", TOWER, "--output", str(tmp_path / "taken"))
    assert done.returncode == 1
    assert done.stderr.count("taken: File exists") == 1

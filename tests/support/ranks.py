"""The program under mpirun, as a user starts it."""

from __future__ import annotations

import os
import subprocess
import sys

from tests.support.paths import PROJECT

ENVIRONMENT = os.environ | {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMP_NUM_THREADS": "1",
}


def on_ranks(ranks: int, *arguments: object, options: tuple[str, ...] = (), seconds: float = 900.0):
    """Run Python with `arguments` on so many ranks, from the project's folder; options: of mpirun."""
    command = ["mpirun", "--oversubscribe", *options, "-n", str(ranks), sys.executable, *map(str, arguments)]
    return subprocess.run(command, cwd=PROJECT, env=ENVIRONMENT, capture_output=True, text=True, timeout=seconds)


def quiet(event: object) -> None:
    """Report nothing, where the program would say what it does."""

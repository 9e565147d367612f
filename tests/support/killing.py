"""Runs that end by SIGKILL, at a chosen file or time, and their curves; for docs/studies/killed.py too."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from tests.support.paths import PROJECT
from tests.support.ranks import ENVIRONMENT

CURVE = ("load_multiplier", "base_shear_N", "control_displacement_m", "internal_energy_J", "dissipated_energy_J")
MORTAL = """
import os, signal, sys
last = sys.argv[1]
def hook(event, arguments):
    if event == "os.rename" and str(arguments[1]).endswith(last):
        os.kill(os.getpid(), signal.SIGKILL)
sys.addaudithook(hook)
from orchestrator.app.cli import main
sys.exit(main(sys.argv[2:]))
"""
"""Ends itself when it is about to give a file its final name."""


def launcher(ranks: int) -> list[str]:
    """Return what starts Python on so many ranks."""
    return [sys.executable] if ranks == 1 else ["mpirun", "--oversubscribe", "-n", str(ranks), sys.executable]


def environment(cache: Path) -> dict[str, str]:
    """Return the environment of a run whose meshes are kept in `cache`, nowhere else."""
    return ENVIRONMENT | {"XDG_CACHE_HOME": str(cache)}


def run(arguments: list[str], cache: Path, ranks: int = 1, seconds: float = 120.0) -> subprocess.CompletedProcess[str]:
    """Run the command line to its end."""
    command = [*launcher(ranks), "-m", "orchestrator", *arguments]
    return subprocess.run(command, cwd=PROJECT, env=environment(cache), capture_output=True, text=True, timeout=seconds)


def killed_at_file(arguments: list[str], cache: Path, name: str, ranks: int = 1) -> int:
    """Run until a file whose path ends in `name` is about to be renamed, SIGKILL; return the exit code."""
    command = [*launcher(ranks), "-c", MORTAL, name, *arguments]
    return subprocess.run(command, cwd=PROJECT, env=environment(cache), capture_output=True, timeout=120).returncode


def killed_after(arguments: list[str], cache: Path, seconds: float, ranks: int = 1) -> int:
    """Run, and SIGKILL everything it started after so many seconds; return the exit code (-9, or of a finished run)."""
    command = [*launcher(ranks), "-m", "orchestrator", *arguments]
    with subprocess.Popen(
        command, cwd=PROJECT, env=environment(cache), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        start_new_session=True,
    ) as process:  # fmt: skip
        try:
            return process.wait(seconds)
        except subprocess.TimeoutExpired:
            for child in [*children(process.pid), process.pid]:  # mpirun gives each rank a group of its own
                os.kill(child, signal.SIGKILL)
            return process.wait()


def children(parent: int) -> list[int]:
    """Return the processes that `parent` has started, and those started by them."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:  # it has ended meanwhile
            continue
        if int(fields[1]) == parent:
            found += [int(path.parent.name), *children(int(path.parent.name))]
    return found


def curve(folder: Path, model: str) -> np.ndarray:
    """Return the columns of CURVE, (s, 5)."""
    table = np.genfromtxt(folder / model / "curve.csv", delimiter=",", names=True)
    return np.column_stack([table[name] for name in CURVE])


def difference(found: np.ndarray, expected: np.ndarray) -> float:
    """Return the largest difference of two curves over the largest value of its column; inf where lengths differ.

    Energies share the scale of the larger one: what friction takes may be nothing but rounding.
    """
    if found.shape != expected.shape:
        return np.inf
    scale = np.max(np.abs(expected), axis=0)
    scale[3:] = scale[3:].max()
    return float(np.max(np.abs(found - expected) / scale))


def moment(folder: Path, model: str) -> str:
    """Return what a killed run was doing, from what it left."""
    if (folder / "summary.json").exists():
        return "done"
    if (folder / model / "curve.csv").exists():
        return "plotting" if (folder / model / "contacts.xdmf").exists() else "writing"
    numbers = sorted(folder.glob(f"{model}/states/[0-9]*.h5"))
    if not numbers:
        return "before the first increment"
    lines = [line for line in (folder / "run.log").read_text().splitlines() if f" {model} " in line]
    phases = [line.split(f" {model} ")[1].split()[1].rstrip(":") for line in lines if "multiplier" in line]
    return phases[-1] if phases else "gravity"


def stage_of_run(folder: Path, logged: str) -> str:
    """Return what the last run into a folder was doing when it was killed; logged: what it added to run.log."""
    lines = logged.splitlines()
    begun = sum(" expected: " in line for line in lines)
    if not begun:
        return "before the finite elements"
    model = ("macro", "micro")[begun - 1]
    if (folder / model / "curve.csv").exists():
        return f"{model}: {moment(folder, model)}"
    done = [line.split(f": {model} ")[1] for line in lines if f": {model} " in line and ": multiplier" in line]
    phases = [text.split()[1].rstrip(":") for text in done]
    return f"{model}: {phases[-1] if phases else 'starting or drawing what was stored'}"


def wait_for(condition, seconds: float) -> bool:
    """Return whether `condition()` came true within so many seconds."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.05)
    return False

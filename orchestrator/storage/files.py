"""Text, JSON and CSV, whole or absent (orchestrator/basis/atomic_files.py). Hashes, versions, run.log."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import logging
import os
import platform
import shlex
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from importlib.metadata import PackageNotFoundError, version
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.basis.atomic_files import write_bytes
from orchestrator.basis.errors import CaseError
from orchestrator.basis.program import program

DISTRIBUTIONS = {
    "numpy": "numpy",
    "scipy": "scipy",
    "shapely": "shapely",
    "clarabel": "clarabel",
    "gmsh": "gmsh",
    "dolfinx": "fenics-dolfinx",
    "petsc": "petsc4py",
    "mpi4py": "mpi4py",
    "meshio": "meshio",
    "matplotlib": "matplotlib",
}
"""name in the run folder -> name of the installed distribution (petsc4py carries PETSc's own version)"""

ENVIRONMENT = (
    "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMPI_COMM_WORLD_SIZE", "SLURM_JOB_ID",
    "SLURM_NTASKS", "PETSC_OPTIONS", "PYTHONHASHSEED", "LANG",
)  # fmt: skip
"""variables that may change speed or the last digits of a result"""


def write_text(path: Path, text: str) -> None:
    """Write `text` in UTF-8 to `path`, whole or not at all."""
    write_bytes(path, text.encode())


def write_json(path: Path, value: Any) -> None:
    """Write `value` as JSON; numpy values become plain ones, numbers that are not finite become null."""
    write_text(path, json.dumps(plain(value), indent=1, allow_nan=False, ensure_ascii=False) + "\n")


def read_json(path: Path) -> Any:
    """Return what `write_json` wrote, or an editor that begins with a byte order mark."""
    return json.loads(path.read_text(encoding="utf-8-sig"))


def write_csv(path: Path, columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Write a header and rows; floats with as many digits as they need to be read back exactly."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([plain(value) for value in row] for row in rows)
    write_text(path, text.getvalue())


def plain(value: Any) -> Any:
    """Return `value` in what JSON knows: dict, list, str, int, float, bool, None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float) and not isfinite(value):
        return None
    return value


def missing(path: Path) -> CaseError:
    """Return what is said of a file that a run has written and that is not there."""
    return CaseError("", "is missing from the folder of this run", "copy it back, or run the case again", str(path))


def hash_file(path: Path) -> str:
    """Return the sha256 of a file's content, in hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def versions() -> dict[str, str]:
    """Return version, commit and sources of the program, the versions of Python and of every library that takes part;
    what is not installed is left out."""
    import h5py  # see hdf5.py

    known = program() | {"python": platform.python_version()}
    known |= {"h5py": h5py.__version__, "hdf5": h5py.version.hdf5_version}
    for name, distribution in DISTRIBUTIONS.items():
        try:
            known[name] = version(distribution)
        except PackageNotFoundError:
            continue
    return known


def provenance(files: Iterable[Path]) -> list[str]:
    """Return what is needed to do a run again: command line, folder, machine, environment, versions, hashes of files.

    Of the environment only ENVIRONMENT is told: the rest may hold what is nobody's business.
    """
    told = {name: os.environ[name] for name in ENVIRONMENT if name in os.environ}
    return [
        f"command: {shlex.join(sys.orig_argv)}",
        f"folder: {Path.cwd()}",
        f"machine: {platform.platform()}, {os.cpu_count()} processors",
        f"environment: {' '.join(f'{name}={shlex.quote(value)}' for name, value in told.items())}",
        f"versions: {', '.join(f'{name} {number}' for name, number in versions().items())}",
        *(f"sha256 of {path}: {hash_file(path)}" for path in files),
    ]


class _LogFile(logging.FileHandler):
    """run.log: what the disk has no room for is left out, without the traceback that `logging` prints by default."""

    def handleError(self, record: logging.LogRecord) -> None:
        pass

    def close(self) -> None:
        with suppress(OSError):
            super().close()


@contextmanager
def logging_to(path: Path) -> Iterator[None]:
    """Append what `orchestrator` logs from INFO on to the file `path` (run.log), and an error that ends it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handler = _LogFile(path, encoding="utf-8")
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))
    handler.setLevel(logging.INFO)
    logger, before = logging.getLogger("orchestrator"), logging.getLogger("orchestrator").level
    logger.setLevel(min(logging.INFO, logger.getEffectiveLevel()))
    logger.addHandler(handler)
    try:
        yield
    except BaseException as error:
        logger.error("stopped by %s: %s", type(error).__name__, error)
        raise
    finally:
        logger.removeHandler(handler)
        logger.setLevel(before)
        handler.close()

"""HDF5 files. Loading h5py takes 0.03 s, which commands that store nothing need not wait for."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import h5py


def hdf5_file(place: Path | BytesIO, mode: Literal["r", "w"] = "r") -> h5py.File:
    """Open a file, or bytes that are one. Raises OSError."""
    import h5py

    return h5py.File(place, mode)

"""`from orchestrator import ...`: every name is there, and none costs more than it needs."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import orchestrator
from orchestrator import MeshSettings, SteppingSettings, make_bodies, one_body_per_block, pushover_curve
from tests.support.pushover_chain import assemblage_of, stack

HEAVY = ("numpy", "dolfinx", "gmsh", "petsc4py", "mpi4py", "pydantic", "h5py", "matplotlib")


def imported_by(statement):
    """Return which of the heavy modules a fresh interpreter has after a statement."""
    program = f"{statement}\nimport sys\nprint(*[name for name in {HEAVY} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return done.stdout.split()


@pytest.mark.parametrize("name", orchestrator.__all__)
def test_every_public_name_is_there_and_has_a_docstring(name):
    assert getattr(orchestrator, name).__doc__
    assert name in dir(orchestrator)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'pushover_kurve'"):
        _ = orchestrator.pushover_kurve


def test_importing_the_package_imports_nothing_else():
    assert imported_by("import orchestrator") == []


def test_commands_start_without_what_only_some_of_them_need():
    assert imported_by("from orchestrator import cli") == ["numpy", "pydantic"]


def test_no_finite_elements_before_the_pushover():
    names = "analyse, find_joints, make_bodies, merged, read_blocks, macroblocks_of"
    assert imported_by(f"from orchestrator import {names}") == ["numpy"]


@pytest.mark.parametrize("direction", [1, -1])
def test_a_slender_block_rocks_at_width_over_height(direction):
    """Overturning about the corner: b/h = 0.2 / 1.0 less u / h and elasticity: no static state exceeds it."""
    assemblage = assemblage_of(stack((0.2, 1.0), friction=0.7))
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    stepping = SteppingSettings(final_displacement=2e-3)
    curve = pushover_curve(bodies, MeshSettings(size=0.1), stepping=stepping, direction=direction)
    peak = curve.static.load_multiplier.max()
    assert peak == pytest.approx(0.2, rel=0.01)
    assert peak <= 0.2 * (1 + stepping.out_of_balance)
    assert curve.stopped_because == "final displacement of 2 mm reached"
    assert np.all(np.diff(curve.step) == 1)

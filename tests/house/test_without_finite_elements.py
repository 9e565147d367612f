"""What needs no finite elements works where they are not installed, and what needs them says what to install."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest

from orchestrator.app import cli
from orchestrator.basis import installed
from orchestrator.basis.errors import CaseError
from tests.support.paths import DATA, PROJECT

TOWER = DATA / "tower_5_blocks.json"
WITHOUT = """
import sys
from importlib.abc import MetaPathFinder

class Absent(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("dolfinx", "petsc4py", "mpi4py", "gmsh", "ufl", "basix", "ffcx"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Absent())
from orchestrator.app import cli
sys.exit(cli.main(sys.argv[1:]))
"""


def without_finite_elements(folder, *arguments):
    """Run a command in a Python that has no finite elements and no mesh generator; return exit code and output."""
    command = [sys.executable, "-c", WITHOUT, *map(str, arguments)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


def test_the_stand_in_for_an_empty_python_is_empty(tmp_path):
    """The detector: the same stand-in refuses what every command below is said not to import."""
    program = WITHOUT.replace("from orchestrator.app import cli", "import dolfinx")
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert "No module named 'dolfinx'" in done.stderr


def test_limit_finds_the_tower_s_multiplier(tmp_path):
    """Five blocks on each other, 1 m high, 0.2 m wide: they topple about the corner of the lowest at b / h = 0.2."""
    code, printed, complaint = without_finite_elements(tmp_path, "limit", TOWER, "--json")
    assert (code, complaint) == (0, "")
    assert json.loads(printed)["associative"] == pytest.approx(0.2, abs=1e-6)


@pytest.mark.parametrize(
    ("arguments", "left"),
    [
        (("check", TOWER, "--output", "look"), "look/figures/blocks.png"),
        (("limit", TOWER, "--output", "found"), "found/figures/mechanism.png"),
        (("segment", TOWER), ""),
        (("import", PROJECT / "templates" / "wall1.txt", "--output", "wall.json"), "wall.json"),
        (("new", "mine"), "mine.toml"),
        (("limit", PROJECT / "templates" / "uwall.toml", "--json"), ""),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else "",
)
def test_light_commands(tmp_path, arguments, left):
    code, _, complaint = without_finite_elements(tmp_path, *arguments)
    assert (code, complaint) == (0, "")
    assert (tmp_path / left).exists()


def test_the_report_of_a_run_that_another_machine_made(tmp_path):
    settings = ["--set", "stepping.final_displacement=0.1mm", "--set", "run.models=['macro']", "-q"]
    assert cli.main(["run", str(TOWER), "--output", str(tmp_path / "run"), *settings]) == 0
    written = tmp_path / "run" / "report.html"
    before = written.read_bytes()
    figures = {path.stem for path in (tmp_path / "run" / "figures").iterdir()}
    assert "macro_end" in figures
    assert "macro_peak" not in figures, "the curve ends at its largest base shear: one picture, not two that are alike"
    assert b"at its end, with the largest base shear" in before
    written.unlink()
    code, printed, complaint = without_finite_elements(tmp_path, "report", "run")
    assert (code, printed.splitlines()[-1], complaint) == (0, "run/report.html", "")  # slow ones tell progress
    assert np.isclose(len(written.read_bytes()), len(before), rtol=1e-3, atol=0.0)


@pytest.mark.parametrize("command", ["run", "study"])
def test_the_pushover_says_what_to_install_before_it_begins(tmp_path, command):
    code, printed, complaint = without_finite_elements(tmp_path, command, TOWER, "--output", "out")
    assert (code, printed) == (2, "")
    assert complaint.startswith(f"orchestrator: {command} needs dolfinx, petsc4py, mpi4py, gmsh, not installed here; ")
    assert "make setup" in complaint
    assert complaint.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "arguments", [("export", TOWER), ("import", "solid.step", "--output", "wall.json")], ids=["export", "step"]
)
def test_meshes_and_solids_ask_for_the_mesh_generator(tmp_path, arguments):
    (tmp_path / "solid.step").write_text("ISO-10303-21;")
    code, _, complaint = without_finite_elements(tmp_path, *arguments)
    assert code == 2
    assert "needs gmsh, not installed here; install gmsh (pip install gmsh)" in complaint


def test_a_second_hdf5_is_refused(tmp_path, monkeypatch):
    """PyPI's h5py comes with libraries in h5py.libs beside it; Debian's and conda's have none."""
    (tmp_path / "h5py").mkdir()
    (tmp_path / "h5py" / "__init__.py").write_text("")
    for module in [name for name in sys.modules if name.partition(".")[0] == "h5py"]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.syspath_prepend(str(tmp_path))
    installed.refuse_missing("run")
    (tmp_path / "h5py.libs").mkdir()
    with pytest.raises(CaseError, match="pip uninstall h5py"):
        installed.refuse_missing("run")

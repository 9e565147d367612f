"""What a run will need is known before it starts, and refused where the machine has less."""

from __future__ import annotations

import csv
import ctypes
import gc

import numpy as np
import pytest

from orchestrator.app import driver
from orchestrator.app.cli import main
from orchestrator.app.progress import IncrementDone
from orchestrator.basis.errors import CaseError, ConvergenceError
from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.pushover import estimate
from orchestrator.pushover.contact.contact_search import find_contacts
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies
from orchestrator.settings import case as cases
from orchestrator.storage.stored_increments import IN_MEMORY
from tests.support.paths import DATA, PROJECT

BENCHMARKS = PROJECT / "benchmarks"
WALL = DATA / "ferris_tinloi_wall1.json"


@pytest.fixture(scope="module")
def bodies():
    assemblage = find_joints(read_blocks(WALL), JointSettings())
    return make_bodies(assemblage, one_body_per_block(assemblage))


@pytest.mark.parametrize(
    "settings",
    [MeshSettings(), MeshSettings(0.08), MeshSettings(0.05, 2), MeshSettings(0.03), MeshSettings(0.03, growth=0.2)],
)
def test_unknowns_are_known_within_a_factor_of_two_before_meshing(bodies, settings):
    meshes = mesh_bodies(bodies, settings, None)
    in_front = meshes.nodes[:, 2] <= 0.5 * meshes.nodes[:, 2].max()
    unknowns = 3 * in_front.sum() + in_front[find_contacts(bodies, meshes).slave_node].sum() + 1
    assert 0.5 < estimate.estimate(bodies, settings).unknowns / unknowns < 2.0


@pytest.mark.parametrize(
    ("size", "layers", "megabytes"), [(0.2, 1, 163), (0.05, 1, 217), (0.05, 3, 328), (0.03, 3, 603)]
)
def test_memory_is_what_was_measured_within_a_factor_of_two(bodies, size, layers, megabytes):
    expected = estimate.estimate(bodies, MeshSettings(size, layers, growth=0.0))  # as these were
    assert 0.5 < expected.memory / (1e6 * megabytes) < 2.0


def test_an_iteration_costs_what_was_measured_and_a_curve_takes_the_time_that_was_said():
    """One iteration within 1.5 times, from 1,800 to 120,000 unknowns; whole curves of benchmark 1 within the range."""
    with (BENCHMARKS / "scaling.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 5
    for row in rows:
        likely = estimate.PER_ITERATION * float(row["unknowns"])
        assert 1 / 1.5 < likely / (1e-3 * float(row["per_iteration_ms"])) < 1.5
    segmented = driver.segment(cases.read(BENCHMARKS.parent / "templates" / "benchmark1.toml"))
    every_stone = segmented.bodies_of("micro")
    with (BENCHMARKS / "walls.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["benchmark 1"] for row in rows} == {"macroblocks", "micro-FE"}
    for row in rows:
        bodies = segmented.bodies if row["benchmark 1"] == "macroblocks" else every_stone
        least, most = estimate.estimate(bodies, MeshSettings(size=0.2)).seconds
        assert least < float(row["total_s"]) < most, row


@pytest.mark.parametrize(
    ("unknowns", "said"), [(200, "1 s to 1.6 s"), (8000, "2.6 s to 64 s"), (10**6, "5.3 min to 2.2 h")]
)
def test_a_time_is_said_with_its_uncertainty(unknowns, said):
    assert estimate.time_in_words(estimate.Estimate(unknowns, 0.0, 0.2)) == f"it takes {said} on a core of its own"


def test_more_than_the_machine_has_is_refused_and_much_of_it_is_said():
    expected = estimate.Estimate(1_000_000, 20e9, 0.05)
    assert estimate.warning_of(expected, 50e9) == ""
    assert estimate.warning_of(expected, 30e9).startswith(
        "WARNING: large: about 1,000,000 unknowns (elements of 50 mm), 20 GB of 30 GB"
    )
    with pytest.raises(CaseError, match=r"mesh\.size: needs about 1,000,000 .* mm\), 20 GB, this machine has 10 GB"):
        estimate.warning_of(expected, 10e9)


def test_a_mesh_of_a_millimetre_is_refused_at_once_with_exit_code_2(tmp_path, capsys):
    command = ["run", str(WALL), "--set", "mesh.size=0.2mm", "--model", "micro", "--output", str(tmp_path), "--quiet"]
    assert main(command) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "mesh.size: needs about" in line
    assert not (tmp_path / "micro").exists(), "nothing was meshed"


def test_free_memory_is_the_smaller_of_machine_and_control_group(tmp_path):
    place = (tmp_path / "meminfo", tmp_path)
    (tmp_path / "meminfo").write_text("MemTotal: 9 kB\nMemAvailable: 2000 kB\n")
    assert estimate.free_memory(*place) == 2000 * 1024
    (tmp_path / "memory.current").write_text("300\n")
    (tmp_path / "memory.max").write_text("1000\n")
    assert estimate.free_memory(*place) == 700
    (tmp_path / "memory.max").write_text("max\n")
    assert estimate.free_memory(*place) == 2000 * 1024


class MallocInfo(ctypes.Structure):
    """What mallinfo2 of the C library (glibc 2.33 or newer) returns, bytes."""

    _fields_ = tuple(
        (name, ctypes.c_size_t)
        for name in (
            "arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks", "keepcost"
        )
    )  # fmt: skip


def in_use():
    """Return the bytes that are allocated, of arrays and of the C libraries, what other tests left behind collected
    before: the resident memory of a process hides what it had free."""
    gc.collect()
    library = ctypes.CDLL(None)
    library.mallinfo2.restype = MallocInfo
    found = library.mallinfo2()
    return found.uordblks + found.hblkhd


def test_memory_grows_by_the_increments_that_are_kept_and_no_more(tmp_path):
    """A run keeps its increments up to storage.IN_MEMORY; from the 40th to the 140th nothing else remains of them: less
    than 8 % of their size. One vector of all unknowns has 10 %, lines of the log and headers of arrays have 1 to 3 %.
    """
    settings = ["stepping.gravity_increments=150", "stepping.largest_increments=140", "run.models=['micro']"]
    seen, size = {}, 0

    def report(event):
        nonlocal size
        if isinstance(event, IncrementDone):
            seen[event.increment.number] = in_use() if event.increment.number in (40, 140) else 0
            values = (getattr(event.increment, name) for name in event.increment.__slots__)
            size = sum(value.nbytes for value in values if isinstance(value, np.ndarray))

    with pytest.raises(ConvergenceError, match="has not come to rest"):  # it is not allowed to finish gravity
        driver.run(cases.read(WALL, settings), tmp_path, False, None, report)
    assert 140 * size < IN_MEMORY
    assert seen[140] - seen[40] == pytest.approx(100 * size, rel=0.08)

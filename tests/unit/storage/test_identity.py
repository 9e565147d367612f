"""Which program made a run, and which runs are the same."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from orchestrator.basis.program import commit, program, sources
from orchestrator.settings import case as cases
from orchestrator.storage.identity import identity
from tests.support.paths import DATA, PROJECT

IN_GIT = pytest.mark.skipif(not (PROJECT / ".git").exists(), reason="the sources are no clone")
ASK = "from orchestrator.basis.program import commit; print(commit())"


def case_of(*settings):
    case = cases.read(DATA / "ferris_tinloi_wall1.json", settings)
    return case, cases.read_wall(case)


def test_stones_that_change_places_make_another_run():
    """One is twice as heavy as the other: bodies of both have the same weight either way, the moments differ."""
    case, wall = case_of()
    ids = {block.id: number for number, block in enumerate(wall.blocks)}
    a, b = (ids[number] for number in sorted(ids)[1:3])

    def with_weights(first, second):
        blocks = list(wall.blocks)
        blocks[a], blocks[b] = replace(blocks[a], unit_weight=first), replace(blocks[b], unit_weight=second)
        return identity(case, replace(wall, blocks=tuple(blocks)))

    assert with_weights(50e3, 25e3) != with_weights(25e3, 50e3)


@pytest.mark.parametrize(
    "setting",
    [
        "load.direction=-x", "load.distribution=mass_height", "joints.tolerance=0.1mm", "mesh.size=50mm",
        "elastic.elastic_modulus=2GPa", "contact.slip_tolerance=0.01mm", "newton.gap=1e-11",
        "stepping.large_displacement=false",
    ],
)  # fmt: skip
def test_what_the_path_depends_on_makes_another_run(setting):
    assert identity(*case_of(setting)) != identity(*case_of())


@pytest.mark.parametrize("setting", ["stepping.final_displacement=5mm", "name=other", "run.models=['micro']"])
def test_how_far_a_path_is_followed_and_its_name_do_not(setting):
    key, value = setting.split("=")
    case, wall = case_of()
    changed = replace(case, name=value) if key == "name" else case_of(setting)[0]
    assert identity(changed, wall) == identity(case, wall)


def test_a_corner_that_moves_by_the_last_bit_makes_another_run():
    case, wall = case_of()
    moved = wall.blocks[1].polygon.copy()
    moved[0, 0] = np.nextafter(moved[0, 0], np.inf)
    blocks = (wall.blocks[0], replace(wall.blocks[1], polygon=moved), *wall.blocks[2:])
    assert identity(case, replace(wall, blocks=blocks)) != identity(case, wall)


@IN_GIT
def test_a_clone_and_an_archive_without_git_know_their_commit(tmp_path):
    asked = subprocess.run(["git", "rev-parse", "HEAD"], cwd=PROJECT, capture_output=True, text=True, check=True)
    head = asked.stdout.strip()[:12]
    assert commit().split("+")[0].endswith(head)
    assert program()["sources"] == sources()[:12]
    with (tmp_path / "archive.tar").open("wb") as file:
        subprocess.run(["git", "archive", "HEAD", "orchestrator"], cwd=PROJECT, stdout=file, check=True)
    subprocess.run(["tar", "-xf", "archive.tar"], cwd=tmp_path, check=True)
    assert not (tmp_path / ".git").exists()
    said = subprocess.run([sys.executable, "-c", ASK], cwd=tmp_path, env={}, capture_output=True, text=True, check=True)
    assert said.stdout.strip() == head


def test_a_copy_that_knows_no_commit_still_has_its_sources(tmp_path):
    (tmp_path / "orchestrator" / "basis").mkdir(parents=True)
    for name in ("__init__.py", "basis/__init__.py", "basis/program.py", "commit.txt"):
        (tmp_path / "orchestrator" / name).write_bytes((PROJECT / "orchestrator" / name).read_bytes())
    ask = "from orchestrator.basis.program import program; print(program())"
    said = subprocess.run([sys.executable, "-c", ask], cwd=tmp_path, env={}, capture_output=True, text=True, check=True)
    assert "commit" not in said.stdout
    assert "sources" in said.stdout

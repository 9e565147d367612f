"""The wheel has what a user without the sources needs: package, templates of pages, walls and cases, its commit."""

from __future__ import annotations

import subprocess
import sys
import zipfile

import pytest

from tests.support.paths import PROJECT


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """A wheel built from an archive of the last commit, without the network."""
    folder = tmp_path_factory.mktemp("wheel")
    if not (PROJECT / ".git").exists():
        pytest.skip("the sources are no clone")
    with (folder / "archive.tar").open("wb") as file:
        subprocess.run(["git", "archive", "HEAD"], cwd=PROJECT, stdout=file, check=True)
    subprocess.run(["tar", "-xf", "archive.tar"], cwd=folder, check=True)
    command = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation", "-w", "made", "."]
    built = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)
    assert built.returncode == 0, built.stderr
    (path,) = (folder / "made").glob("*.whl")
    return zipfile.ZipFile(path)


def test_it_has_cases_walls_pages_types_and_its_commit(wheel):
    names = set(wheel.namelist())
    for name in (
        "shipped/templates/benchmark1.toml", "shipped/meshes/ferris_tinloi_wall6.json", "shipped/templates/study.slurm",
        "present/page/template/report.html.j2", "present/in_space/template/space.html.j2", "py.typed", "__init__.pyi",
    ):  # fmt: skip
        assert f"orchestrator/{name}" in names, name
    head = subprocess.run(["git", "rev-parse", "HEAD"], cwd=PROJECT, capture_output=True, text=True, check=True).stdout
    assert wheel.read("orchestrator/commit.txt").decode().strip() == head.strip()


def test_its_benchmark_is_read_without_the_sources(wheel, tmp_path):
    wheel.extractall(tmp_path)
    program = "from orchestrator.settings import case; from orchestrator.app import cli; "
    program += "print(case.read_wall(case.read(cli.DEFAULT_CASE)).name, cli.SHIPPED)"
    said = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, env={})
    assert str(tmp_path) in said.stdout, said.stderr

"""Export: meshes that are read back, decks whose contacts are the joints and nothing else."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from itertools import pairwise

import meshio
import numpy as np
import pytest

from orchestrator.app import driver
from orchestrator.app.cli import main
from orchestrator.app.export import FACES, contact_pairs, deck
from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.pushover.meshing import mesh_bodies, volumes
from orchestrator.pushover.settings import ContactSettings
from orchestrator.settings import case as cases
from tests.support.disks import small_disk
from tests.support.paths import DATA

WALL_1 = DATA / "ferris_tinloi_wall1.json"


@pytest.fixture(scope="module")
def wall_1():
    case = cases.read(WALL_1)
    assemblage = driver.check(case)
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    case = replace(case, mesh=replace(case.mesh, size=0.2))
    return case, bodies, mesh_bodies(replace(bodies, moving=len(bodies.bodies)), case.mesh, None)


@pytest.mark.parametrize("kind", ["vtu", "msh"])
def test_meshes_hold_the_volume_of_the_moving_bodies(tmp_path, capsys, kind):
    path = tmp_path / f"wall.{kind}"
    assert main(["export", str(WALL_1), "--format", kind, "--model", "micro", "--output", str(path)]) == 0
    assert capsys.readouterr().out.endswith(f"{path}\n")  # on a busy machine after what it is doing
    mesh = meshio.read(path)
    assert volumes(mesh.points, mesh.cells_dict["tetra"]).sum() == pytest.approx(2.0 * 1.05 * 0.1)
    assert set(np.concatenate(mesh.cell_data["body"]).tolist()) == set(range(33))
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("kind", ["vtu", "msh"])
def test_a_mesh_takes_no_multiplier(tmp_path, capsys, kind):
    path = tmp_path / f"wall.{kind}"
    arguments = ["export", str(WALL_1), "--format", kind, "--multiplier", "1", "--output", str(path)]
    assert main(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    said = f"--multiplier: is of the steps of a deck, and a mesh ({kind}) has none; leave it out, or give --format "
    assert line == said + "calculix or abaqus"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("kind", ["vtu", "msh"])
def test_a_full_disk_is_told_by_the_name_that_was_given(tmp_path, capsys, kind):
    path = tmp_path / f"wall.{kind}"
    with small_disk(tmp_path, 4):
        assert main(["export", str(WALL_1), "--format", kind, "--output", str(path)]) == 1
        assert list(tmp_path.iterdir()) == []
    assert capsys.readouterr().err == f"{path}: No space left on device\n"


def test_decks_refuse_loads_that_they_would_leave_out(tmp_path, capsys):
    path = tmp_path / "wall.inp"
    arguments = ["export", str(WALL_1), "--format", "abaqus", "--output", str(path), "--set", "load.inclination=5 deg"]
    assert main(arguments) == 2
    assert "load.inclination: decks carry weight" in capsys.readouterr().err
    assert not path.exists()


def test_decks_refuse_joints_of_more_than_friction(tmp_path, capsys):
    """Cohesion was left out without a word."""
    case = tmp_path / "case.toml"
    case.write_text(f'[wall]\nblocks = "{WALL_1}"\n[[joints.classes]]\ncohesion = "10 kPa"\n')
    path = tmp_path / "wall.inp"
    assert main(["export", str(case), "--format", "calculix", "--output", str(path)]) == 2
    assert "joints.classes: decks carry rigid joints of friction alone; " in capsys.readouterr().err
    assert not path.exists()


def test_decks_refuse_macroblocks_of_stones_of_different_weight(tmp_path, capsys):
    record = json.loads(WALL_1.read_text())
    record["blocks"][-1]["unit_weight"] = 50
    (tmp_path / "wall.json").write_text(json.dumps(record))
    path = tmp_path / "wall.inp"
    arguments = [
        "export",
        str(tmp_path / "wall.json"),
        "--format",
        "calculix",
        "--output",
        str(path),
        "--set",
        "macroblocks.tol_n=1",
    ]
    assert main(arguments) == 2
    assert "wall: a deck gives a body one density, and macroblocks join" in capsys.readouterr().err
    assert not path.exists()
    assert main([*arguments, "--model", "micro"]) == 0
    densities = [line for before, line in pairwise(path.read_text().splitlines()) if before == "*DENSITY"]
    assert sorted({round(float(density) * 9.81) for density in densities}) == [25000, 50000]


def test_contact_pairs_cover_the_joints_and_nothing_else(wall_1):
    """Master faces of a joint fill it: their total area is the joint length times the thickness. Slaves lie on it."""
    _, bodies, meshes = wall_1
    pairs = list(contact_pairs(bodies, meshes))
    area = 0.0
    for pair in pairs:
        corners = meshes.nodes[meshes.tetrahedra[pair.element[:, None], np.array(FACES)[pair.face]]]
        normal = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area += np.linalg.norm(normal, axis=1).sum()
        unit = normal[0] / np.linalg.norm(normal[0])
        off = (meshes.nodes[pair.slave] - corners[0, 0]) @ unit
        along = np.array([unit[1], -unit[0], 0.0])
        reach = corners.reshape(-1, 3) @ along
        assert np.abs(off).max() < 1e-9
        assert (meshes.nodes[pair.slave] @ along >= reach.min() - 1e-9).all()
        assert (meshes.nodes[pair.slave] @ along <= reach.max() + 1e-9).all()
        owner = set(meshes.body_of_tetrahedron[pair.element].tolist())
        assert len(owner) == 1
        assert (meshes.body_of_node[pair.slave] < bodies.moving).all(), "a support is never a slave"
    assert len(pairs) == 83
    assert area == pytest.approx(bodies.interfaces.length.sum() * 0.1, rel=1e-6)


def test_faces_are_numbered_as_both_programs_do(wall_1):
    """Of an element with nodes 1 2 3 4: S1 = 1 2 3, S2 = 1 4 2, S3 = 2 4 3, S4 = 3 4 1; the fourth node lies ahead."""
    assert FACES == ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))
    _, _, meshes = wall_1
    points = meshes.nodes[meshes.tetrahedra[0]]
    for face in FACES:
        a, b, c = points[list(face)]
        assert np.cross(b - a, c - a) @ (points.mean(axis=0) - a) > 0


def test_abaqus_deck_has_hard_contact_and_both_steps(wall_1):
    case, bodies, _ = wall_1
    text, slipping = deck(bodies, case, -0.3, "abaqus"), replace(case, contact=ContactSettings(1e-6))
    assert text.count("PRESSURE-OVERCLOSURE=HARD") == text.count("*CONTACT PAIR") == 83
    assert text.count("*STEP") == text.count("*END STEP") == 2
    assert "*FRICTION, ELASTIC SLIP=1e-06\n0.65," in deck(bodies, slipping, -0.3, "abaqus")
    assert len(set(re.findall(r"\*FRICTION, ELASTIC SLIP=(\S+)\n0.65,", text))) == 1, "that of the wall"
    assert "LOADED, GRAV, -2.943, 1., 0., 0." in text
    assert max(map(len, text.splitlines())) <= 256, "a line of a deck holds 256 letters"
    assert text.isascii()


def test_abaqus_deck_is_read_back_by_another_program(wall_1, tmp_path):
    """meshio's reader of Abaqus decks: every tetrahedron, the volume of all bodies, supports held and no other node."""
    case, bodies, meshes = wall_1
    path = tmp_path / "wall.inp"
    path.write_text(deck(bodies, case, -0.3, "abaqus"))
    read = meshio.read(path, file_format="abaqus")
    assert len(read.cells_dict["tetra"]) == len(meshes.tetrahedra)
    assert volumes(read.points, read.cells_dict["tetra"]).sum() == pytest.approx((2.0 * 1.05 + 2.4 * 0.175) * 0.1)
    held = read.point_sets["SUPPORT"]
    assert read.points[held, 1].max() <= 0.0
    assert len(held) == np.count_nonzero(meshes.body_of_node >= bodies.moving)
    assert {f"BODY{k}" for k in range(34)} <= set(read.cell_sets)


def test_a_run_folder_can_be_exported(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "run7"
    folder.mkdir()
    (folder / "case.toml").write_text("[wall]\nblocks = 'blocks.json'\n")
    (folder / "blocks.json").write_text(WALL_1.read_text())
    assert main(["export", "run7", "--format", "abaqus"]) == 0
    assert (tmp_path / "run7_macro.inp").read_text().startswith("*HEADING")
    assert main(["export", "run7", "--format", "abaqus", "--multiplier", "nan"]) == 2
    assert "--multiplier: nan is not a multiplier" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["wall.inp", "wall.dat"])
def test_a_name_that_does_not_say_the_format_is_refused(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["export", str(WALL_1), "--output", name]) == 2
    assert f"--output: {name}: its end does not say which format" in capsys.readouterr().err
    assert not (tmp_path / name).exists()


def test_the_name_of_the_file_says_the_format(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["export", str(WALL_1), "--output", "wall.MSH", "--model", "micro"]) == 0
    assert (tmp_path / "wall.MSH").read_bytes().startswith(b"$MeshFormat")


def test_what_a_case_is_read_from_is_not_overwritten(tmp_path, capsys):
    """Not even with --force: neither the case file nor the blocks that it names."""
    blocks, case = tmp_path / "blocks.json", tmp_path / "case.toml"
    blocks.write_bytes(WALL_1.read_bytes())
    case.write_text('[wall]\nblocks = "blocks.json"\n')
    for source, output in ((blocks, blocks), (case, blocks), (case, case)):
        before = output.read_bytes()
        assert main(["export", str(source), "--format", "calculix", "--output", str(output), "--force"]) == 2
        assert f"{output}: is read by this command" in capsys.readouterr().err
        assert output.read_bytes() == before

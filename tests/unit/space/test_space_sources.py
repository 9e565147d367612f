"""Blocks in space from files of other programs: COMPAS, OBJ, STL, PLY, STEP, plans of courses."""

from __future__ import annotations

import json
import re

import meshio
import numpy as np
import pytest

from orchestrator.app import cli
from orchestrator.app.space_intake import as_record, read_file
from orchestrator.basis.errors import CaseError
from orchestrator.geometry.polyhedra import flaw_of, volume_of
from orchestrator.space.block_files import wall_from
from orchestrator.space.contacts import find_joints
from orchestrator.space.generators.shapes import Plan, Stones, u_wall
from orchestrator.space.sources.meshes import bodies_in
from orchestrator.space.wall import check_wall
from orchestrator.storage.files import plain
from tests.support.paths import DATA

SPACE = DATA / "space"


@pytest.mark.parametrize(
    ("name", "blocks", "supports", "joints"),
    [
        ("compas_cra_shelf.json", 11, 1, 19),
        ("compas_dem_crossvault.json", 38, 5, 60),
        ("compas_dem_wall.obj", 38, 5, 60),
    ],
)
def test_files_of_other_programs(name, blocks, supports, joints, tmp_path, capsys):
    output = tmp_path / "imported.json"
    assert cli.main(["import", str(SPACE / name), "--unit", "m", "--output", str(output)]) == 0
    assert f"{blocks} blocks in space, {supports} of them supports, {joints} joints" in capsys.readouterr().out
    again = wall_from(json.loads(output.read_text()), "again")
    check_wall(again)
    assert find_joints(again).joints.count == joints
    assert cli.main(["import", str(SPACE / name), "--output", str(output), "--force"]) == 2
    assert "--unit: the file has no unit of length; give it, as in --unit mm" in capsys.readouterr().err


def test_a_mesh_may_have_another_axis_upwards(tmp_path, capsys):
    """As Blender writes OBJ: (x, z, -y). Supports are the lowest stones, and the wall is the same."""
    lines = (SPACE / "compas_dem_wall.obj").read_text().splitlines()
    turned = tmp_path / "turned.obj"
    corners = [line.split() for line in lines]
    with turned.open("w") as file:
        for line, words in zip(lines, corners, strict=True):
            print(f"v {words[1]} {words[3]} {-float(words[2])!r}" if words[:1] == ["v"] else line, file=file)
    walls = [read_file(SPACE / "compas_dem_wall.obj", {"unit": "m"}), read_file(turned, {"unit": "m", "up": "y"})]
    assert [block.id for block in walls[1].blocks if block.fixed] == [b.id for b in walls[0].blocks if b.fixed]
    assert walls[1].centroids @ walls[1].up == pytest.approx(walls[0].centroids @ walls[0].up)
    output = tmp_path / "imported.json"
    assert cli.main(["import", str(turned), "--unit", "m", "--up", "y", "--output", str(output)]) == 0
    assert "5 of them supports, 60 joints; y is upwards; " in capsys.readouterr().out
    assert json.loads(output.read_text())["up"] == "y"
    assert cli.main(["import", str(turned), "--unit", "m", "--up", "up", "--output", str(output), "--force"]) == 2
    assert "--up: 'up' is no axis; write x, y or z, the axis that points upwards" in capsys.readouterr().err


WALL = u_wall(Plan(2, 1, 2), Stones())


def test_a_folder_of_stl_and_ply_files(tmp_path):
    """One stone a file, in mm; STL repeats every corner."""
    folder = tmp_path / "stones"
    folder.mkdir()
    for block in WALL.blocks:
        triangles = [(f[0], f[k], f[k + 1]) for f in block.shape.faces for k in (1, 2)]
        suffix = "stl" if block.id % 2 else "ply"
        mesh = meshio.Mesh(1e3 * block.shape.vertices, [("triangle", triangles)])
        mesh.write(folder / f"{block.id:03d}.{suffix}")
    wall = read_file(folder, {"unit": "mm"})
    check_wall(wall)
    assert wall.weights.tolist() == pytest.approx(WALL.weights.tolist(), rel=1e-5)
    assert [block.id for block in wall.blocks if block.fixed] == [1]
    assert find_joints(wall).joints.count == find_joints(WALL).joints.count
    assert {len(block.shape.faces) for block in wall.blocks} == {6}


def test_triangles_in_a_plane_with_a_hole_stay_triangles():
    """A frame: no one ring bounds its front, and two rings of one face are no polyhedron's."""
    outer, inner = [(0, 0), (4, 0), (4, 4), (0, 4)], [(1, 1), (3, 1), (3, 3), (1, 3)]
    corners = np.array([(x, y, z) for z in (0.0, 1.0) for x, y in [*outer, *inner]])
    front = [(8 + k, 8 + (k + 1) % 4, 12 + (k + 1) % 4, 12 + k) for k in range(4)]
    back = [tuple(k - 8 for k in face[::-1]) for face in front]
    sides = [(k, (k + 1) % 4, 8 + (k + 1) % 4, 8 + k) for k in range(4)]
    holes = [(4 + (k + 1) % 4, 4 + k, 12 + k, 12 + (k + 1) % 4) for k in range(4)]
    triangles = [(f[0], f[k], f[k + 1]) for f in [*front, *back, *sides, *holes] for k in (1, 2)]
    (body,) = bodies_in(corners, triangles)
    assert flaw_of(body) is None
    assert volume_of(body) == pytest.approx(12.0)
    assert sorted(map(len, body.faces)) == [3] * 16 + [4] * 8


@pytest.mark.parametrize("unit", ["MM", "M"])
def test_step(tmp_path, unit):
    """Boxes and a cylinder written by OpenCASCADE, which states its unit in the file."""
    import gmsh

    path, mm = tmp_path / "column.step", {"MM": 1.0, "M": 1e-3}[unit]
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setString("Geometry.OCCTargetUnit", unit)
    gmsh.model.occ.addBox(-500 * mm, -500 * mm, -200 * mm, 1000 * mm, 1000 * mm, 200 * mm)
    gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 900 * mm, 300 * mm)
    gmsh.model.occ.addBox(-300 * mm, -300 * mm, 900 * mm, 600 * mm, 600 * mm, 200 * mm)
    gmsh.model.occ.synchronize()
    gmsh.write(str(path))
    gmsh.finalize()
    wall = read_file(path, {})
    check_wall(wall)
    assert find_joints(wall).joints.count == 2
    assert wall.weights.tolist() == pytest.approx([4e3, 20e3 * np.pi * 0.09 * 0.9, 20e3 * 0.072], rel=0.03)
    assert [len(block.shape.faces) for block in wall.blocks if block.id != 2] == [6, 6]
    with pytest.raises(CaseError, match=r"files state their unit of length"):
        read_file(path, {"unit": "m"})


def test_plans_of_courses(tmp_path):
    """The U-shaped wall drawn course by course: same joints as the generator's."""
    import ezdxf

    document = ezdxf.new(units=4)
    for block in WALL.blocks:
        x, y, z = 1e3 * block.shape.vertices.T
        layer = "supports" if block.fixed else f"course {round(float(z.min()) / 100) + 1} h 100"
        ring = [(x.min(), y.min()), (x.max(), y.min()), (x.max(), y.max()), (x.min(), y.max())]
        document.modelspace().add_lwpolyline(ring, close=True, dxfattribs={"layer": layer})
    path = tmp_path / "courses.dxf"
    document.saveas(path)
    wall = read_file(path, {"height": "100 mm"})
    check_wall(wall)
    assert wall.fixed.sum() == 1
    assert find_joints(wall).joints.count == find_joints(WALL).joints.count
    assert json.loads(json.dumps(plain(as_record(wall))))["up"] == "z"


@pytest.mark.parametrize(
    ("draw", "options", "message"),
    [
        (
            lambda space, on: space.add_lwpolyline([(0, 0), (1, 0), (1, 1)], dxfattribs=on),
            {},
            "is open, and no stone; close",
        ),
        (
            lambda space, on: space.add_lwpolyline(
                [(0, 0, 0.5), (1, 0, 0), (1, 1, 0)], "xyb", close=True, dxfattribs=on
            ),
            {},
            "has an arc; draw its chords",
        ),
        (
            lambda space, on: space.add_line((0, 0), (1, 0), dxfattribs=on),
            {},
            "holds a LINE, which is no stone; explode",
        ),
        (
            lambda space, on: None,
            {"height": "-250 mm"},
            "--height: a height of -0.25 m is not above 0; give the height",
        ),
    ],
)
def test_plans_lose_no_stone_in_silence(tmp_path, draw, options, message):
    """Beside a stone that is read: what is drawn on a course and is none, and a course without height."""
    import ezdxf

    document = ezdxf.new(units=6)
    ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
    document.modelspace().add_lwpolyline(ring, close=True, dxfattribs={"layer": "course 1"})
    draw(document.modelspace(), {"layer": "course 1"})
    path = tmp_path / "plan.dxf"
    document.saveas(path)
    with pytest.raises(CaseError, match=re.escape(message)):
        read_file(path, {"height": "250 mm"} | options)


@pytest.mark.parametrize(
    ("layer", "message"),
    [
        ("course 0", "names no courses; count from 1"), ("courses 3-2", "names no courses; count from 1"),
        ("courses 2-3 h 0.5", "says one height of several courses; name layers of one course for that"),
    ],
)  # fmt: skip
def test_layers_of_courses_that_cannot_be(tmp_path, layer, message):
    import ezdxf

    document = ezdxf.new(units=6)
    for one in ("course 1", layer):
        ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
        document.modelspace().add_lwpolyline(ring, close=True, dxfattribs={"layer": one})
    document.saveas(tmp_path / "plan.dxf")
    with pytest.raises(CaseError, match=re.escape(f"layer {layer!r}: {message}")):
        read_file(tmp_path / "plan.dxf", {"height": "250 mm"})


def test_layers_that_are_no_courses_are_told(tmp_path):
    import ezdxf

    document, said = ezdxf.new(units=6), list[str]()
    ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
    for layer in ("course 1", "cours 2", "cours 2"):
        document.modelspace().add_lwpolyline(ring, close=True, dxfattribs={"layer": layer})
    path = tmp_path / "plan.dxf"
    document.saveas(path)
    read_file(path, {"height": "250 mm"}, said.append)
    assert said == ["layer 'cours 2' is no course: 2 lines left out"]


CUBE = (
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
)


def test_a_file_that_is_none(tmp_path):
    for name, text, options in (
        ("a.obj", "v 1 2\nf x", {"unit": "m"}), ("b.obj", CUBE.replace("v 1 0 0", "v 1 0"), {"unit": "m"}),
        ("c.obj", CUBE.replace("v 1 0 0", "v 1e400 0 0"), {"unit": "m"}),
        ("a.stl", "solid", {"unit": "m"}), ("a.step", "ISO", {}),
        ("a.dxf", "nothing", {"height": "1 m"}), ("a.json", '{"dtype": "x/Assembly"}', {"unit": "m"}),
    ):  # fmt: skip
        (tmp_path / name).write_text(text)
        with pytest.raises(CaseError) as refused:
            read_file(tmp_path / name, options)
        assert "; " in str(refused.value)

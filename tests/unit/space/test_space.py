"""Blocks in space: reading, refusals, joints, loads, the commands, and files of other programs."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest

from orchestrator.app import cli
from orchestrator.app.space_intake import as_record, read_file
from orchestrator.basis.arrays import read_only
from orchestrator.basis.errors import CaseError
from orchestrator.geometry.polyhedra import Polyhedron, box, centroid_of, prism, rotation, second_moment_of, volume_of
from orchestrator.geometry.shared_volume import common_volume
from orchestrator.space.analysis import analyse
from orchestrator.space.block_files import wall_from
from orchestrator.space.contacts import find_joints
from orchestrator.space.generators.shapes import Plan, Stones, u_wall
from orchestrator.space.loads import SpaceDeadLoad, SpaceLoadSettings, loads_on
from orchestrator.space.wall import SpaceBlock, check_wall
from orchestrator.storage.files import plain
from tests.support.paths import DATA, PROJECT
from tests.support.space_walls import GROUND, block_on_ground, wall_of

SPACE = DATA / "space"
CUBE = box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
L_SHAPE = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]]


def record(**changes):
    return {
        "units": {"length": "mm", "unit_weight": "kN/m3"}, "unit_weight": 20, "friction": 0.6,
        "blocks": [
            {"id": 0, "polygon": [[-500, -100], [1500, -100], [1500, 0], [-500, 0]], "thickness": 600, "fixed": True},
            {
                "id": 1, "vertices": (1e3 * CUBE.vertices * [0.5, 0.5, 0.2]).tolist(),
                "faces": [list(face) for face in CUBE.faces],
            },
        ],
    } | changes  # fmt: skip


def test_a_file_may_hold_polyhedra_and_prisms():
    wall = wall_from(record(), "both")
    check_wall(wall)
    joints = find_joints(wall).joints
    assert wall.up.tolist() == [0.0, 0.0, 1.0]
    assert joints.count == 1
    assert joints.area[0] == pytest.approx(0.25)
    assert joints.normal[0] == pytest.approx([0.0, 0.0, 1.0])
    assert wall.weights[1] == pytest.approx(20e3 * 0.05)
    plane = wall_from(
        record(thickness=300, blocks=[{"id": 1, "polygon": L_SHAPE, "offset": 100, "material": "tuff"}]), "plane"
    )
    assert plane.up.tolist() == [0.0, 1.0, 0.0]
    assert plane.blocks[0].shape.vertices[:, 2].tolist() == pytest.approx([0.1] * 6 + [0.4] * 6)
    assert volume_of(plane.blocks[0].shape) == pytest.approx(3e-6 * 0.3)


@pytest.mark.parametrize("shape", [CUBE, prism(np.array(L_SHAPE), np.zeros(3), np.eye(3))])
def test_integrals_of_a_body_that_is_turned(shape):
    turn = rotation((1.0, 2.0, 3.0), 1.1)
    moved = shape.moved(turn, np.array([5.0, -3.0, 2.0]))
    assert volume_of(moved) == pytest.approx(volume_of(shape))
    assert centroid_of(moved) == pytest.approx(turn @ centroid_of(shape) + [5.0, -3.0, 2.0])
    assert second_moment_of(moved) == pytest.approx(turn @ second_moment_of(shape) @ turn.T, abs=1e-12)
    assert second_moment_of(CUBE) == pytest.approx(np.eye(3) / 12)


def test_the_volume_that_two_bodies_share():
    corner = box((0.5, 0.5, 0.0), (3.0, 3.0, 0.5))
    bent = prism(np.array(L_SHAPE), np.zeros(3), np.eye(3))
    assert common_volume(CUBE, corner) == pytest.approx(0.125)
    exact = 0.5 * (0.5 * 0.5 + 1.0 * 0.5 + 0.5 * 1.0)  # of the L between 0.5 and its ends
    assert common_volume(bent, corner) == pytest.approx(exact)
    assert common_volume(CUBE, box((1.0, 0.0, 0.0), (2.0, 1.0, 1.0))) == 0.0


def opened(shape: Polyhedron) -> Polyhedron:
    return replace(shape, faces=shape.faces[:-1])


@pytest.mark.parametrize(
    ("shape", "problem"),
    [
        (opened(CUBE), "is open: 4 edges belong to one face only"),
        (replace(CUBE, faces=tuple(face[::-1] for face in CUBE.faces)), "clockwise seen from outside"),
        (replace(CUBE, faces=(CUBE.faces[0][::-1], *CUBE.faces[1:])), "the same way"),
        (Polyhedron(read_only(CUBE.vertices * [1.0, 1.0, 0.0]), CUBE.faces), "no area|no volume"),
        (Polyhedron(read_only(CUBE.vertices + np.eye(8, 3) * 0.1), CUBE.faces), "is not plane"),
        (
            prism(np.array([[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]]), np.zeros(3), np.eye(3)),
            "crosses or touches itself",
        ),
    ],
)
def test_bodies_that_are_none_are_refused(shape, problem):
    wall = wall_of([GROUND, shape], 0.6)
    with pytest.raises(CaseError, match=problem) as refused:
        check_wall(wall)
    assert str(refused.value).startswith("block 1: ")
    assert "; " in str(refused.value)


def test_a_body_whose_edge_goes_through_a_face_is_refused():
    tent = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1.0], [0.5, 0.5, -0.5]], dtype=float)
    faces = ((0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (1, 0, 5), (2, 1, 5), (3, 2, 5), (0, 3, 5))
    check_wall(wall_of([box((-2.0, -2.0, -3.0), (3.0, 3.0, -2.0)), Polyhedron(read_only(tent), faces)], 0.6))
    tent[5] = [0.5, 0.5, 1.5]  # the lower tip pushed up through the roof
    with pytest.raises(CaseError, match=r"crosses itself|clockwise"):
        check_wall(wall_of([box((-2.0, -2.0, -3.0), (3.0, 3.0, -2.0)), Polyhedron(read_only(tent), faces)], 0.6))


def test_blocks_that_overlap_are_named_with_the_volume():
    wall = wall_of([GROUND, CUBE, box((0.5, 0.0, 0.0), (1.5, 1.0, 1.0))], 0.6)
    with pytest.raises(CaseError, match=r"block 1: overlaps block 2 by 0.5 m3; correct one of them"):
        check_wall(wall)
    with pytest.raises(CaseError, match="given twice"):
        check_wall(wall_of([GROUND, CUBE, CUBE], 0.6))


def test_a_block_that_touches_nothing_is_named():
    with pytest.raises(CaseError, match=r"block 1: touches no other block, at \(0.5, 0.5, 0.6\) m; move it"):
        find_joints(wall_of([GROUND, CUBE.moved(np.eye(3), np.array([0.0, 0.0, 0.1]))], 0.6))
    with pytest.raises(CaseError, match=r"too small: lower contact.smallest"):
        find_joints(
            wall_of([GROUND, box((4.99999, 0.0, -0.5), (6.0, 1.0, 0.5)).moved(np.eye(3), np.array([0, 0, 0.5]))], 0.6)
        )


def test_a_wall_that_cannot_stand_is_refused():
    leaning = wall_of([GROUND, CUBE, CUBE.moved(np.eye(3), np.array([0.7, 0.0, 1.0]))], 0.6)
    assemblage = find_joints(leaning)
    with pytest.raises(CaseError, match=r"block 2: the wall cannot stand under its own weight: block 2 would move"):
        analyse(assemblage, loads_on(leaning))


def test_joints_need_not_be_exact_and_may_be_several():
    """A gap of a part of the stone is closed; an L on an L shares two joints; triangles of one plane leave no seam."""
    assert find_joints(wall_of([GROUND, CUBE.moved(np.eye(3), np.array([0.0, 0.0, 5e-4]))], 0.6)).joints.count == 1
    up = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [2.0, 1.0], [2.0, 0.5], [1.0, 0.5], [1.0, 1.0], [0.0, 1.0]])
    axes = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    bridge = wall_of([prism(up, np.array([0.0, 0.0, -1.0]), axes), box((0.0, 0.0, 0.0), (3.0, 1.0, 1.0))], 0.6)
    joints = find_joints(bridge).joints
    assert joints.count == 2
    assert joints.area.tolist() == pytest.approx([1.0, 1.0])
    split = tuple(t for face in CUBE.faces for t in ((face[0], face[1], face[2]), (face[0], face[2], face[3])))
    triangulated = find_joints(wall_of([GROUND, replace(CUBE, faces=split)], 0.6)).joints
    assert triangulated.count == 1
    assert triangulated.area[0] == pytest.approx(1.0, rel=1e-6)
    assert len(triangulated.point) == 4


def test_a_common_area_that_is_too_small_is_listed():
    wall = wall_of(
        [GROUND, CUBE, box((1.0, 0.9999, 0.0), (2.0, 1.9999, 1.0)), box((1.0, -1.0, 0.0), (2.0, 0.5, 1.0))], 0.6
    )
    assemblage = find_joints(wall)
    assert [(one.i, one.j, round(one.area, 8)) for one in assemblage.ignored] == [(1, 2, 1e-4)]


def test_loads():
    wall = block_on_ground(1.0, 2.0, 0.5, 0.6)
    dead = (
        SpaceDeadLoad(blocks=(1,), line_load=1e3, inertia=True),
        SpaceDeadLoad(level=0.5, force=500.0, direction=(0.0, 3.0, 0.0)),
    )
    loads = loads_on(wall, SpaceLoadSettings(direction=(0.0, 0.0, 2.0), dead=dead))
    assert loads.dead[1] == pytest.approx([0.0, 500.0, -22e3, -125.0, 0.0, 0.0])
    assert loads.live[1] == pytest.approx([0.0, 0.0, 22e3, 0.0, 0.0, 0.0])
    with pytest.raises(CaseError, match="'up' is no direction"):
        loads_on(wall, SpaceLoadSettings(direction="up"))
    with pytest.raises(CaseError, match=r"load.dead.0.level: no block has its top at 3 m; tops are at 0.5 m"):
        loads_on(wall, SpaceLoadSettings(dead=(SpaceDeadLoad(level=3.0, force=1.0),)))


def test_mass_times_height():
    wall = wall_of([GROUND, CUBE, CUBE.moved(np.eye(3), np.array([0.0, 0.0, 1.0]))], 0.6)
    live = loads_on(wall, SpaceLoadSettings(distribution="mass_height")).live
    assert live[1:, 0] == pytest.approx([10e3, 30e3])


@pytest.fixture
def block_file(tmp_path):
    path = tmp_path / "wall.json"
    path.write_text(json.dumps(record()))
    return path


def test_limit_and_check_take_blocks_in_space(block_file, tmp_path, capsys):
    output = ["--output", str(tmp_path / "out")]
    assert cli.main(["check", str(block_file), *output]) == 0
    assert "1 blocks in space, 1 joints, nothing to complain about" in capsys.readouterr().out
    assert cli.main(["limit", str(block_file), "--set", "load.direction=[0,-1,0]", *output]) == 0
    printed = capsys.readouterr().out
    assert "0.60000" in printed
    assert (tmp_path / "out" / "figures" / "mechanism.png").stat().st_size > 5000
    page = (tmp_path / "out" / "collapse.html").read_text()
    assert "http" not in page.replace("http-equiv", "")
    assert cli.main(["limit", str(block_file), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {
        "associative", "non_associative", "non_associative_range", "iterations", "converged", "equilibrium_residual",
        "base_shear", "seconds",
    } < set(found)  # fmt: skip
    assert found["non_associative"] == pytest.approx(0.6, abs=1e-6)
    assert found["base_shear"] == pytest.approx(0.6 * 1e3, rel=1e-5)


def test_a_plane_wall_may_be_pushed_out_of_its_plane(capsys):
    tower = str(DATA / "tower_5_blocks.json")
    assert cli.main(["limit", tower, "--set", "load.direction=+z", "--json"]) == 0
    out_of_plane = json.loads(capsys.readouterr().out)
    rows = json.loads(Path(tower).read_text())
    height = max(y for block in rows["blocks"] for _, y in block["polygon"])
    assert out_of_plane["associative"] == pytest.approx(min(rows["thickness"] / height, rows["friction"]), rel=1e-5)


def test_directions_in_plan(block_file, tmp_path, capsys):
    settings = ["--set", "load.directions=4", "--set", "limit_analysis.states=headline"]
    assert cli.main(["limit", str(block_file), *settings, "--output", str(tmp_path)]) == 0
    assert "direction 270 degrees: associative 0.6000" in capsys.readouterr().out
    assert json.loads((tmp_path / "directions.json").read_text())["associative"] == pytest.approx([0.6] * 4, abs=1e-6)
    assert (tmp_path / "figures" / "directions.png").exists()


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (["load.direction=[0,0]"], "load.direction: [0.0, 0.0] is no direction; write"),
        (["load.directon=+y"], "load.directon: is not a known key; did you mean direction?"),
        (["contact.gap=0"], "contact.gap"),
        (["mesh.size=1mm"], "mesh: is not a section of a wall in space; use name, wall, load"),
        (["limit_analysis.torsion=none"], "limit_analysis.torsion"),
        (["wall.thickness=1"], "wall.thickness: is not a known key"),
    ],
)
def test_bad_settings_take_one_line(block_file, capsys, settings, message):
    assert cli.main(["limit", str(block_file), *(part for one in settings for part in ("--set", one))]) == 2
    said = capsys.readouterr().err.strip()
    assert message in said
    assert "\n" not in said
    assert str(block_file) in said


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"units": {"length": "mm"}}, "units.unit_weight: is missing"),
        ({"up": "w"}, "up: 'w' is no axis"),
        ({"up": ["z"]}, "up: ['z'] is no axis"),
        (
            {"blocks": [{"id": 1, "vertices": [[0, 0, 0]], "faces": []}]},
            "block 1.vertices: is not a list of at least 4",
        ),
        ({"blocks": [{"id": 1, "vertices": CUBE.vertices.tolist(), "faces": [[0, 1, 99]] * 4}]}, "block 1.faces[0]"),
        ({"blocks": [{"id": 1, "vertices": [], "polygon": []}]}, "block 1: needs vertices and faces, or a polygon"),
        ({"blocks": [{"id": 1, "polygon": L_SHAPE, "offset": 1}]}, "block 1.thickness: is missing"),
    ],
)
def test_bad_block_files_take_one_line(tmp_path, capsys, change, message):
    path = tmp_path / "bad.json"
    path.write_text(json.dumps({**record(), "up": "z", **change}))
    assert cli.main(["check", str(path), "--output", str(tmp_path)]) == 2
    said = capsys.readouterr().err.strip()
    assert message in said
    assert "\n" not in said


def test_the_shipped_example(tmp_path, capsys):
    template = str(PROJECT / "templates" / "uwall.toml")
    assert cli.main(["limit", template, "--set", "limit_analysis.states=headline", "--output", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert "0.34229" in printed
    assert "0.31950" in printed
    assert "56 blocks (84 % of the weight) in 1 body" in printed
    assert cli.main(["check", template, "--set", "wall.fasade=3", "--output", str(tmp_path)]) == 2
    assert "wall.fasade: is not a key of the generator 'u'" in capsys.readouterr().err


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


def test_step(tmp_path):
    """Boxes and a cylinder written by OpenCASCADE, in mm."""
    import gmsh

    path = tmp_path / "column.step"
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
    gmsh.model.occ.addBox(-500, -500, -200, 1000, 1000, 200)
    gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 900, 300)
    gmsh.model.occ.addBox(-300, -300, 900, 600, 600, 200)
    gmsh.model.occ.synchronize()
    gmsh.write(str(path))
    gmsh.finalize()
    wall = read_file(path, {"unit": "mm"})
    check_wall(wall)
    assert find_joints(wall).joints.count == 2
    assert wall.weights.tolist() == pytest.approx([4e3, 20e3 * np.pi * 0.09 * 0.9, 20e3 * 0.072], rel=0.03)


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


def test_a_file_that_is_none(tmp_path):
    for name, text, options in (
        ("a.obj", "v 1 2\nf x", {"unit": "m"}), ("a.stl", "solid", {"unit": "m"}), ("a.step", "ISO", {}),
        ("a.dxf", "nothing", {"height": "1 m"}), ("a.json", '{"dtype": "x/Assembly"}', {"unit": "m"}),
    ):  # fmt: skip
        (tmp_path / name).write_text(text)
        with pytest.raises(CaseError) as refused:
            read_file(tmp_path / name, options)
        assert "; " in str(refused.value)


@pytest.mark.parametrize("command", ["run", "segment", "study"])
def test_commands_that_do_not_take_walls_in_space_say_so(command, block_file, capsys):
    assert cli.main([command, str(block_file)]) == 2
    assert f"is a wall in space, which {command} does not take yet; use check or limit" in capsys.readouterr().err


def test_ties_of_a_case_file(tmp_path, block_file, capsys):
    case = tmp_path / "tied.toml"
    text = '[wall]\nblocks = "wall.json"\n[load]\ndirection = "+x"\n[[reinforcement.ties]]\nblocks = [0, {}]\n'
    text += 'start = [-0.4, 0.25, -0.05]\nend = [0.0, 0.25, 0.0]\nstrength = "1 kN"\n'
    case.write_text(text.format(1))
    assert cli.main(["limit", str(case), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["associative"] > 1.5
    case.write_text(text.format(7))
    assert cli.main(["limit", str(case)]) == 2
    assert "reinforcement.ties.0.blocks: [0, 7] are not two blocks; name two" in capsys.readouterr().err


def test_two_blocks_of_one_id():
    with pytest.raises(CaseError, match="block 1: two blocks have this id"):
        check_wall(replace(WALL, blocks=(*WALL.blocks, SpaceBlock(1, CUBE))))

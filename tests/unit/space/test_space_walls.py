"""Blocks in space: reading, refusals, joints, loads."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from orchestrator.app import cli
from orchestrator.basis.arrays import read_only
from orchestrator.basis.errors import CaseError
from orchestrator.geometry.polyhedra import (
    Polyhedron,
    box,
    centroid_of,
    distance_to,
    prism,
    rotation,
    triangles,
    volume_of,
)
from orchestrator.geometry.shared_volume import common_volume
from orchestrator.loads import LiveLoad
from orchestrator.space.analysis import analyse
from orchestrator.space.block_files import wall_from
from orchestrator.space.contacts import FaceContactSettings, find_joints, gaping
from orchestrator.space.loads import SpaceDeadLoad, SpaceLoadSettings, loads_on, top_of
from orchestrator.space.wall import SpaceBlock, check_wall
from tests.support.space_walls import (
    CUBE,
    GROUND,
    L_SHAPE,
    associative,
    block_file_of,
    block_on_ground,
    extruded,
    record,
    wall_of,
)  # fmt: skip


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


def test_the_volume_that_two_bodies_share():
    corner = box((0.5, 0.5, 0.0), (3.0, 3.0, 0.5))
    bent = prism(np.array(L_SHAPE), np.zeros(3), np.eye(3))
    assert common_volume(CUBE, corner) == pytest.approx(0.125)
    exact = 0.5 * (0.5 * 0.5 + 1.0 * 0.5 + 0.5 * 1.0)  # of the L between 0.5 and its ends
    assert common_volume(bent, corner) == pytest.approx(exact)
    assert common_volume(CUBE, box((1.0, 0.0, 0.0), (2.0, 1.0, 1.0))) == 0.0


@pytest.mark.parametrize("turn", [np.eye(3), rotation((1.0, 2.0, 3.0), 0.6)])
@pytest.mark.parametrize(
    ("point", "far"),
    [
        ((0.5, 1.5, 0.5), 0.0), ((1.5, 0.5, 0.5), 0.0), ((1.0, 1.0, 0.5), 0.0), ((0.0, 0.0, 0.0), 0.0),
        ((1.3, 1.5, 0.5), 0.3), ((1.5, 1.4, 0.5), 0.4), ((2.3, 0.5, 1.4), 0.5), ((-1.0, -2.0, -2.0), 3.0),
    ],
)  # fmt: skip
def test_how_far_a_point_lies_from_a_body(turn, point, far):
    """An L of 2 x 2 x 1 m, its inner corner at (1, 1): in its legs, on its edges, in its notch, off its corners."""
    shift = np.array([0.3, -0.2, 0.7])
    shape = prism(np.array(L_SHAPE), np.zeros(3), np.eye(3)).moved(turn, shift)
    assert distance_to(shape, turn @ np.array(point) + shift) == pytest.approx(far, abs=1e-12)


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
        find_joints(wall_of([GROUND, box((4.98, 4.98, 0.0), (6.0, 6.0, 1.0))], 0.6))


def test_a_wall_that_cannot_stand_is_refused():
    leaning = wall_of([GROUND, CUBE, CUBE.moved(np.eye(3), np.array([0.7, 0.0, 1.0]))], 0.6)
    assemblage = find_joints(leaning)
    with pytest.raises(
        CaseError, match=r"^wall: cannot stand under its own weight: block 2 would move, unless held by"
    ):
        analyse(assemblage, loads_on(leaning))


def test_a_wall_that_a_thrust_brings_down_is_said_to_stand_without_it():
    """A block of 20 kN on friction of 0.6, with a thrust of 13 kN at its top, turns and slides: 1 kN at its middle and
    2.5 kN m over its 1 m, 0.175 of its weight, would hold it. One that leans falls anyway."""
    thrust = SpaceLoadSettings(dead=(SpaceDeadLoad(blocks=(1,), force=13e3, direction=(0.0, 1.0, 0.0)),))
    upright = wall_of([GROUND, CUBE], 0.6)
    message = (
        r"load\.dead: the wall stands under its own weight, but not under this dead load too: block 1 would move, "
        r"unless held by a force of 0\.1[78] times the mean weight of a block; lower, move or turn the load, "
    )
    with pytest.raises(CaseError, match=message):
        analyse(find_joints(upright), loads_on(upright, thrust))
    leaning = wall_of([GROUND, CUBE, CUBE.moved(np.eye(3), np.array([0.7, 0.0, 1.0]))], 0.6)
    with pytest.raises(CaseError, match="wall: cannot stand under its own weight: block 2 would move"):
        analyse(find_joints(leaning), loads_on(leaning, thrust))


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
        [GROUND, CUBE, box((1.0, 0.998, 0.0), (2.0, 1.998, 0.02)), box((1.0, -1.0, 0.0), (2.0, 0.5, 1.0))], 0.6
    )
    assemblage = find_joints(wall)
    assert [(one.i, one.j, round(one.area, 8)) for one in assemblage.ignored] == [(1, 2, 4e-5)]


@pytest.mark.parametrize(("gap", "told"), [(0.5e-3, []), (3e-3, [(1, 2)]), (12e-3, [])])
def test_blocks_that_lie_a_little_too_far_apart_are_told(gap, told):
    """Parts of the stones' size: touching, as if they should touch, and apart."""
    wall = wall_of([GROUND, CUBE, box((1.0 + gap, 0.0, 0.0), (2.0 + gap, 1.0, 1.0))], 0.6)
    settings = FaceContactSettings()
    assert gaping(find_joints(wall, settings), settings) == told


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
    with pytest.raises(CaseError, match=r"load.live.0.force: -1 N is not along load.direction"):
        loads_on(wall, SpaceLoadSettings(distribution="per_block", live=(LiveLoad((1,), -1.0),)))


def test_the_mass_of_a_thrust_is_what_it_weighs():
    """A roof of 3 kN that leans on a block with 4 kN besides: the load of 5 kN has the mass of 3 kN."""
    wall = block_on_ground(1.0, 2.0, 0.5, 0.6)
    roof = SpaceDeadLoad(blocks=(1,), force=5e3, direction=(0.0, 4.0, -3.0), inertia=True)
    loads = loads_on(wall, SpaceLoadSettings(direction="+y", dead=(roof,)))
    assert loads.dead[1, :3] == pytest.approx([0.0, 4e3, -20e3 - 3e3])
    assert loads.live[1] == pytest.approx([0.0, 20e3 + 3e3, 0.0, -3e3 * 0.25, 0.0, 0.0])


def test_a_thrust_without_weight_changes_no_mass_and_cannot_be_given_any(tmp_path, capsys):
    """A block 1 m wide and 2 m high of W, with 5 % of W against its top edge: it turns at (0.5 - 2 0.05) / 1 = 0.4."""
    wall = block_on_ground(1.0, 1.0, 2.0, 0.9)
    thrust = {"blocks": (1,), "force": 0.05 * wall.weights[1], "direction": (0.0, 1.0, 0.0)}
    assert associative(wall, "+y", dead=(SpaceDeadLoad(**thrust),)).load_multiplier == pytest.approx(0.4)
    case = tmp_path / "case.toml"
    (tmp_path / "wall.json").write_text(json.dumps(block_file_of([GROUND, box((-0.5, -0.5, 0.0), (0.5, 0.5, 2.0))])))
    load = 'blocks = [1]\nforce = "2 kN"\ninertia = true\n'
    for direction in ("[0, 1, 0]", "[0, 3, 1]"):
        case.write_text(f'[wall]\nblocks = "wall.json"\n[[load.dead]]\n{load}direction = {direction}\n')
        for command in ("check", "limit"):
            assert cli.main([command, str(case), "--output", str(tmp_path / "out")]) == 2
            said = capsys.readouterr().err
            assert said.count("\n") == 1
            assert f"{case}: load.dead.0.inertia: a load along {direction} has no" in said


def test_a_line_load_counts_metres_along_the_wall(tmp_path, capsys):
    """10 kN/m on 0.6 m of wall are 6 kN in all, though its stones are shorter along the wall than it is thick; on a
    return of 0.7 m they are counted along the return, beside 0.7 m of facade that the corner leaves."""
    line = '\n[load]\ndirection = "+y"\n[[load.dead]]\nlevel = "200 mm"\nline_load = "10 kN/m"\n'
    stones = '\ncourses = 2\nlength = "200 mm"\nthickness = "300 mm"\nheight = "100 mm"'
    case = tmp_path / "wall.toml"
    for wall, total in (
        ('generator = "straight"\nfacade = 3', 6.0),
        ('generator = "l"\nfacade = 5\nreturns = 2', 14.0),
    ):
        case.write_text(f"[wall]\n{wall}{stones}{line}")
        assert cli.main(["check", str(case), "--output", str(tmp_path / "out")]) == 0
        (said,) = (text.split() for text in capsys.readouterr().out.splitlines() if "extra:" in text)
        assert float(said[-2]) == pytest.approx(total), wall


def triangulated(shape: Polyhedron) -> Polyhedron:
    """Every face in triangles, in files of meshes and solids."""
    return Polyhedron(shape.vertices, tuple(map(tuple, triangles(shape).tolist())))


@pytest.mark.parametrize("of", [lambda shape: shape, triangulated], ids=["as drawn", "in triangles"])
@pytest.mark.parametrize("load", [{"force": 600.0}, {"line_load": 1e3}])
def test_a_load_on_a_top_stands_at_the_middle_of_its_area(of, load):
    """A block of 0.6 x 0.1 x 0.5 m and 600 N, with as much on its top, pushed over its long side: 1200 N x 0.05 m over
    600 N x 0.25 m = 0.4. On a top with a dent the middle is that of the area, not of the corners."""
    wall = wall_of([GROUND, of(box((0.0, 0.0, 0.0), (0.6, 0.1, 0.5)))], 0.6)
    settings = SpaceLoadSettings(direction="+y", dead=(SpaceDeadLoad(blocks=(1,), **load),))
    dead = loads_on(wall, settings).dead[1]
    assert dead == pytest.approx([0.0, 0.0, -1200.0, 0.0, 0.0, 0.0], abs=1e-9)
    found = associative(wall, "+y", dead=settings.dead)
    assert found.load_multiplier == pytest.approx(1200 * 0.05 / (600 * 0.25), rel=1e-6)
    dented = of(prism(np.array(L_SHAPE), np.zeros(3), np.eye(3)))
    point, _ = top_of(wall_of([GROUND, dented], 0.6), 1)
    assert point == pytest.approx([5 / 6, 5 / 6, 1.0])


@pytest.mark.parametrize("of", [lambda shape: shape, triangulated], ids=["as drawn", "in triangles"])
@pytest.mark.parametrize(("level", "length", "middle"), [(1.0, 0.6, 0.3), (0.9, 0.2, 0.7)])
def test_a_floor_lies_on_the_step_of_a_top_that_is_at_its_level(of, level, length, middle):
    """A stone of 0.8 m with 0.6 m of top at z = 1 and 0.2 m at 0.9; 1 kN/m stand at the middle of either."""
    stepped = extruded([(0, 0), (0.8, 0), (0.8, 0.9), (0.6, 0.9), (0.6, 1), (0, 1)], 0.1)
    wall = wall_of([GROUND, of(stepped)], 0.6)
    load = SpaceDeadLoad(level=level, line_load=1e3)
    extra = (loads_on(wall, SpaceLoadSettings(dead=(load,))).dead - loads_on(wall).dead)[1]
    point, found = top_of(wall, 1, level)
    assert found == pytest.approx(length)
    assert point == pytest.approx([middle, point[1], level])
    assert extra[2] == pytest.approx(-1e3 * length)
    assert extra[4] == pytest.approx(1e3 * length * (middle - wall.centroids[1][0]))


@pytest.mark.parametrize(
    ("load", "key"),
    [({"force": 1e300}, "load.dead.0.force"), ({"line_load": 1e12}, "load.dead.0.line_load")],
)
def test_forces_beside_which_the_weights_have_no_digits_are_refused(load, key):
    wall = wall_of([GROUND, CUBE], 0.6)
    with pytest.raises(CaseError, match="mean weight of a block") as refused:
        loads_on(wall, SpaceLoadSettings(dead=(SpaceDeadLoad(blocks=(1,), **load),)))
    assert refused.value.key == key


def test_mass_times_height():
    wall = wall_of([GROUND, CUBE, CUBE.moved(np.eye(3), np.array([0.0, 0.0, 1.0]))], 0.6)
    live = loads_on(wall, SpaceLoadSettings(distribution="mass_height")).live
    assert live[1:, 0] == pytest.approx([10e3, 30e3])


def test_two_blocks_of_one_id():
    wall, above = wall_of([GROUND, CUBE], 0.6), box((0.0, 0.0, 1.0), (1.0, 1.0, 2.0))
    with pytest.raises(CaseError, match="block 1: two blocks have this id"):
        check_wall(replace(wall, blocks=(*wall.blocks, SpaceBlock(1, above))))


def test_the_loads_on_many_blocks_take_each_centroid_a_few_times(monkeypatch):
    """540 blocks took 8 s, each of them all centroids anew, and 2,000 a minute and a half."""
    wall, asked = wall_of([GROUND, *(CUBE.moved(np.eye(3), np.array([0.0, 0.0, k])) for k in range(20))], 0.6), []
    monkeypatch.setattr("orchestrator.space.wall.centroid_of", lambda shape: asked.append(shape) or centroid_of(shape))
    loads_on(wall, SpaceLoadSettings("+x", dead=(SpaceDeadLoad((20,), force=1e3),)))
    assert 0 < len(asked) <= 5 * len(wall.blocks)

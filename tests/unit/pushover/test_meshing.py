from __future__ import annotations

from dataclasses import replace

import meshio
import numpy as np
import pytest

from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body, one_body_per_block
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import running_bond
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import Wall
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies, volumes
from orchestrator.storage.mesh_files import write_mesh
from tests.support.paths import PROJECT
from tests.support.walls import upright


@pytest.fixture(scope="module")
def wall6():
    return find_joints(read_blocks(PROJECT / "meshes" / "ferris_tinloi_wall6.json"), JointSettings())


@pytest.fixture(scope="module")
def bond():
    assemblage = find_joints(running_bond(3, 3), JointSettings())
    return make_bodies(assemblage, one_body_per_block(assemblage))


def check_bodies(bodies, meshes):
    """Volume of every body, orientation, contiguity, closed boundary."""
    volume = volumes(meshes.nodes, meshes.tetrahedra)
    assert volume.min() > 0
    expected = [body.area * bodies.thickness for body in bodies.bodies[: bodies.moving]]
    assert np.bincount(meshes.body_of_tetrahedron, volume) == pytest.approx(expected, rel=1e-9)
    assert (meshes.body_of_node[meshes.tetrahedra] == meshes.body_of_tetrahedron[:, None]).all()
    assert (np.diff(meshes.body_of_node) >= 0).all()
    assert np.unique(meshes.tetrahedra).size == len(meshes.nodes), "no loose node"


@pytest.mark.parametrize("layers", [1, 2])
def test_every_stone_of_a_bond_is_filled(bond, layers):
    meshes = mesh_bodies(bond, MeshSettings(size=0.1, layers=layers), None)
    check_bodies(bond, meshes)
    assert np.unique(np.round(meshes.nodes[:, 2], 9)).size == layers + 1


def test_side_triangles_cover_the_extruded_outline_and_point_outwards(wall6):
    bodies = make_bodies(wall6, one_body(wall6))
    meshes = mesh_bodies(bodies, MeshSettings(size=0.2), None)
    check_bodies(bodies, meshes)
    a, b, c = (meshes.nodes[meshes.side_triangles[:, k]] for k in range(3))
    area = 0.5 * np.cross(b - a, c - a)
    perimeter = 2 * (2.8 + 3.675) + 4 * 2 * (0.4 + 0.875)
    assert np.linalg.norm(area, axis=1).sum() == pytest.approx(perimeter * 0.1, rel=1e-9)
    flux = np.sum(area * (a + b + c) / 3, axis=1).sum()  # divergence theorem: 2 x volume for the sides alone
    assert flux == pytest.approx(2 * bodies.bodies[0].area * 0.1, rel=1e-9)


@pytest.mark.parametrize(
    "settings", [MeshSettings(), MeshSettings(0.07, 2), MeshSettings(0.13, 2, matching_faces=True)]
)
def test_sides_know_the_edge_that_they_lie_on(wall6, bond, settings):
    """Every edge of the outline and of the openings has its sides, which fill it."""
    for bodies in (make_bodies(wall6, one_body(wall6)), bond):
        meshes = mesh_bodies(bodies, settings, None)
        for body in bodies.bodies[: bodies.moving]:
            rings = (body.exterior, *body.holes)
            start, end = np.concatenate(rings), np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
            length = np.linalg.norm(end - start, axis=1)
            mine = meshes.body_of_side == body.number
            edge, corners = meshes.side_edge[mine], meshes.nodes[meshes.side_triangles[mine]]
            normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            area = np.bincount(edge, 0.5 * np.linalg.norm(normal, axis=1))
            assert area == pytest.approx(length * bodies.thickness, rel=1e-7)
            unit = ((end - start) / length[:, None])[edge]
            arm = corners[..., :2] - start[edge][:, None]
            assert np.abs(arm[..., 0] * unit[:, None, 1] - arm[..., 1] * unit[:, None, 0]).max() < 3e-9


def test_joint_ends_are_nodes_on_both_faces(bond):
    meshes = mesh_bodies(bond, MeshSettings(size=0.13), None)
    for k in range(len(bond.joint)):
        for body in {int(bond.interfaces.i[k]), int(bond.interfaces.j[k])} & set(range(bond.moving)):
            nodes = meshes.nodes[meshes.body_of_node == body]
            for end in (bond.interfaces.start[k], bond.interfaces.end[k]):
                at_end = nodes[np.linalg.norm(nodes[:, :2] - end, axis=1) < 1e-9]
                assert sorted(at_end[:, 2]) == pytest.approx([0.0, 0.1])


def test_stones_of_wall_6_are_meshed_with_half_stone_edges(wall6):
    """Size 0.2 m: an edge of 0.2 m stays whole, a free one of 0.4 m is halved; few shapes are meshed for 146 stones."""
    bodies = make_bodies(wall6, one_body_per_block(wall6))
    meshes = mesh_bodies(bodies, MeshSettings(size=0.2), None)
    check_bodies(bodies, meshes)
    assert meshes.distinct_shapes == 4
    stones = [body.exterior for body in bodies.bodies[: bodies.moving]]
    edges = np.concatenate([np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1) for ring in stones])
    on_sides = np.unique(meshes.side_triangles).size
    assert on_sides == 2 * ((edges < 0.201).sum() + 2 * (edges > 0.399).sum())
    assert len(meshes.nodes) - on_sides <= 4 * bodies.moving, "at most two points inside a stone's triangulation"


def test_finer_size_divides_edges(bond):
    coarse, fine = (mesh_bodies(bond, MeshSettings(size=size), None) for size in (0.2, 0.05))
    assert len(fine.nodes) > 4 * len(coarse.nodes)
    edges = fine.nodes[fine.side_triangles] - np.roll(fine.nodes[fine.side_triangles], 1, axis=1)
    assert np.linalg.norm(edges[..., :2], axis=2).max() < 0.0501


def test_same_input_gives_the_same_bits(bond):
    first, second = (mesh_bodies(bond, MeshSettings(size=0.07), None) for _ in range(2))
    assert first.nodes.tobytes() == second.nodes.tobytes()
    assert first.tetrahedra.tobytes() == second.tetrahedra.tobytes()


def test_cache_gives_identical_arrays_and_survives_damage(bond, tmp_path):
    made = mesh_bodies(bond, MeshSettings(), tmp_path)
    files = sorted(tmp_path.glob("*.npz"))
    assert len(files) == made.distinct_shapes > 0
    stamps = [file.stat().st_mtime_ns for file in files]
    read = mesh_bodies(bond, MeshSettings(), tmp_path)
    assert [file.stat().st_mtime_ns for file in files] == stamps, "nothing is meshed twice"
    assert made.nodes.tobytes() == read.nodes.tobytes()
    files[0].write_bytes(files[0].read_bytes()[:100])
    again = mesh_bodies(bond, MeshSettings(), tmp_path)
    assert made.nodes.tobytes() == again.nodes.tobytes()
    assert len(files[0].read_bytes()) > 100, "the damaged file was made again"
    mesh_bodies(bond, MeshSettings(size=0.1), tmp_path)
    assert len(list(tmp_path.glob("*.npz"))) > len(files), "another size is another mesh"


def test_one_changed_bit_in_the_cache_is_found_and_named(bond, tmp_path, caplog):
    made = mesh_bodies(bond, MeshSettings(), tmp_path)
    file = min(tmp_path.glob("*.npz"))
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 4
    file.write_bytes(content)
    again = mesh_bodies(bond, MeshSettings(), tmp_path)
    assert made.nodes.tobytes() == again.nodes.tobytes()
    (record,) = caplog.records
    assert str(file) in record.message
    assert "made again" in record.message
    caplog.clear()
    mesh_bodies(bond, MeshSettings(), tmp_path)
    assert not caplog.records, "it was mended"


def test_a_cache_that_cannot_be_written_costs_time_not_the_run(bond, tmp_path, caplog):
    (tmp_path / "taken").write_text("a file where the cache should be")
    meshes = mesh_bodies(bond, MeshSettings(), tmp_path / "taken")
    assert len(meshes.nodes)
    assert "not kept for the next run" in caplog.text


@pytest.mark.parametrize("name", ["mesh.msh", "mesh.vtu", "mesh.xdmf"])
def test_written_meshes_read_back(bond, tmp_path, name, monkeypatch):
    monkeypatch.chdir(tmp_path)  # meshio writes the .h5 of an .xdmf file into the current folder
    meshes = mesh_bodies(bond, MeshSettings(), None)
    write_mesh(meshes, tmp_path / name)
    read = meshio.read(tmp_path / name)
    assert read.points == pytest.approx(meshes.nodes)
    assert (read.get_cells_type("tetra") == meshes.tetrahedra).all()
    assert (np.concatenate(read.cell_data["body"]) == meshes.body_of_tetrahedron).all()


def test_left_out_the_size_is_a_share_of_the_stones_at_any_scale_and_in_macroblocks():
    wall = read_blocks(PROJECT / "meshes" / "ferris_tinloi_wall6.json")
    tenth = replace(wall, blocks=tuple(replace(one, polygon=0.1 * one.polygon) for one in wall.blocks), thickness=0.01)
    elements = []
    for one in (wall, tenth):
        assemblage = find_joints(one, JointSettings())
        bodies = make_bodies(assemblage, one_body_per_block(assemblage))
        merged = make_bodies(assemblage, one_body(assemblage))
        assert MeshSettings().size_of(merged) == pytest.approx(MeshSettings().size_of(bodies), rel=1e-9)
        elements.append([len(mesh_bodies(of, MeshSettings(), None).tetrahedra) for of in (bodies, merged)])
    assert elements[0] == pytest.approx(elements[1], rel=0.01), "gmsh rounds"


def test_a_small_pin_changes_no_elements_of_the_wall():
    stones = [upright(row, 0.0, 0.5 * row, 1.0, 0.5, fixed=row == 0) for row in range(4)]
    pin = upright(4, 1.0, 0.5, 0.02, 0.02)
    sizes = []
    for blocks in (stones, [*stones, pin]):
        assemblage = find_joints(Wall("pinned", tuple(blocks), 0.3, 0.6), JointSettings())
        sizes.append(MeshSettings().size_of(make_bodies(assemblage, one_body_per_block(assemblage))))
    assert sizes[1] == pytest.approx(sizes[0], rel=1e-3)


def in_plane_edges(meshes):
    """Return lengths and distances from the outline (of the nearer end) of the edges in the plane z = 0, in m."""
    pairs = np.unique(
        np.sort(meshes.tetrahedra[:, [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]].reshape(-1, 2)), axis=0
    )
    ends = meshes.nodes[pairs[(meshes.nodes[pairs, 2] == 0.0).all(axis=1)]][:, :, :2]
    outline = meshes.nodes[np.unique(meshes.side_triangles)][:, :2]
    away = np.linalg.norm(ends[:, :, None] - outline, axis=3).min(axis=(1, 2))
    return np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1), away


def test_elements_grow_inside_of_a_large_body_and_not_along_its_outline():
    assemblage = find_joints(running_bond(10, 14), JointSettings())
    bodies = make_bodies(assemblage, one_body(assemblage))
    size = MeshSettings().size_of(bodies)
    grown, even = (mesh_bodies(bodies, MeshSettings(growth=growth), None) for growth in (0.7, 0.0))
    check_bodies(bodies, grown)
    assert np.unique(grown.side_triangles).size == np.unique(even.side_triangles).size
    assert len(grown.nodes) < 0.5 * len(even.nodes)
    length, away = in_plane_edges(grown)
    assert length[away == 0.0].max() < 1.7 * size
    assert length.max() > 4.0 * size
    assert (length < 1.5 * (1.2 * size + 0.7 * away)).all()
    assert in_plane_edges(even)[0].max() < 1.5 * size


def test_stones_of_two_elements_across_have_no_inside_to_grow_in(bond):
    grown, even = (mesh_bodies(bond, MeshSettings(growth=growth), None) for growth in (0.7, 0.0))
    assert np.array_equal(grown.nodes, even.nodes)

"""Stored increments survive kills and say when they are damaged or strangers; ParaView files hold what was stored."""

from __future__ import annotations

import hashlib
import os
import signal
import subprocess
import sys
import time
from dataclasses import fields, replace
from pathlib import Path

import h5py
import meshio
import numpy as np
import pytest

from orchestrator.basis.errors import CaseError
from orchestrator.pushover.increments import Attempt, Increment
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.storage import (
    ContactPlaces,
    StateStore,
    read_geometry,
    write_geometry,
    write_paraview,
)
from tests.support.paths import PROJECT


def increment(number, nodes=5, contacts=3, ties=2):
    """An increment whose arrays follow from its number."""
    random = np.random.default_rng(number)
    numbers = {f.name: random.random() for f in fields(Increment) if f.type == "float"}
    return Increment(
        **numbers,
        number=number,
        phase="gravity" if number < 2 else "displacement",
        displacement=random.random((nodes, 3)),
        change=random.random((nodes, 3)),
        normal_force=random.random(contacts),
        elastic_slip=random.random((contacts, 2)),
        slip=random.random(contacts),
        damage=random.random(contacts),
        closing=random.random(contacts),
        tie_force=random.random(ties),
        tie_rest=random.random(ties),
        gap=random.random(contacts),
        overlap=random.random(contacts),
        status=random.integers(0, 3, contacts),
        moving=bool(number % 2),
        driven=random.random(2) > 0.5,
        fallen=random.random(2) > 0.5,
        gone=random.random(2),
        iterations=number + 1,
        step=(0.1, 1 / 3),
        attempts=(Attempt("slip states cycle", np.float64(1 / 7), "halved", np.int64(9)),) * (number % 3),
    )


def assert_same(one, other):
    for field in fields(Increment):
        left, right = getattr(one, field.name), getattr(other, field.name)
        if isinstance(left, np.ndarray):
            np.testing.assert_array_equal(left, right, strict=True)
        else:
            assert left == right, field.name


@pytest.fixture
def store(tmp_path):
    """Three increments in single files."""
    made = StateStore(tmp_path / "micro", "model 1")
    for number in range(3):
        made.append(increment(number))
    return made


@pytest.mark.parametrize("assembled", [False, True])
def test_every_field_comes_back_exactly(store, assembled):
    if assembled:
        store.assemble()
    loaded = list(StateStore(store.folder, "model 1").increments())
    assert len(loaded) == 3
    for number, found in enumerate(loaded):
        assert_same(found, increment(number))
        assert not found.displacement.flags.writeable
    assert_same(store.last(), increment(2))
    assert type(loaded[0].time) is float
    assert type(loaded[0].number) is int


def test_no_field_of_the_increment_is_forgotten_by_the_file(store):
    with h5py.File(store.assemble()) as file:
        stored = {*file["000002"], *file["000002"].attrs}
    assert {f.name for f in fields(Increment)} == stored - {"sha256", "fingerprint"}


def test_nothing_stored_is_an_empty_store(tmp_path):
    assert list(StateStore(tmp_path / "nowhere", "x").increments()) == []
    assert StateStore(tmp_path, "x").last() is None


def test_assembled_file_replaces_the_single_ones_and_can_be_continued(store):
    store.assemble()
    assert [p.name for p in store.folder.iterdir()] == ["states.h5"]
    store.append(increment(3))
    assert store.numbers() == [0, 1, 2, 3]
    store.assemble()
    for number, found in enumerate(StateStore(store.folder, "model 1").increments()):
        assert_same(found, increment(number))
    assert store.numbers() == [0, 1, 2, 3]
    assert [p.name for p in store.folder.iterdir()] == ["states.h5"]


@pytest.mark.parametrize("room", [0, 2, 10])
def test_what_is_in_memory_is_what_is_on_the_disk(tmp_path, room):
    """Appended, replaced, gathered and read in any order, with room for none, some or all of six increments."""
    size = sum(v.nbytes for v in (getattr(increment(0), f.name) for f in fields(Increment)) if hasattr(v, "nbytes"))
    store = StateStore(tmp_path, "model 1", memory=room * size)
    for number in range(4):
        store.append(increment(number))
    store.append(replace(increment(2), time=7.0))
    store.assemble()
    for number in (4, 5):
        store.append(increment(number))
    for order in (range(6), [5, 0, 2], [2, 1, 2]):
        for found, on_disk in zip(store.these(order), StateStore(tmp_path, "model 1").these(order), strict=True):
            assert_same(found, on_disk)
    (tmp_path / "states.h5").unlink()  # of the first four
    assert [found.number for found in store.these(range(min(room, 4)))] == list(range(min(room, 4)))
    if room < 4:
        with pytest.raises(CaseError, match="is missing"):
            store.read(3)
    store.clear()
    assert list(store.increments()) == []


def test_clear_forgets_everything(store):
    store.assemble()
    store.append(increment(3))
    store.clear()
    assert store.numbers() == []
    assert list(store.folder.iterdir()) == []


@pytest.mark.parametrize("assembled", [False, True])
def test_another_model_is_refused_in_one_line_with_file_and_remedy(store, assembled):
    if assembled:
        store.assemble()
    with pytest.raises(CaseError) as caught:
        list(StateStore(store.folder, "model 2").increments())
    said = str(caught.value)
    assert str(store.folder / "states") in said
    assert "another model" in said
    assert "without --resume" in said
    assert "\n" not in said


def truncated(content):
    return content[: len(content) // 2]


def emptied(content):
    return b""


def flipped(content):
    """One bit of the displacements changed."""
    place = content.index(increment(1).displacement.tobytes())
    return content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :]


@pytest.mark.parametrize("harm", [truncated, emptied, flipped])
@pytest.mark.parametrize("assembled", [False, True])
def test_damage_is_found_and_named(store, harm, assembled):
    path = store.assemble() if assembled else store.folder / "states" / "000001.h5"
    path.write_bytes(harm(path.read_bytes()))
    with pytest.raises(CaseError, match="damaged") as caught:
        list(StateStore(store.folder, "model 1").increments())
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("file", ["states.h5", "states/000001.h5", "geometry.h5"])
def test_a_bit_flipped_anywhere_is_found_and_named(store, meshes, file):
    """Superblock, directory, attributes, numbers, seal: fifty places over the whole file, and both of its ends."""
    if file == "states.h5":
        store.assemble()
    places = ContactPlaces(*np.zeros((2, 1), dtype=int))
    write_geometry(store, meshes, places)
    path = store.folder / file
    whole = path.read_bytes()
    read = (lambda: read_geometry(store.folder)) if file == "geometry.h5" else (lambda: list(store.increments()))
    read()
    random = np.random.default_rng(4)
    for place in [0, len(whole) - 1, *random.integers(0, len(whole), 50)]:
        damaged = bytearray(whole)
        damaged[place] ^= 1 << random.integers(8)
        path.write_bytes(damaged)
        with pytest.raises(CaseError, match="damaged") as caught:
            read()
        assert str(path) in str(caught.value)
        assert "\n" not in str(caught.value)
    path.write_bytes(whole)
    read()


def test_the_seal_is_passed_over_by_other_readers_of_hdf5(store):
    """ParaView, h5dump and others read states.h5 without knowing of it."""
    path = store.assemble()
    assert path.read_bytes()[-32:] == hashlib.sha256(path.read_bytes()[:-32]).digest()
    with h5py.File(path) as file:
        np.testing.assert_array_equal(file["000001/displacement"], increment(1).displacement)


def test_a_foreign_file_among_the_increments_is_passed_over(store):
    (store.folder / "states" / "12x.h5").write_text("mine")
    assert store.numbers() == [0, 1, 2]


def test_damage_to_a_single_file_leaves_the_others_readable(store):
    (store.folder / "states" / "000001.h5").write_bytes(b"")
    assert_same(store.read(0), increment(0))
    assert_same(store.last(), increment(2))


def test_a_half_written_increment_is_not_seen_and_swept_away(store):
    leftover = store.folder / "states" / ".000003.h5.orchestrator-0a1b2c3d.tmp"
    leftover.write_bytes((store.folder / "states" / "000002.h5").read_bytes()[:3000])
    assert store.numbers() == [0, 1, 2]
    store.assemble()
    assert not leftover.exists()
    assert len(list(StateStore(store.folder, "model 1").increments())) == 3


WRITER = """
import sys
from pathlib import Path
sys.path[:0] = sys.argv[1:3]
from test_increments import StateStore, increment
store = StateStore(Path(sys.argv[3]), "model 1")
for number in range(1000):
    store.append(increment(number, nodes=2000, contacts=1400))
    print(number, flush=True)
    if number % 5 == 4:
        store.assemble()
"""


@pytest.mark.parametrize(("told", "delay"), [(1, 0.0), (4, 0.003), (5, 0.006), (10, 0.012), (23, 0.002)])
def test_killed_at_any_moment_all_earlier_increments_are_there(tmp_path, told, delay):
    """SIGKILL shortly after `told` increments were reported as stored, while appending or assembling."""
    command = [sys.executable, "-c", WRITER, str(PROJECT), str(Path(__file__).parent), str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        for _ in range(told):
            process.stdout.readline()
        time.sleep(delay)
        os.kill(process.pid, signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL
    loaded = list(StateStore(tmp_path, "model 1").increments())
    assert len(loaded) >= told
    assert [i.number for i in loaded] == list(range(len(loaded)))
    for found in loaded:
        assert_same(found, increment(found.number, nodes=2000, contacts=1400))
    store = StateStore(tmp_path, "model 1")
    store.append(increment(len(loaded)))
    store.assemble()
    assert [p.name for p in tmp_path.iterdir()] == ["states.h5"]
    assert store.numbers() == list(range(len(loaded) + 1))


@pytest.fixture
def meshes():
    """Two tetrahedra of two bodies, 8 nodes."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    return BodyMeshes(
        nodes=np.vstack([corners, corners + np.array([2.0, 0, 0])]),
        tetrahedra=np.arange(8).reshape(2, 4),
        body_of_node=np.repeat([0, 1], 4),
        body_of_tetrahedron=np.array([0, 1]),
        side_triangles=np.array([[0, 1, 3], [4, 5, 7]]),
        body_of_side=np.array([0, 1]),
        side_edge=np.array([0, 0]),
        unit_weight=np.full(2, 25e3),
        distinct_shapes=1,
        seconds=0.0,
    )


def read_series(path):
    with meshio.xdmf.TimeSeriesReader(path) as reader:
        points, cells = reader.read_points_cells()
        return points, cells, [reader.read_data(k) for k in range(reader.num_steps)]


def test_paraview_files_hold_every_step_at_its_number(tmp_path, meshes, monkeypatch):
    monkeypatch.chdir("/")  # the file must not depend on the current directory
    store = StateStore(tmp_path / "micro", "model 1")
    for number in (0, 4, 11):
        store.append(increment(number, nodes=8))
    contact_points = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.5]])
    wall, contacts = write_paraview(store, meshes, contact_points)

    points, cells, steps = read_series(wall)
    np.testing.assert_array_equal(points, meshes.nodes)
    assert [(c.type, c.data.tolist()) for c in cells] == [("tetra", meshes.tetrahedra.tolist())]
    assert [time for time, _, _ in steps] == [0, 4, 11]
    for number, (_, node_data, cell_data) in zip((0, 4, 11), steps, strict=True):
        np.testing.assert_array_equal(node_data["displacement_m"], increment(number, nodes=8).displacement)
        np.testing.assert_array_equal(cell_data["body"], [[0, 1]])

    points, cells, steps = read_series(contacts)
    np.testing.assert_array_equal(points, [[0, 0, 0], [1, 0, 0], [2, 0.5, 0]])
    assert [c.type for c in cells] == ["vertex"]
    stored = increment(11, nodes=8)
    shown = {"normal_force_N": "normal_force", "gap_m": "gap", "slip_m": "slip", "status": "status"}
    for name, field in shown.items():
        np.testing.assert_array_equal(steps[2][1][name], getattr(stored, field))


def test_paraview_without_contacts_writes_the_wall_alone(tmp_path, meshes):
    store = StateStore(tmp_path, "model 1")
    store.append(increment(0, nodes=8))
    assert write_paraview(store, meshes) == [tmp_path / "wall.xdmf"]
    assert not (tmp_path / "contacts.xdmf").exists()


def test_paraview_files_end_with_the_curve(tmp_path, meshes):
    """What was followed beyond the end of a curve, where it may not be used, was shown as if it were of the curve."""
    store = StateStore(tmp_path, "model 1")
    for number in (0, 4, 11):
        store.append(increment(number, nodes=8))
    (wall,) = write_paraview(store, meshes, last=4)
    assert [time for time, _, _ in read_series(wall)[2]] == [0, 4]

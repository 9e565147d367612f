"""Values in the run folder are written as they are: case, blocks, joints, limit analysis, macroblocks, curve."""

from __future__ import annotations

import csv
import json
from dataclasses import fields, replace

import numpy as np
import pytest

from orchestrator import storage
from orchestrator.basis.arrays import read_only
from orchestrator.macroblocks.bodies import Bodies, Body
from orchestrator.masonry.interfaces import straight_interfaces
from orchestrator.masonry.points_in_common import PointInCommon
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.pushover.increments import PushoverCurve
from tests.support.walls import between


@pytest.fixture
def curve():
    counts = np.array([1, 2, 3])
    ramp = np.array([0.0, 0.1, 1 / 3])
    return PushoverCurve(counts, *7 * [ramp], *4 * [counts], ramp, *2 * [counts], "done")


def test_case_is_written_as_given(tmp_path):
    storage.write_case(tmp_path, '[wall]\nfile = "ü.json"\n')
    assert (tmp_path / "case.toml").read_text(encoding="utf-8") == '[wall]\nfile = "ü.json"\n'


def test_blocks_file_is_a_block_file_that_gives_the_same_wall(tmp_path, assemblage):
    *others, heavy = assemblage.wall.blocks
    wall = replace(assemblage.wall, blocks=(*others, replace(heavy, unit_weight=27123.4, material="tuff")))
    storage.write_blocks(tmp_path, wall)
    found = read_blocks(tmp_path / "blocks.json")
    assert (found.name, found.thickness, found.friction) == ('Wall "ä" <&>', 0.1, 0.65)
    assert [(b.id, b.fixed) for b in found.blocks] == [(10, True), (11, False), (12, False), (13, False)]
    assert [b.unit_weight for b in found.blocks] == [25e3, 25e3, 25e3, 27123.4]
    assert [b.material for b in found.blocks] == ["", "", "", "tuff"]
    for one, other in zip(found.blocks, wall.blocks, strict=True):
        np.testing.assert_array_equal(one.polygon, other.polygon)


def test_joints_file_names_blocks_by_id(tmp_path, assemblage):
    storage.write_joints(tmp_path, assemblage)
    with (tmp_path / "joints.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 5
    values = ["3", "11", "13", "1.0", "0.5", "0.5", "0.5", "0.5", "0.65", "0.0", "0.0", "", "", ""]
    assert list(rows[3].values()) == values
    assert list(rows[3])[3:8] == ["start_x_m", "start_y_m", "end_x_m", "end_y_m", "length_m"]


def test_a_limit_analysis_is_read_back_whole(tmp_path, assemblage, analysis):
    """`report` verifies by what it reads: which stones go on moving without live load is part of it."""
    other = analysis.sequence
    whole = replace(
        analysis, lowest=other, associative_left=other, drawn=other, last_rest=0.28, soft_from=0.2, interval=(0.2, 0.3),
        rigid_peak=0.27, pressed_peak=0.26, points_in_common=(PointInCommon((11, 12), (0.5, 1.0)),), is_bound=False,
        ways_out={"held": 2}, going_down=(13,), factorisations=17, rigid_curve=np.array([[0.0, 0.0], [1e-3, 0.25]]),
    )  # fmt: skip
    storage.write_limit_analysis(tmp_path, assemblage.wall, whole)
    found = storage.read_limit_analysis(tmp_path)
    for name in {one.name for one in fields(whole)} - {"wall"}:
        assert str(getattr(whole, name)) not in ("None", "()", "{}", ""), f"{name} would be as good if it were lost"
        assert str(getattr(found, name)) == str(getattr(whole, name)), name


def test_the_curve_of_rigid_blocks_is_read_back_as_it_was(tmp_path, assemblage, analysis):
    curve = np.array([[0.0, 0.0], [1e-3, 0.25], [2e-3, 0.2]])
    for given in (None, curve):
        pushed = replace(analysis, rigid_curve=given, elastic_modulus=2e9, ways_out={"push held": 1})
        storage.write_limit_analysis(tmp_path, assemblage.wall, pushed)
        found = storage.read_limit_analysis(tmp_path)
        assert found.elastic_modulus == 2e9
        assert found.ways_out == {"push held": 1}
        assert (found.rigid_curve is None) if given is None else np.array_equal(found.rigid_curve, given)
        assert (storage.write_rigid_curve(tmp_path, pushed) is None) == (given is None)
    with (tmp_path / "rigid_pushover.csv").open() as file:
        peak = list(csv.DictReader(file))[1]
    assert float(peak["base_shear_N"]) == 0.25 * analysis.horizontal_load


def test_the_curve_under_an_upright_live_load_has_that_load(tmp_path, analysis):
    live = read_only(np.array([[0.0, -30.0, 0.0], [0.0, -70.0, 0.0]]))
    pushed = replace(
        analysis, rigid_curve=np.array([[0.0, 0.0], [1e-3, 0.25]]), loads=replace(analysis.loads, live=live)
    )
    storage.write_rigid_curve(tmp_path, pushed)
    with (tmp_path / "rigid_pushover.csv").open() as file:
        peak = list(csv.DictReader(file))[1]
    assert float(peak["live_load_N"]) == 25.0
    assert "base_shear_N" not in peak


def test_limit_analysis_file_holds_every_state(tmp_path, assemblage, analysis):
    storage.write_limit_analysis(tmp_path, assemblage.wall, replace(analysis, path=None))
    record = json.loads((tmp_path / "limit_analysis.json").read_text())
    assert record["path"] is None
    assert record["headline"] == "sequence"
    assert record["sequence"]["load_multiplier"] == 0.29
    assert record["sequence"]["base_shear_N"] == pytest.approx(906.25)
    assert len(record["sequence"]["records"]) == 7
    assert record["associative"]["joint_forces_N"][4] == [12, 13, 14]
    assert record["blocks"] == [10, 11, 12, 13]
    assert record["sequence"]["mechanism"]["block_velocities"][3] == [9, 10, 11]


def test_macroblocks_file_holds_partition_and_polygons(tmp_path, assemblage, partition):
    hole = between(0.2, 0.1, 0.4, 0.2)[::-1]
    outlines = [between(0, 0, 2, 0.5), between(0.5, 0.5, 1.5, 1), between(0, -0.2, 2, 0)]
    blocks = [[1, 2], [3], [0]]
    made = [
        Body(n, f"block {n}", outlines[n], (hole,) if n == 0 else (), n == 2, 25e3, np.array(blocks[n]))
        for n in range(3)
    ]
    ends = np.array([[2.0, 0]]), np.zeros((1, 2))
    interfaces = straight_interfaces(np.array([2]), np.array([0]), *ends, 0.1, np.ones(1))
    no_toes = np.zeros(1), np.zeros((1, 2))
    bodies = Bodies(tuple(made), 2, 0.1, interfaces, np.array([0]), np.array([2]), np.array([0]), 1.0, *no_toes)
    storage.write_macroblocks(tmp_path, assemblage.wall, partition, bodies)
    record = json.loads((tmp_path / "macroblocks.json").read_text())
    assert record["body_of_block"][3] == {"block": 13, "body": 1}
    assert record["vanished_joints"] == [2]
    assert record["tolerances"]["tol_d"] == 0.45
    assert record["tolerances"]["tol_r"] is None  # no condition
    assert record["bodies"][0]["blocks"] == [11, 12]
    assert record["bodies"][0]["holes_m"] == [hole.tolist()]
    assert record["interfaces"]["start_m"] == [[2, 0]]


def test_curve_file_has_the_columns_of_the_design_and_loses_no_digit(tmp_path, curve):
    storage.write_curve(tmp_path, curve)
    header, *rows = (tmp_path / "curve.csv").read_text().splitlines()
    assert header == (
        "step,time_s,load_multiplier,base_shear_N,horizontal_load_N,control_displacement_m,internal_energy_J,"
        "dissipated_energy_J,open_contacts,sticking_contacts,slipping_contacts,newton_iterations,out_of_balance,moving,"
        "fallen_bodies"
    )
    assert len(rows) == 3
    assert rows[2].split(",")[0] == "3"
    assert float(rows[2].split(",")[3]) == 1 / 3

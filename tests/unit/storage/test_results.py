"""The run folder: files whole or absent, values written as they are, the summary with exactly its keys."""

from __future__ import annotations

import csv
import hashlib
import json
import logging
import sys
from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest

from orchestrator import storage
from orchestrator.assessment.capacity import Capacity
from orchestrator.basis.atomic_files import replacing
from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis.paper.limit_state import (
    LimitAnalysis,
    LimitState,
    LinearProgramRecord,
    LocalFailure,
    Mechanism,
)
from orchestrator.macroblocks.bodies import Bodies, Body
from orchestrator.macroblocks.criteria import MacroblockSettings, Partition
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.pushover.increments import Attempt, Increment, PushoverCurve
from orchestrator.pushover.meshing import BodyMeshes
from tests.support.walls import between, four_blocks


@pytest.fixture
def assemblage():
    return four_blocks('Wall "ä" <&>')


def limit_state(rule, multiplier, programs):
    mechanism = Mechanism(np.arange(12.0).reshape(4, 3), np.ones((5, 2)), np.full(5, 2.0), 3.0)
    records = tuple(LinearProgramRecord(multiplier, 0.1, 12, 0.01, "Solved") for _ in range(programs))
    return LimitState(
        flow_rule=rule,
        load_multiplier=multiplier,
        joint_forces=np.arange(15.0).reshape(5, 3),
        mechanism=mechanism,
        records=records,
        converged=True,
        equilibrium_residual=1e-12,
        yield_residual=2e-12,
        power_residual=3e-12,
        dilation=0.0,
    )


@pytest.fixture
def analysis():
    return LimitAnalysis(
        load_direction=1,
        weight=3125.0,
        horizontal_load=3125.0,
        tilting_table=True,
        associative=limit_state("associative", 0.35, 1),
        sequence=limit_state("sequence", 0.29, 7),
        path=limit_state("path", 0.29, 7),
        highest=0.31,
        local_failures=(LocalFailure((13,), 0.02, (0.1, 0.2), limit_state("path", 0.2, 7)),),
        remarks=("hand made",),
        seconds=0.5,
    )


@pytest.fixture
def partition():
    """Blocks 11 and 12 are one body, 13 another, the support a third."""
    return Partition(np.array([2, 0, 0, 1]), 2, np.array([2]), np.array([], dtype=int), MacroblockSettings())


@pytest.fixture
def curve():
    counts = np.array([1, 2, 3])
    ramp = np.array([0.0, 0.1, 1 / 3])
    return PushoverCurve(counts, *7 * [ramp], *4 * [counts], ramp, *2 * [counts], "done")


def increment(number, **changed):
    made = Increment(
        number=number, phase="load", time=0.1 * number, load_multiplier=0.1, displacement=np.zeros((4, 3)),
        change=np.zeros((4, 3)), normal_force=np.ones(2), elastic_slip=np.zeros((2, 2)), slip=np.zeros(2),
        damage=np.zeros(2), closing=np.zeros(2), tie_force=np.zeros(0), tie_rest=np.zeros(0),
        gap=np.zeros(2), overlap=np.zeros(2), status=np.array([1, 2]), base_shear=1.0,
        horizontal_load=10.0, control_displacement=0.0, mean_displacement=0.0,
        internal_energy=1.0, dissipated_energy=0.0, external_work=0.0, other_work=0.0, live_work=0.0,
        lost_in_motion=0.0,
        energy_error=0.0, largest_base_shear=0.0, out_of_balance=0.0, moving=False,
        driven=np.ones(2, bool), fallen=np.zeros(2, bool), gone=np.zeros(2), equilibrium_residual=0.0,
        iterations=3, step=(0.1, 0.2),
    )  # fmt: skip
    return replace(made, **changed)


# files


def test_a_file_is_replaced_whole_and_nothing_temporary_stays(tmp_path):
    path = tmp_path / "new" / "a.txt"
    storage.write_text(path, "old")
    storage.write_text(path, "µ = 0.65\n")
    assert path.read_bytes() == "µ = 0.65\n".encode()
    assert [p.name for p in path.parent.iterdir()] == ["a.txt"]


def test_an_error_while_writing_leaves_the_older_file_and_no_temporary_one(tmp_path):
    path = tmp_path / "a.txt"
    storage.write_text(path, "old")

    def fails_half_way():
        with replacing(path) as temporary:
            temporary.write_text("half of the n")
            raise OSError("disk full")

    with pytest.raises(OSError, match="disk full"):
        fails_half_way()
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_the_target_appears_only_after_everything_is_written(tmp_path):
    path = tmp_path / "a.txt"
    with replacing(path) as temporary:
        temporary.write_text("x")
        assert not path.exists()
        assert temporary.parent == path.parent  # rename must not cross file systems
    assert path.read_text() == "x"


def test_json_turns_numpy_into_plain_values_and_infinity_into_null(tmp_path):
    storage.write_json(tmp_path / "a.json", {"a": np.array([[1, 2]]), "b": (np.float64(0.1), inf, nan), "c": np.True_})
    text = (tmp_path / "a.json").read_text()
    assert json.loads(text) == {"a": [[1, 2]], "b": [0.1, None, None], "c": True}


def test_hash_is_sha256(tmp_path):
    (tmp_path / "a").write_bytes(b"abc")
    assert storage.hash_file(tmp_path / "a") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"


def test_versions_name_what_is_installed_and_skip_what_is_not(monkeypatch):
    monkeypatch.setitem(storage.files.DISTRIBUTIONS, "absent", "surely-not-installed-anywhere")
    found = storage.versions()
    assert found["numpy"] == np.__version__
    assert {"python", "scipy", "h5py"} <= set(found)
    assert "absent" not in found


def test_run_log_takes_the_package_s_messages_and_lets_go_of_the_logger(tmp_path):
    before = list(logging.getLogger("orchestrator").handlers)
    for message in ("first", "second"):  # a resumed run appends
        with storage.logging_to(tmp_path / "run.log"):
            logging.getLogger("orchestrator.pushover").info(message)
            logging.getLogger("orchestrator.pushover").debug("chatter")
            logging.getLogger("elsewhere").error("other")
    logging.getLogger("orchestrator.pushover").error("too late")
    lines = (tmp_path / "run.log").read_text().splitlines()
    assert [line.rsplit(" ", 3)[1:] for line in lines] == [
        ["INFO", "orchestrator.pushover:", message] for message in ("first", "second")
    ]
    assert logging.getLogger("orchestrator").handlers == before


def test_run_log_ends_with_what_stopped_the_run(tmp_path):
    with pytest.raises(CaseError), storage.logging_to(tmp_path / "run.log"):
        raise CaseError("wall.blocks", "has gone", "bring it back", "case.toml")
    (line,) = (tmp_path / "run.log").read_text().splitlines()
    assert "ERROR" in line
    assert line.endswith("stopped by CaseError: case.toml: wall.blocks: has gone; bring it back")


# values


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
    interfaces = {"body_i": np.array([2]), "body_j": np.array([0]), "start": np.array([[2.0, 0]])}
    interfaces |= {"edge_i": np.array([2]), "edge_j": np.array([0])}
    bodies = Bodies(tuple(made), 2, 0.1, **interfaces, end=np.zeros((1, 2)), friction=np.ones(1), joint=np.array([0]))
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


# summary


NAMES, MASS = ("body 1", "body 2"), np.array([1.0, 3.0])


def test_effort_counts_failed_attempts_and_rows_in_motion():
    failed = (Attempt("cycle", 0.1, "halved", 10), Attempt("cycle", 0.05, "halved", 7))
    second = increment(2, attempts=failed, moving=True, energy_error=-0.02)
    third = increment(3, attempts=(Attempt("cycle", 0.1, "moved on", 1),), energy_error=0.01, dissipated_energy=3.0)
    assert storage.effort_of([increment(1), second, third], NAMES, MASS) == storage.Effort(
        steps=3,
        moving_steps=1,
        newton_iterations=27,
        rescues={"halved": 2, "moved on": 1},
        energy_error=0.02 / 4.0,
        events=(),
    )


def test_an_energy_error_that_is_not_a_number_stays_one():
    path = [increment(1), increment(2, energy_error=nan), increment(3, energy_error=0.1)]
    assert np.isnan(storage.effort_of(path, NAMES, MASS).energy_error)


def test_a_local_failure_has_the_multiplier_of_the_last_static_state_before():
    first = np.array([True, False])
    path = [
        increment(1, load_multiplier=0.2, base_shear=2.0),
        increment(2, load_multiplier=0.3, base_shear=9.0, moving=True),
        increment(3, load_multiplier=0.3, base_shear=9.0, moving=True, fallen=first),
        increment(4, load_multiplier=0.4, base_shear=4.0, fallen=first),
    ]
    event = storage.Event(("body 1",), 0.25, 0.2, 2.0, 3)
    assert storage.effort_of(path, NAMES, MASS).events == (event,)


def keys(record):
    """All keys with their nesting, lists of records included."""
    if isinstance(record, dict):
        return {key: keys(value) for key, value in record.items()}
    return [keys(record[0])] if isinstance(record, list) and record and isinstance(record[0], dict) else None


def test_summary_has_exactly_the_promised_keys(tmp_path, assemblage, analysis, partition):
    meshes = BodyMeshes(
        np.zeros((16, 3)), np.zeros((10, 4), int), np.zeros(16, int), np.zeros(10, int), np.zeros((4, 3), int),
        np.zeros(4, int), np.zeros(4, int), np.full(2, 25e3), 1, 0.1,
    )  # fmt: skip
    capacity = Capacity(900.0, 0.288, 0.01, 0.02, 5e6, 1e-5, True)
    seconds = {"mesh": 1, "assembly": 2, "factorise": 3, "contact": 4, "total": 11}
    entry = storage.pushover_summary(
        "macro",
        meshes,
        6,
        storage.Effort(5, 1, 20, {"halved": 1}, 1e-8, (storage.Event(("body 1",), 0.25, 0.2, 2.0, 3),)),
        capacity,
        "done",
        overlap=(1e-5, 1e-4),
        toe_error=0.0,
        large_displacement=True,
        ranks=2,
        seconds=seconds,
        peak_memory=99,
        complaint=None,
        not_valid_because=None,
    )
    found = storage.summarise("case", assemblage, analysis, partition, [entry])
    record = found.record
    assert keys(json.loads(json.dumps(record))) == {
        "case": None,
        "wall": dict.fromkeys(["blocks", "joints", "weight"]),
        "limit_analysis": dict.fromkeys([
            "associative", "non_associative", "non_associative_range", "iterations", "converged",
            "equilibrium_residual", "base_shear", "seconds", "path", "last_rest", "soft_from", "interval",
            "papers_value", "lowest", "highest", "associative_left",
        ]) | {"local_failures": [dict.fromkeys(["stones", "share", "multipliers"])]},
        "macroblocks": dict.fromkeys(["count", "joints", "tol_n", "tol_d", "trivial"]),
        "pushover": [{
            **dict.fromkeys([
                "model", "bodies", "nodes", "tetrahedra", "contacts", "displacements",
                "ranks", "steps", "moving_steps", "newton_iterations",
                "peak_base_shear", "peak_multiplier", "displacement_at_peak", "final_displacement",
                "initial_stiffness", "equilibrium_residual", "max_penetration", "max_penetration_over_size",
                "toe_error",
                "energy_error", "peak_reached",
                "peak_memory", "stopped_because", "complaint", "valid", "not_valid_because",
            ]),
            "rescues": {"halved": None},
            "events": [dict.fromkeys(["bodies", "mass_share", "load_multiplier", "base_shear", "increment"])],
            "seconds": dict.fromkeys(["mesh", "assembly", "factorise", "contact", "total"]),
        }],
    }  # fmt: skip
    assert record["wall"] == {"blocks": 3, "joints": 5, "weight": 3125.0}
    assert record["macroblocks"] == {"count": 2, "joints": 4, "tol_n": 1e-3, "tol_d": 0.45, "trivial": False}
    assert record["limit_analysis"]["non_associative"] == 0.29
    assert record["limit_analysis"]["non_associative_range"] == (0.29, 0.31)
    assert record["limit_analysis"]["iterations"] == 7
    assert record["limit_analysis"]["base_shear"] == pytest.approx(906.25)
    assert (entry.bodies, entry.nodes, entry.tetrahedra, entry.contacts) == (2, 16, 10, 6)
    assert (entry.steps, entry.newton_iterations, entry.peak_base_shear) == (5, 20, 900.0)
    storage.write_summary(tmp_path, found)
    assert json.loads((tmp_path / "summary.json").read_text()) == json.loads(json.dumps(record))
    assert storage.read_summary(tmp_path) == found


def test_summary_says_null_where_nothing_was_found(assemblage, analysis):
    found = storage.summarise("c", assemblage, replace(analysis, sequence=None, path=None, highest=None), None, [])
    assert found.limit_analysis.non_associative is None
    assert found.limit_analysis.non_associative_range is None
    assert found.limit_analysis.multiplier == found.limit_analysis.associative
    assert found.limit_analysis.base_shear == pytest.approx(0.35 * 3125)
    assert found.macroblocks is None


def test_one_body_is_called_trivial(assemblage, analysis):
    one = Partition(np.array([1, 0, 0, 0]), 1, np.array([2, 3, 4]), np.array([], int), None)
    record = storage.summarise("c", assemblage, analysis, one, []).record["macroblocks"]
    assert record == {"count": 1, "joints": 2, "tol_n": None, "tol_d": None, "trivial": True}


def test_provenance_tells_command_versions_and_hashes_but_no_secrets(tmp_path, monkeypatch):
    file = tmp_path / "case.toml"
    file.write_text("name = 'x'")
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    monkeypatch.setenv("MY_PASSWORD", "swordfish")
    told = "\n".join(storage.provenance([file]))
    command = ["python", "-m", "orchestrator", "run", "my wall.toml"]
    monkeypatch.setattr(sys, "orig_argv", command)
    assert storage.provenance([file])[0] == "command: python -m orchestrator run 'my wall.toml'"
    assert "OMP_NUM_THREADS=1" in told
    assert f"numpy {np.__version__}" in told
    digest = hashlib.sha256(b"name = 'x'").hexdigest()  # of the text above
    assert f"sha256 of {file}: {digest}" in told
    assert "swordfish" not in told

"""The summary of a run: exactly its keys, effort and local failures from increments, null where nothing was found."""

from __future__ import annotations

import json
from dataclasses import replace
from math import nan

import numpy as np
import pytest

from orchestrator import storage
from orchestrator.macroblocks.criteria import Partition
from orchestrator.pushover.increments import Attempt, Increment
from tests.support.pushed import PUSHED


def increment(number, **changed):
    made = Increment(
        number=number, phase="load", time=0.1 * number, load_multiplier=0.1, displacement=np.zeros((4, 3)),
        change=np.zeros((4, 3)), normal_force=np.ones(2), elastic_slip=np.zeros((2, 2)), slip=np.zeros(2),
        damage=np.zeros(2), closing=np.zeros(2), tie_force=np.zeros(0), tie_rest=np.zeros(0),
        gap=np.zeros(2), overlap=np.zeros(2), status=np.array([1, 2]), base_shear=1.0,
        horizontal_load=10.0, control_displacement=0.0, under_gravity=0.0, mean_displacement=0.0,
        internal_energy=1.0, dissipated_energy=0.0, external_work=0.0, other_work=0.0, live_work=0.0,
        lost_in_motion=0.0,
        energy_error=0.0, largest_base_shear=0.0, out_of_balance=0.0, moving=False,
        driven=np.ones(2, bool), fallen=np.zeros(2, bool), gone=np.zeros(2), equilibrium_residual=0.0,
        iterations=3, step=(0.1, 0.2),
    )  # fmt: skip
    return replace(made, **changed)


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
    entry = replace(PUSHED, rescues={"halved": 1}, events=(storage.Event(("body 1",), 0.25, 0.2, 2.0, 3),))
    found = storage.summarise("case", assemblage, analysis, partition, [entry])
    record = found.record
    assert keys(json.loads(json.dumps(record))) == {
        "case": None,
        "wall": dict.fromkeys(["blocks", "joints", "weight", "vertical_load", "horizontal_load", "bonded"]),
        "limit_analysis": dict.fromkeys([
            "associative", "non_associative", "non_associative_range", "going_down", "iterations", "converged",
            "equilibrium_residual", "base_shear", "seconds", "path", "last_rest", "soft_from", "interval",
            "large_displacements", "rigid_peak", "pressed_peak",
            "is_bound", "meets_in_points", "papers_value", "lowest", "highest", "associative_left", "base_shear_left",
        ]) | {"local_failures": [dict.fromkeys(["stones", "share", "multipliers"])]},
        "macroblocks": dict.fromkeys(["count", "joints", "tol_n", "tol_d", "trivial"]),
        "pushover": [{
            **dict.fromkeys([
                "model", "bodies", "nodes", "tetrahedra", "contacts", "displacements",
                "ranks", "steps", "moving_steps", "newton_iterations",
                "peak_base_shear", "peak_multiplier", "displacement_at_peak", "final_displacement",
                "initial_stiffness", "equilibrium_residual", "max_penetration", "max_penetration_over_size",
                "max_pressed_gap", "max_pressed_gap_over_size",
                "toe_error",
                "crack_size",
                "crack_error",
                "crushing", "held", "control_share", "snap", "spike",
                "energy_error", "peak_reached",
                "peak_memory", "stopped_because", "complaint", "valid", "not_valid_because",
            ]),
            "at_peak": dict.fromkeys(["fallen", "bound_left", "drawn_contacts", "increment"]),
            "rescues": {"halved": None},
            "events": [dict.fromkeys([
                "bodies", "dead_load_share", "load_multiplier", "base_shear", "increment", "under_gravity",
            ])],
            "seconds": dict.fromkeys(["mesh", "assembly", "factorise", "contact", "total"]),
        }],
    }  # fmt: skip
    assert record["wall"] == {"blocks": 3, "joints": 5, "bonded": False} | dict.fromkeys(
        ("weight", "vertical_load", "horizontal_load"), 3125.0
    )
    assert record["macroblocks"] == {"count": 2, "joints": 4, "tol_n": 1e-3, "tol_d": 0.45, "trivial": False}
    assert record["limit_analysis"]["non_associative"] == 0.29
    assert record["limit_analysis"]["non_associative_range"] == (0.29, 0.31)
    assert record["limit_analysis"]["iterations"] == 7
    assert record["limit_analysis"]["base_shear"] == pytest.approx(906.25)
    storage.write_summary(tmp_path, found)
    assert json.loads((tmp_path / "summary.json").read_text()) == json.loads(json.dumps(record))
    assert storage.read_summary(str(tmp_path)) == found


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

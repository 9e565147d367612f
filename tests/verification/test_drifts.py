"""Drifts of piers against blocks that rock: the drift is what the control point moves over the height.

A block 0.5 m wide and 1 m high that rocks is one pier, H_0 = 1 m: EN 1998-3 C.4.2.1 gives 0.008 x 1/0.5 = 0.016 at SD,
16 mm. Two such blocks under a lintel are two piers between openings, H_0 = 0.5 m: 0.008 at SD.
"""

from __future__ import annotations

import json
from math import pi, sqrt

import pytest

from orchestrator.app.cli import main
from tests.verification.test_seismic_runs import SEISMIC, run

pytestmark = pytest.mark.usefixtures("without_pictures")


@pytest.fixture(scope="module")
def block(tmp_path_factory):
    return run(tmp_path_factory.mktemp("drift"), 200.0, SEISMIC)["seismic"]


def drift_of(record):
    return next(row for row in record["checks"] if row["approach"].startswith("drift"))


def test_a_rocking_block_may_lean_by_the_clause_and_no_further(block):
    row, (system,) = drift_of(block), block["systems"]
    assert row["capacity"] == pytest.approx(0.016, rel=1e-12)
    assert row["unit"] == "drift"
    assert "flexure" in row["remarks"][0]
    n2 = block["checks"][0]
    assert row["demand"] == pytest.approx(n2["demand"] * system["gamma"] / 1.0, rel=0.02), "u_top / h, u at the top"


def ground_acceleration(system, moved):
    """N2 backwards, the control point moved by `moved` m: d_t* = d_y* (1 + (q* - 1) T_C/T*), type 1, ground B."""
    yields, mass = system["yield_displacement_m"], system["equivalent_mass_kg"]
    period = 2 * pi * sqrt(mass * yields / system["yield_force_N"])
    assert period < 0.5
    force_ratio = 1 + (moved / system["gamma"] / yields - 1) * period / 0.5
    rises = 1 + min(period / 0.15, 1.0) * 1.5
    return force_ratio * system["yield_force_N"] / mass / (1.2 * rises)


def test_the_ground_acceleration_that_just_passes_is_that_of_n2_at_this_displacement(block):
    found = drift_of(block)["capacity_ag_m_per_s2"]
    assert found == pytest.approx(ground_acceleration(block["systems"][0], 0.016), rel=1e-2), "u_top / h"


def portal(folder):
    """Two piers of 0.5 m x 1 m on the ground, 1 m apart, under a lintel."""
    ground = {"id": 0, "polygon": [[-1, -1], [3, -1], [3, 0], [-1, 0]], "fixed": True}
    piers = [{"id": n, "polygon": [[x, 0], [x + 0.5, 0], [x + 0.5, 1], [x, 1]]} for n, x in ((1, 0.0), (2, 1.5))]
    lintel = {"id": 3, "polygon": [[0, 1], [2, 1], [2, 1.3], [0, 1.3]]}
    record = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 1.0, "friction": 2.0, "unit_weight": 200.0}
    (folder / "portal.json").write_text(json.dumps(record | {"blocks": [ground, *piers, lintel]}), encoding="utf-8")
    text = (
        f"[wall]\nblocks = 'portal.json'\n[mesh]\nsize = '250 mm'\n[stepping]\nfinal_displacement = '60 mm'\n{SEISMIC}"
    )
    (folder / "case.toml").write_text(text + "control_level = '1.3 m'\n", encoding="utf-8")
    assert main(["run", str(folder / "case.toml"), "--model", "micro", "--output", str(folder / "out"), "-q"]) == 0
    return json.loads((folder / "out" / "summary.json").read_text(encoding="utf-8"))["seismic"]


def test_piers_beside_an_opening_drift_by_what_the_lintel_moves(tmp_path):
    record = portal(tmp_path)
    row, (system,) = drift_of(record), record["systems"]
    assert row["capacity"] == pytest.approx(0.008 * 0.5 / 0.5)
    assert row["remarks"][0].startswith("pier 1.")
    assert "1 m high, 0.5 m wide" in row["remarks"][0]
    moves = ground_acceleration(system, 0.008)
    assert row["capacity_ag_m_per_s2"] == pytest.approx(moves, rel=0.02), "the lintel moves with their tops"

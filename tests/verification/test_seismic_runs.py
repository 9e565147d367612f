"""Seismic verification of whole runs: floors count as stones do, and what may not be verified is refused in words."""

from __future__ import annotations

import json
from math import inf

import pytest

from orchestrator.app.cli import main
from orchestrator.present.report import rebuild

pytestmark = pytest.mark.usefixtures("without_pictures")

SEISMIC = "[seismic]\npeak_ground_acceleration = '0.15 g'\nground = 'B'\n"
FLOOR = "[[load.dead]]\nblocks = [1]\nforce = '90 kN'\ninertia = true\n"


def run(folder, unit_weight, more, stepping="final_displacement = '100 mm'", status=0):
    """Run a block of 0.5 m x 1 m x 1 m on rough ground and return its summary."""
    folder.mkdir(exist_ok=True)
    ground = {"id": 0, "polygon": [[-2, -1], [3, -1], [3, 0], [-2, 0]], "fixed": True}
    block = {"id": 1, "polygon": [[0, 0], [0.5, 0], [0.5, 1], [0, 1]]}
    record = {"name": "block", "units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 1.0, "friction": 2.0}
    text = json.dumps(record | {"unit_weight": unit_weight, "blocks": [ground, block]})
    (folder / "block.json").write_text(text, encoding="utf-8")
    case = f"[wall]\nblocks = 'block.json'\n[mesh]\nsize = '250 mm'\n[stepping]\n{stepping}\n{more}"
    (folder / "case.toml").write_text(case, encoding="utf-8")
    arguments = ["run", str(folder / "case.toml"), "--model", "micro", "--output", str(folder / "out"), "--quiet"]
    assert main(arguments) == status
    return json.loads((folder / "out" / "summary.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """H1: 100 kN of stone; 10 kN of stone with 90 kN of floor at the same height."""
    folder = tmp_path_factory.mktemp("pair")
    return run(folder / "heavy", 200.0, SEISMIC), run(folder / "light", 20.0, FLOOR + SEISMIC), folder


def test_a_floor_is_in_m_star_gamma_and_period(pair):
    """Demand was 12 times, capacity 4 times on the unsafe side. 5 % is left at four elements over the height, 3 % at
    ten: the floor's mass sits on the nodes."""
    heavy, light, _ = (summary["seismic"] if isinstance(summary, dict) else summary for summary in pair)
    (one,), (other,) = heavy["systems"], light["systems"]
    assert one["whole_mass_kg"] == pytest.approx(100e3 / 9.81)
    assert other["whole_mass_kg"] == pytest.approx(100e3 / 9.81)
    for key, tolerance in (("gamma", 0.03), ("equivalent_mass_kg", 0.03), ("yield_force_N", 0.03)):
        assert other[key] == pytest.approx(one[key], rel=tolerance), key
    for first, second in zip(heavy["checks"], light["checks"], strict=True):
        assert second["demand"] == pytest.approx(first["demand"], rel=0.06)
        assert second["safety_ratio"] == pytest.approx(first["safety_ratio"], rel=0.01)


def test_a_ratio_of_a_rocking_block_is_not_bare(pair):
    """H5: ductility and ratio far above 10 carry their remarks, and the least ratio is the mechanism's."""
    n2, linear, rocks, _ = pair[0]["seismic"]["checks"]
    assert n2["safety_ratio"] > 10
    assert any("ductility above 10" in text for text in n2["remarks"])
    assert any("does not govern" in text for text in n2["remarks"])
    assert linear["safety_ratio"] == pytest.approx(4.115, abs=1e-3)
    assert rocks["safety_ratio"] == pytest.approx(1.804, abs=1e-3)


def test_the_limits_of_the_code_apply_by_default(pair, tmp_path):
    """H5: q* <= 3 at SLV and 4 at SLC, each with its own demand; the statement where they govern."""
    ntc = "spectrum = 'ntc2018'\nground = 'B'\nreference_period = '0.3 s'\npeak_ground_acceleration = '0.15 g'\n"
    more = "[[seismic.limit_states]]\nname = 'SLC'\npeak_ground_acceleration = '0.2 g'\n"
    slv, slc = run(tmp_path / "ntc", 200.0, f"[seismic]\n{ntc}{more}")["seismic"]["checks"][:2]
    assert [row["limit_state"] for row in (slv, slc)] == ["SLV", "SLC"]
    assert (slv["ag_m_per_s2"], slc["ag_m_per_s2"]) == pytest.approx((1.4715, 1.962))
    for row, largest in ((slv, 3.0), (slc, 4.0)):
        assert row["largest_force_ratio"] == largest
        assert f"q* ≤ {largest:g} governs the capacity: the curve goes further" in row["remarks"]
        assert row["safety_ratio"] < 20 < pair[0]["seismic"]["checks"][0]["safety_ratio"] < inf


def test_a_curve_cut_off_on_its_way_up_is_refused(tmp_path):
    """C2: the peak was not reached; nothing is verified by it, in table, report and summary."""
    summary = run(tmp_path / "short", 20.0, SEISMIC, "final_displacement = '0.02 mm'")
    (pushover,), record = summary["pushover"], summary["seismic"]
    assert pushover["peak_reached"] is False
    refused = [row for row in record["checks"] if "refused" in row]
    assert [row["approach"] for row in refused] == ["N2, micro-FE", "drift, micro-FE"]
    assert "ends before its peak (the wall carries at least" in refused[0]["refused"]
    assert record["systems"] == []
    page = (tmp_path / "short" / "out" / "report.html").read_text(encoding="utf-8")
    assert "not verified: the curve ends before its peak" in page


def test_a_curve_that_is_not_valid_is_refused(pair):
    """H6: a stored run whose curve failed a check is verified again, and refused."""
    folder = pair[2] / "light" / "out"
    path = folder / "summary.json"
    kept = path.read_text(encoding="utf-8")
    summary = json.loads(kept)
    summary["pushover"][0] |= {"valid": False, "not_valid_because": "energy balance: 9.00e-02"}
    path.write_text(json.dumps(summary), encoding="utf-8")
    rebuild(folder)
    row = json.loads(path.read_text(encoding="utf-8"))["seismic"]["checks"][0]
    assert row["refused"] == "the curve is not valid: energy balance: 9.00e-02"
    assert "safety_ratio" not in row
    path.write_text(kept, encoding="utf-8")
    rebuild(folder)
    assert json.loads(path.read_text(encoding="utf-8"))["seismic"] == json.loads(kept)["seismic"]


def test_masses_do_not_depend_on_the_live_load_and_a_soft_contact_law_is_named(pair, tmp_path):
    """H2: a force on the block instead of its weight: the same masses, alpha_0 = 0.5. T* is of 0.2 mm of tolerance."""
    load = "[load]\ndistribution = 'per_block'\nlive = [{blocks = [1], force = '100 kN'}]\n"
    record = run(tmp_path / "soft", 200.0, f"[contact]\nslip_tolerance = '0.2 mm'\n{load}{SEISMIC}")["seismic"]
    (system,), (stiff,) = record["systems"], pair[0]["seismic"]["systems"]
    assert system["whole_mass_kg"] == pytest.approx(stiff["whole_mass_kg"])
    assert record["kinematic"]["alpha0"] == pytest.approx(0.5)
    assert stiff["slip_tolerance_share"] < 0.01 < 0.1 < system["slip_tolerance_share"]
    assert any("is the slip tolerance of the contact law: T*" in text for text in record["checks"][0]["remarks"])

"""`report` verifies again from the folder, and comes to what `run` came to: a run knows more of the peak than a curve.

A stone of 0.7 m slides under a load that then no more than holds it, 41 mm from a taller one: it goes farther than the
curve does, and what it slid at is its peak, although the base shear falls nowhere.
"""

from __future__ import annotations

import json

import pytest

from orchestrator.app.cli import main

pytestmark = pytest.mark.usefixtures("without_pictures")


def test_a_peak_that_a_motion_ends_is_one_for_report_too(tmp_path):
    boxes = [(-1, -0.2, 3, 0.0), (0, 0, 0.7, 0.5), (0.741, 0, 1.341, 1.2)]
    blocks = [
        {"id": k, "polygon": [[a, b], [c, b], [c, d], [a, d]], "fixed": k == 0}
        | ({"material": "slides"} if k == 1 else {})
        for k, (a, b, c, d) in enumerate(boxes)
    ]
    record = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.3, "unit_weight": 20, "friction": 0.9}
    (tmp_path / "wall.json").write_text(json.dumps(record | {"blocks": blocks}))
    case, out = tmp_path / "case.toml", tmp_path / "out"
    case.write_text(
        "[wall]\nblocks = 'wall.json'\n[[wall.classes]]\nmaterial = 'slides'\nfriction = 0.3\n"
        "[run]\nmodels = ['micro']\n[stepping]\nfinal_displacement = '40 mm'\n"
        "[seismic]\npeak_ground_acceleration = '0.1 g'\ncontrol_blocks = [1]\n"
    )
    main(["run", str(case), "--output", str(out), "-q"])
    before = json.loads((out / "summary.json").read_text())
    assert before["pushover"][0]["peak_reached"]
    main(["report", str(out)])
    after = json.loads((out / "summary.json").read_text())
    assert after["seismic"] == before["seismic"]
    assert any(check.get("demand") for check in after["seismic"]["checks"] if check["approach"].startswith("N2"))

"""A wall whose top goes against its live load: a stone on the overhang of its head, pushed down at 75 degrees, turns it
about its foot, and the horizontal part of the load points the other way.

Its base shear is what it bears. Its displacements are below zero, and say nothing of its stiffness.
"""

from __future__ import annotations

import csv
import json
import re
from math import cos, radians, sin

import numpy as np
import pytest
from PIL import Image

from orchestrator import storage
from orchestrator.app.cli import main
from orchestrator.assessment.seismic.seismic_verification import INCLINED
from orchestrator.present.phrases import phrases
from orchestrator.present.plots.canvas import BLUE
from tests.support.undrawn import undrawn

REMARK = (
    "micro FE: at first the mean of the top edge moves against the live load: base shear over that displacement is no "
    "stiffness of the wall, and none is given"
)
OUTSIDE_OF = "it is outside the mechanism; displacements and stiffness of this curve are not of what fails"
AGAINST = "the control displacement does not go along the live load"
WALL = {
    "units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.5, "unit_weight": 20.0, "friction": 0.6,
    "blocks": [
        {"id": 0, "polygon": [[-2, -0.2], [3, -0.2], [3, 0], [-2, 0]], "fixed": True},
        {"id": 1, "polygon": [[0, 0], [0.8, 0], [0.8, 2.0], [-1.2, 2.0], [-1.2, 1.7], [0, 1.7]]},
        {"id": 2, "polygon": [[-1.2, 2.0], [-0.8, 2.0], [-0.8, 2.2], [-1.2, 2.2]]},
    ],
}  # fmt: skip
"""a pier of 16 kN, 0.4 m inside the end of its foot; a head of 3.6 kN, 0.6 m outside; on that 0.8 kN, 1 m outside"""
CASE = """
[wall]
blocks = "wall.json"
[load]
inclination = "-75 deg"
distribution = "per_block"
live = [{blocks = [2], force = "1 kN"}]
[seismic]
peak_ground_acceleration = "0.1 g"
control_blocks = [2]
[mesh]
toe_offset = 0.5
[run]
models = ["micro"]
"""
"""elements of one size: the pier turns about the very end of its foot"""
BOTH = """
[[load.cases]]
name = "against"
[[load.cases]]
name = "along"
direction = "-x"
inclination = 0
"""
BEARS = (16.0 * 0.4 - 3.6 * 0.6 - 0.8 * 1.0) / (1.0 * sin(radians(75)) - 2.1 * cos(radians(75))) * cos(radians(75))
"""kN of base shear at which it turns over the end of its foot"""


@pytest.fixture
def case(tmp_path):
    (tmp_path / "wall.json").write_text(json.dumps(WALL), encoding="utf-8")
    (tmp_path / "case.toml").write_text(CASE, encoding="utf-8")
    return tmp_path / "case.toml"


def test_the_base_shear_counts_and_no_stiffness_is_given(case, tmp_path, capsys):
    """The same in summary, terminal and page, in every language; the curve is seen in its picture."""
    assert main(["run", str(case), "--output", str(tmp_path / "out")]) == 0
    (found,) = storage.read_summary(tmp_path / "out").pushover
    assert (found.valid, found.peak_reached, found.initial_stiffness) == (True, True, None)
    assert found.peak_base_shear == pytest.approx(1e3 * BEARS, rel=0.01)
    assert found.displacement_at_peak < 0.0
    printed = capsys.readouterr().out
    assert re.search(r"micro-FE +2 +8\.\d+ +2\.\d+ -0\.\d+ +–", printed)
    for said in (REMARK, INCLINED, f"{1e-3 * found.peak_base_shear:.3f} kN counts"):
        assert said in printed
    picture = np.array(Image.open(tmp_path / "out" / "figures" / "curves.png").convert("RGB"))
    blue = [int(BLUE[k : k + 2], 16) for k in (1, 3, 5)]
    drawn = np.flatnonzero((picture[: 4 * len(picture) // 5] == blue).all(axis=2).any(axis=0))
    assert np.ptp(drawn) > 0.8 * picture.shape[1], "from the right end of the axes to the left one"
    assert not (tmp_path / "out" / "figures" / "bilinear.png").exists()
    for language in ("en", "it", "pt"):
        for path in (tmp_path / "out" / "case.toml", tmp_path / "out" / "summary.json"):
            text = re.sub(r'(language"?( =|:) )"\w\w"', rf'\1"{language}"', path.read_text(encoding="utf-8"))
            path.write_text(text, encoding="utf-8")
        storage.write_summary(tmp_path / "out", storage.read_summary(tmp_path / "out"))  # as a run in it had written it
        with undrawn():
            assert main(["report", str(tmp_path / "out")]) == 0
        page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8").replace("&#39;", "'")
        for said in (REMARK, f"none: {AGAINST}", INCLINED):
            assert phrases(language)(said) in page
        assert re.search(r'initial_stiffness"[^>]*>–<', page)


def test_its_curve_ends_at_the_final_displacement(case, tmp_path):
    settings = ["--set", "stepping.final_displacement=0.5mm", "--output", str(tmp_path / "out")]
    with undrawn():
        assert main(["run", str(case), *settings]) == 0
    (found,) = storage.read_summary(tmp_path / "out").pushover
    assert found.stopped_because == "final displacement of 0.5 mm reached"
    with (tmp_path / "out" / "micro" / "curve.csv").open(encoding="utf-8") as file:
        gravity, *_, last = csv.DictReader(file)
    since_gravity = float(last["control_displacement_m"]) - float(gravity["control_displacement_m"])
    assert since_gravity == pytest.approx(-5e-4, rel=5e-3)


def test_beside_a_load_case_along_its_load(case, tmp_path, capsys):
    """Table, page and picture have no stiffness of the one, and that of the other."""
    case.write_text(CASE + BOTH, encoding="utf-8")
    with undrawn():
        assert main(["run", str(case), "--output", str(tmp_path / "out")]) == 0
    with (tmp_path / "out" / "load_cases.csv").open(encoding="utf-8") as file:
        stiffness = {row["load_case"]: row["initial_stiffness_N_per_m"] for row in csv.DictReader(file)}
    assert stiffness["against"] == ""
    assert float(stiffness["along"]) > 0.0
    printed = capsys.readouterr().out
    assert re.search(r"against +micro FE .* -0\.\d+ +– *\n", printed)
    assert re.search(rf"along +micro FE .* +{1e-6 * float(stiffness['along']):#.4g} *\n", printed)
    assert "<td>–</td>" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_a_top_that_stays_where_another_part_fails_is_told(case, tmp_path, capsys):
    """A low pier of two stones, 13 % of the weight, turns over beside a high one; the other way round nothing is said.

    The low pier turns at b / h = 0.6 / 2 = 0.3 of its weight, as the live load is proportional to mass.
    """
    squat, slender = [[0, 0], [2, 0], [2, 4], [0, 4]], [[3, 0], [3.6, 0], [3.6, 2], [3, 2]]
    for height, is_told in ((2.0, True), (6.0, False)):
        slender[2][1] = slender[3][1] = height
        ground = [[-1, -0.3], [6, -0.3], [6, 0], [-1, 0]]
        blocks = [{"id": k, "polygon": polygon} for k, polygon in enumerate((ground, squat, slender))]
        blocks[0]["fixed"] = True
        (tmp_path / "wall.json").write_text(json.dumps(WALL | {"blocks": blocks}), encoding="utf-8")
        case.write_text(
            '[wall]\nblocks = "wall.json"\n[mesh]\ntoe_offset = 0.5\n[run]\nmodels = ["micro"]\n', encoding="utf-8"
        )
        out = tmp_path / f"{height}"
        with undrawn():
            assert main(["run", str(case), "--output", str(out)]) == 0
        (found,) = storage.read_summary(out).pushover
        assert found.peak_multiplier == pytest.approx(0.6 / height, rel=0.01)
        assert (OUTSIDE_OF in capsys.readouterr().out) is is_told
        assert (OUTSIDE_OF in (out / "report.html").read_text(encoding="utf-8")) is is_told


def test_what_a_wall_settles_under_its_weight_is_no_motion_of_its_mechanism(case, tmp_path, capsys):
    """A block whose top its weight presses down by 40 mm (20 kPa in the mean, 1 MPa, 2 m) is pushed by 0.01 mm."""
    soft = ["--set", "elastic.elastic_modulus=1 MPa", "--set", "stepping.final_displacement=0.01 mm"]
    blocks = [{"id": 0, "polygon": [[-1, -0.2], [3, -0.2], [3, 0], [-1, 0]], "fixed": True}]
    blocks.append({"id": 1, "polygon": [[0, 0], [2, 0], [2, 2], [0, 2]]})
    (tmp_path / "wall.json").write_text(json.dumps(WALL | {"blocks": blocks}), encoding="utf-8")
    case.write_text(
        '[wall]\nblocks = "wall.json"\n[mesh]\ntoe_offset = 0.5\n[run]\nmodels = ["micro"]\n', encoding="utf-8"
    )
    with undrawn():
        assert main(["run", str(case), *soft, "--output", str(tmp_path / "out")]) in (0, 3)
    (found,) = storage.read_summary(tmp_path / "out").pushover
    assert 0.3 < found.control_share < 2.0
    assert OUTSIDE_OF not in capsys.readouterr().out

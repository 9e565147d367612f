"""Section forces and reactions of walls with ties and anchors balance the loads, the same in `limit` and `segment`."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from orchestrator.app import cli, driver
from orchestrator.loads import loads_on
from orchestrator.masonry.block_properties import block_centroids
from orchestrator.present.page.practice import practice_contents
from orchestrator.settings import case as cases
from orchestrator.storage.files import write_json
from orchestrator.storage.stored_run import read_run
from tests.support.limit_analysis_cases import box

pytestmark = pytest.mark.usefixtures("without_pictures")

TABLES = ("joint_forces.csv", "section_forces.csv", "reactions.csv", "tie_forces.csv")
PIERS = [box(x, 0.7 * course, 0.6, 0.7) for x in (0.0, 2.4) for course in range(3)]
PORTAL = [box(-0.5, -0.2, 4.0, 0.2), *PIERS, box(0.0, 2.1, 3.0, 0.5)]
FLOOR = "\n[load]\ndead = [{blocks = [7], force = '10 kN', at = ['0.4 m', '2.6 m'], inertia = true}]\n"
TIES = {
    "an anchor of the lintel and a tie between the piers": (
        "{blocks=[7], start=[1.5,2.35], end=[-2,2.35], strength=1e3, stiffness=1e7}",
        "{blocks=[3,6], start=[0.3,1.75], end=[2.7,1.75], strength=1e3, stiffness=1e7}",
    ),
    "an upright tie within a pier and an oblique one to the ground": (
        "{blocks=[6,4], start=[2.5,1.75], end=[2.5,0.35], strength=2e3, stiffness=1e7}",
        "{blocks=[0,7], start=[-0.4,-0.1], end=[1.5,2.35], strength=1e3, stiffness=1e7}",
    ),
    "a floor that pushes": ("{blocks=[3], start=[0.0,1.9], end=[-3,2.5], strength=1e3, stiffness=1e7, pushes=true}",),
}


def written(folder, polygons, friction, text):
    """Write blocks, the first a support, and a case; return the case file."""
    blocks = [{"id": number, "polygon": outline, "fixed": not number} for number, outline in enumerate(polygons)]
    record = {"name": "tied", "units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.3, "unit_weight": 20.0}
    write_json(folder / "wall.json", record | {"friction": friction, "blocks": blocks})
    (folder / "case.toml").write_text("[wall]\nblocks = 'wall.json'\n" + text, encoding="utf-8")
    return folder / "case.toml"


def rows(path):
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def numbers(row, *names):
    return np.array([float(row[name]) for name in names])


@pytest.fixture(scope="module", params=TIES.values(), ids=TIES.keys())
def portal(request, tmp_path_factory):
    """Folder with what `limit` and `segment` wrote, wall, loads at collapse (n, 3), multiplier x resultant in N."""
    folder = tmp_path_factory.mktemp("portal")
    case = written(folder, PORTAL, 0.6, f"{FLOOR}[reinforcement]\nties = [{', '.join(request.param)}]\n")
    for command in ("limit", "segment"):
        assert cli.main([command, str(case), "--output", str(folder / command)]) == 0
    read = cases.read(case)
    assemblage, analysis = driver.limit(read)
    loads = loads_on(assemblage.wall, read.load)
    return folder, assemblage, loads.dead + analysis.headline.load_multiplier * loads.live


def test_limit_and_segment_write_the_same_tables(portal):
    for name in TABLES:
        one, other = (rows(portal[0] / command / name) for command in ("limit", "segment"))
        assert one == other
        assert one


def test_the_table_of_joints_has_the_joints_of_the_wall(portal):
    folder, assemblage, _ = portal
    found = [(row["block_i"], row["block_j"]) for row in rows(folder / "limit" / "joint_forces.csv")]
    ids = [str(block.id) for block in assemblage.wall.blocks]
    assert found == [(ids[i], ids[j]) for i, j in assemblage.joints.pairs]


def test_supports_and_anchors_balance_all_loads(portal):
    folder, assemblage, loads = portal
    free = [not block.fixed for block in assemblage.wall.blocks]
    arm, scale = block_centroids(assemblage.wall), np.abs(loads).sum()
    turning = loads[free, 2] + arm[free, 0] * loads[free, 1] - arm[free, 1] * loads[free, 0]
    total = np.array([*loads[free, :2].sum(axis=0), turning.sum()])
    for command in ("limit", "segment"):
        found = np.zeros(3)
        for row in rows(folder / command / "reactions.csv"):
            x, y, horizontal, vertical, moment = numbers(row, *list(row)[1:])
            found += [horizontal, vertical, x * vertical - y * horizontal + moment]
        assert found == pytest.approx(-total, abs=1e-5 * scale)


def test_a_support_bears_what_its_joints_carry(portal):
    folder = portal[0]
    on_wall = sum(
        numbers(row, "force_on_j_x_N", "force_on_j_y_N") * ((row["block_i"] == "0") - 1.0 * (row["block_j"] == "0"))
        for row in rows(folder / "limit" / "joint_forces.csv")
    )
    (support,) = (row for row in rows(folder / "limit" / "reactions.csv") if row["support"] == "0")
    assert numbers(support, "horizontal_N", "vertical_N") == pytest.approx(on_wall)
    assert numbers(support, "x_m", "y_m") == pytest.approx([1.5, 0.0], abs=1e-12)


@pytest.mark.parametrize("section", ["foot", "middle", "head"])
def test_piers_and_ties_across_a_section_carry_all_that_is_above(portal, section):
    folder, assemblage, loads = portal
    own = [row for row in rows(folder / "limit" / "section_forces.csv") if row["section"] == section]
    own = [row for row in own if "spandrel" not in row["panel"]]
    piers = [row for row in own if row["panel"].startswith("pier")]
    assert len(piers) == 2
    at, scale = float(piers[0]["y_m"]), np.abs(loads).sum()
    centre = block_centroids(assemblage.wall)
    free = np.array([not block.fixed for block in assemblage.wall.blocks])
    above = free * 0.5 * (np.sign((centre[:, 1] - at).round(6)) + 1.0)  # half of a stone on the line
    x, y = above @ loads[:, :2]
    turning = above * (loads[:, 2] + centre[:, 0] * loads[:, 1] - centre[:, 1] * loads[:, 0])
    found = np.zeros(3)
    for row in own:
        px, py, normal, shear, moment = numbers(row, "x_m", "y_m", "N_N", "V_N", "M_Nm")
        found += [normal, shear, moment - px * normal - py * shear]
    assert found == pytest.approx([-y, x, turning.sum()], abs=1e-5 * scale), "the moment about (0, 0)"


@pytest.mark.parametrize(("pier", "block"), [("pier 1.1", "1"), ("pier 1.2", "4")])
def test_the_foot_of_a_pier_carries_what_its_joint_does(portal, pier, block):
    table = rows(portal[0] / "limit" / "section_forces.csv")
    (foot,) = (row for row in table if (row["panel"], row["section"]) == (pier, "foot"))
    joints = rows(portal[0] / "limit" / "joint_forces.csv")
    (joint,) = (row for row in joints if {row["block_i"], row["block_j"]} == {"0", block})
    on_ground = -1.0 if joint["block_j"] == block else 1.0
    x, y = on_ground * numbers(joint, "force_on_j_x_N", "force_on_j_y_N")
    assert numbers(foot, "N_N", "V_N") == pytest.approx([-y, x])


def test_spandrel_and_ties_across_it_balance_what_is_on_its_right(portal):
    """Right of the middle stands the second pier, blocks 4 to 6: what the ground does to it is in joint 0-4. The lintel
    is half there, and so is what an anchor of it bears."""
    folder, _, loads = portal
    own = [row for row in rows(folder / "limit" / "section_forces.csv") if "spandrel" in row["panel"]]
    foot = [
        row for row in rows(folder / "limit" / "joint_forces.csv") if {row["block_i"], row["block_j"]} == {"0", "4"}
    ]
    assert len(foot) == 1
    sign = 1.0 if foot[0]["block_j"] == "4" else -1.0
    ends = {row["tie"]: {row["block"], row["other_block"]} for row in rows(folder / "limit" / "tie_forces.csv")}
    anchored = [tie for tie, blocks in ends.items() if "7" in blocks and blocks & {"", "0"}]
    held = [row for row in rows(folder / "limit" / "reactions.csv") if row["support"].removeprefix("tie ") in anchored]
    lintel = loads[7, :2] + sum(numbers(row, "horizontal_N", "vertical_N") for row in held)
    on_pier = sign * numbers(foot[0], "force_on_j_x_N", "force_on_j_y_N")
    x, y = loads[4:7, :2].sum(axis=0) + on_pier + 0.5 * lintel
    found = sum(numbers(row, "N_N", "V_N") for row in own)
    assert found == pytest.approx([-x, y], abs=1e-6 * np.abs(loads).sum())


def test_an_anchored_block_by_hand(tmp_path):
    """W = 3 kN, 0.5 m x 1 m, an anchor of T = 1 kN at half its height: lambda = (W b/2 + T z) / (W h/2) = 5/6. The
    support bears W at the toe, and along it lambda W - T = 1.5 kN; the anchor T, where it is anchored."""
    tie = "{blocks=[1], start=[0.25,0.5], end=[-2,0.5], strength=1e3}"
    case = written(tmp_path, [box(-1, -0.2, 3, 0.2), box(0, 0, 0.5, 1)], 0.9, f"[reinforcement]\nties = [{tie}]\n")
    assert cli.main(["limit", str(case), "--output", str(tmp_path / "limit")]) == 0
    support, anchor = rows(tmp_path / "limit" / "reactions.csv")
    assert (support["support"], anchor["support"]) == ("0", "tie 1")
    assert numbers(support, *list(support)[1:]) == pytest.approx([0.25, 0.0, -1500, 3000, 750], rel=1e-5, abs=1e-9)
    assert numbers(anchor, *list(anchor)[1:]) == pytest.approx([-2.0, 0.5, -1000, 0, 0], rel=1e-5, abs=1e-6)
    (tie_row,) = rows(tmp_path / "limit" / "tie_forces.csv")
    assert (tie_row["tie"], tie_row["block"], tie_row["other_block"]) == ("1", "1", "")
    assert float(tie_row["pull_N"]) == pytest.approx(1e3, rel=1e-5)


def test_a_later_analysis_without_ties_leaves_no_forces_of_ties(tmp_path):
    tie = "{blocks=[1], start=[0.25,0.5], end=[-2,0.5], strength=1e3}"
    case = written(tmp_path, [box(-1, -0.2, 3, 0.2), box(0, 0, 0.5, 1)], 0.9, f"[reinforcement]\nties = [{tie}]\n")
    assert cli.main(["limit", str(case), "--output", str(tmp_path / "limit")]) == 0
    without = [str(case), "--set", "reinforcement.ties=[]", "--output", str(tmp_path / "limit")]
    assert cli.main(["limit", *without]) == 0
    assert not (tmp_path / "limit" / "tie_forces.csv").exists()


def test_the_page_of_a_run_has_the_reactions_of_anchors(tmp_path):
    """The sums are weight and base shear of limit analysis, after the run as after its report is written again; so do
    the finite elements: contacts on the support and the anchor bear what the multiplier says, less the rotation."""
    tie = "{blocks=[1], start=[0.25,0.5], end=[-2,0.5], strength=1e3, stiffness=1e7}"
    text = f"[reinforcement]\nties = [{tie}]\n[run]\nmodels = ['micro']\n[stepping]\nfinal_displacement = '2 mm'\n"
    case = written(tmp_path, [box(-1, -0.2, 3, 0.2), box(0, 0, 0.5, 1)], 0.9, text)
    folder = tmp_path / "run"
    assert cli.main(["run", str(case), "--output", str(folder)]) == 0
    written_first = [(folder / name).read_bytes() for name in TABLES]
    assert cli.main(["report", str(folder)]) == 0
    assert [(folder / name).read_bytes() for name in TABLES] == written_first
    stored = read_run(folder)
    shown = practice_contents(stored)
    assert shown["sums"] == pytest.approx((-2500.0, 3000.0), rel=1e-5)
    assert [row[0] for row in shown["reactions"]] == ["0", "tie 1"]
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "all supports and anchors" in page
    (model,) = stored.models
    assert model.curve.base_shear_N == pytest.approx(3000.0 * model.curve.load_multiplier, abs=2e-3 * 3000.0)
    assert json.loads((folder / "summary.json").read_text())["limit_analysis"]["base_shear"] == pytest.approx(2500.0)

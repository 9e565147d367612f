"""Ties in limit analysis against the statics of blocks that slide or turn about a toe, written out by hand.

A tie pulls with up to its strength T and never pushes. Blocks are b x h, of weight W, and the live load is lambda W.
"""

from __future__ import annotations

import json
from dataclasses import replace
from math import cos, radians, sin, tan

import numpy as np
import pytest

from orchestrator import JointSettings, LimitAnalysisSettings, analyse, find_joints, one_body_per_block, push
from orchestrator.app import cli, driver
from orchestrator.assessment.seismic.seismic_verification import verify
from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis.gravity import associative_optimum, problem_of
from orchestrator.limit_analysis.pretension import refuse_what_pretension_moves
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.masonry.joints import JointClass
from orchestrator.masonry.patterns import Arch, arch_on_piers
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.ties import Tie, with_ties
from orchestrator.settings import case as cases
from tests.support.limit_analysis_cases import analysed, assemblage_of, box
from tests.support.paths import DATA

B, H, Z = 0.5, 2.0, 1.5
W = 20e3 * B * H
FLOOR = box(-5.0, -0.5, 10.0, 0.5)


def multiplier(assemblage, *ties, direction=1):
    """Return the multiplier on which all rules agree (the ties and the toes have no friction to speak of)."""
    found = analysed(with_ties(assemblage, ties), direction)
    assert found.headline.flow_rule == "path", "loading meets it"
    assert found.headline.power_residual < 1e-8
    assert found.headline.load_multiplier == pytest.approx(found.associative.load_multiplier, rel=1e-6)
    return found.headline.load_multiplier


def block(friction=5.0):
    return assemblage_of([FLOOR, box(0.0, 0.0, B, H)], friction=friction)


@pytest.mark.parametrize("T", [0.2 * W, 1e-3 * W])
def test_an_anchor_holds_a_block_back_with_its_strength(T):
    """lambda W h/2 = W b/2 + T z; pushed towards the anchor the tie is slack, lambda = b/h."""
    tie = Tie(blocks=(1,), start=(0.0, Z), end=(-3.0, Z), strength=T)
    assert multiplier(block(), tie) == pytest.approx((W * B / 2 + T * Z) / (W * H / 2), rel=1e-6)
    assert multiplier(block(), tie, direction=-1) == pytest.approx(B / H, rel=1e-6)


def test_pretension_that_overturns_a_block_is_refused_before_there_is_a_live_load():
    """P z > W b/2. `limit` had a multiplier for it; a second tie that pulls the other way holds the block."""
    wall, verge = block(), W * B / 2 / Z

    def asked(*pretensions, pushes=False):
        ties = [
            Tie((1,), (x, Z), (far, Z), W, pretension=pretension, pushes=pushes)
            for pretension, x, far in zip(pretensions, (0.0, B), (-3.0, 3.0), strict=False)
        ]
        refuse_what_pretension_moves(wall, loads_on(wall.wall), ties)

    asked(0.999 * verge)
    asked(2.0 * verge, 1.5 * verge)
    with pytest.raises(CaseError, match=r"reinforcement\.ties: their pretension moves block 1, before"):
        asked(1.001 * verge)
    with pytest.raises(CaseError, match="their pretension moves block 1"):
        asked(1.001 * verge, pushes=True)


@pytest.mark.parametrize("degrees", [-40.0, 25.0])
def test_an_inclined_anchor_has_the_arm_of_its_line(degrees):
    """T pulls to the left at an angle above the horizontal from (0, z): its moment about the toe (b, 0) is
    T (z cos a - b sin a)."""
    a, T = radians(degrees), 0.1 * W
    tie = Tie(blocks=(1,), start=(0.0, Z), end=(-2.0, Z + 2.0 * tan(a)), strength=T)
    turning = (W * B / 2 + T * (Z * cos(a) - B * sin(a))) / (W * H / 2)
    assert multiplier(block(), tie) == pytest.approx(turning, rel=1e-6)


def test_an_anchor_of_a_sliding_block():
    """lambda W = mu W + T, with the tie at the height of the centroid."""
    mu, T = 0.1, 0.05 * W
    tie = Tie(blocks=(1,), start=(0.0, H / 2), end=(-3.0, H / 2), strength=T)
    assert multiplier(block(mu), tie) == pytest.approx(mu + T / W, rel=1e-6)


@pytest.mark.parametrize(("T", "yields"), [(0.02 * W, True), (10 * W, False)])
def test_a_tie_between_two_blocks_makes_one_hold_the_other(T, yields):
    """A slender block 0 and a stocky one, 2 b wide, tied at z and pushed apart from each other's side (-x):

    the slender one turns alone and the tie yields, lambda W h/2 = W b/2 + T z, or both turn, tied at one height,
    lambda (W + 2 W) h/2 = W b/2 + 2 W b.
    """
    wall = assemblage_of([FLOOR, box(0.0, 0.0, B, H), box(2.0, 0.0, 2 * B, H)], friction=5.0)
    tie = Tie(blocks=(1, 2), start=(B, Z), end=(2.0, Z), strength=T)
    alone, together = (W * B / 2 + T * Z) / (W * H / 2), (W * B / 2 + 2 * W * B) / (1.5 * W * H)
    assert (alone < together) is yields
    assert multiplier(wall, tie, direction=-1) == pytest.approx(min(alone, together), rel=1e-5)
    assert multiplier(wall, tie) == pytest.approx(B / H, rel=1e-6), "the slender one comes nearer: the tie is slack"


def test_the_order_of_a_tie_s_ends_does_not_matter():
    one = Tie(blocks=(1, 2), start=(B, Z), end=(2.0, Z), strength=0.02 * W)
    other = Tie(blocks=(2, 1), start=(2.0, Z), end=(B, Z), strength=0.02 * W)
    wall = assemblage_of([FLOOR, box(0.0, 0.0, B, H), box(2.0, 0.0, 2 * B, H)], friction=5.0)
    assert multiplier(wall, one, direction=-1) == pytest.approx(multiplier(wall, other, direction=-1), rel=1e-7)


def test_a_tie_that_does_not_yield_is_as_good_as_any_stronger_one():
    """Whatever multiple of the blocks' weight: its shear, which is none, was an unknown without any room."""
    assemblage = find_joints(
        arch_on_piers(Arch(11, 0.9, 0.2, courses=5, pier_width=0.5, pier_height=1.2)), JointSettings()
    )
    found = []
    for strength in np.geomspace(2e4, 8e6, 40):
        tie = Tie(blocks=(6, 11), start=(-0.8, 1.104), end=(0.8, 1.104), strength=float(strength))
        found.append(associative_optimum(problem_of(with_ties(assemblage, [tie]))).load_multiplier)
    assert found == pytest.approx([found[0]] * len(found), rel=1e-8)


@pytest.mark.parametrize(("T", "direction"), [(0.3 * W, 1), (0.3 * W, -1)])
def test_a_strut_holds_a_block_both_ways(T, direction):
    """lambda W h/2 = W b/2 + T z, pulled or pushed."""
    tie = Tie(blocks=(1,), start=(0.0, Z), end=(-3.0, Z), strength=T, pushes=True)
    expected = (W * B / 2 + T * Z) / (W * H / 2)
    assert multiplier(block(), tie, direction=direction) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("strength", [1e-3, 1.0])
def test_a_tie_that_bears_next_to_nothing_leaves_the_state_that_loading_meets(strength):
    """Five voussoirs, of which friction leaves open what they bear: 0.307 when they are loaded, 0.3626 at most. A wall
    with a tie was not loaded: this one had 0.3626, and a facade of 70 stones 0.395 for 0.378, with a tie of 1 N."""
    assemblage = find_joints(read_blocks(DATA / "arch_5_voussoirs.json"), JointSettings())
    loads, as_drawn = loads_on(assemblage.wall, LoadSettings("-x")), LimitAnalysisSettings(large_displacements=False)
    bare = analyse(assemblage, as_drawn, loads=loads)
    x, y = assemblage.wall.blocks[3].polygon.mean(axis=0)
    tie = Tie(blocks=(assemblage.wall.blocks[3].id,), start=(x, y), end=(x + 3.0, y), strength=strength)
    tied = analyse(with_ties(assemblage, [tie]), as_drawn, loads=loads)
    assert bare.headline.load_multiplier < 0.9 * bare.associative.load_multiplier
    assert tied.headline.flow_rule == bare.headline.flow_rule == "path"
    assert tied.headline.load_multiplier == pytest.approx(bare.headline.load_multiplier, rel=1e-3)


@pytest.mark.parametrize("strength", [1e12, 1e10])
def test_joints_that_hardly_crush_leave_the_state_that_loading_meets(strength):
    """Walls whose joints crush were not loaded: these voussoirs had 0.3626, the bound, for 0.307."""
    drawn = read_blocks(DATA / "arch_5_voussoirs.json")
    loads, as_drawn = loads_on(drawn, LoadSettings("-x")), LimitAnalysisSettings(large_displacements=False)
    bare = analyse(find_joints(drawn, JointSettings()), as_drawn, loads=loads)
    hard = JointSettings(classes=(JointClass(compressive_strength=strength),))
    found = analyse(find_joints(drawn, hard), as_drawn, loads=loads)
    assert found.headline.flow_rule == bare.headline.flow_rule == "path"
    assert found.headline.load_multiplier == pytest.approx(bare.headline.load_multiplier, rel=1e-3)
    assert found.headline.load_multiplier <= bare.headline.load_multiplier * (1.0 + 1e-9)


def test_a_state_of_a_wall_that_is_not_loaded_is_none_beside_its_last_rest():
    """A joint that holds where friction has ended has no path of loading; the paper's sequence is left out too."""
    wall = block(0.1)
    held = replace(wall, joints=replace(wall.joints, tensile_strength=np.full(wall.joints.count, 1e3)))
    found = analyse(held, LimitAnalysisSettings(sequence_blocks=0))
    assert found.headline.name == "collapse state found without loading"
    assert found.headline.load_multiplier == pytest.approx(0.1, rel=1e-6)


@pytest.mark.parametrize(
    ("given", "key"),
    [
        ({"blocks": (7,)}, "blocks"),
        ({"blocks": (1, 1)}, "blocks"),
        ({"blocks": (0,)}, "blocks"),
        ({"blocks": (1, 0, 1)}, "blocks"),
        ({"end": (0.0, Z)}, "end"),
        ({"start": (0.6, Z)}, "start"),
        ({"blocks": (1, 0)}, "end"),
        ({"pretension": 1e3}, "pretension"),
    ],
)
def test_a_tie_that_joins_nothing_is_refused(given, key):
    tie = {"blocks": (1,), "start": (0.0, Z), "end": (-3.0, Z), "strength": 1e3} | given
    with pytest.raises(CaseError) as refused:
        with_ties(block(), [Tie(**tie)])
    assert refused.value.key == f"reinforcement.ties.0.{key}"


@pytest.fixture
def tied(tmp_path):
    outlines = {0: FLOOR, 1: box(0.0, 0.0, B, H)}
    blocks = [{"id": n, "polygon": outline, "fixed": n == 0} for n, outline in outlines.items()]
    record = {"name": "block", "units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 1.0}
    (tmp_path / "wall.json").write_text(json.dumps(record | {"unit_weight": 20.0, "friction": 5.0, "blocks": blocks}))
    (tmp_path / "case.toml").write_text(
        "[wall]\nblocks = 'wall.json'\n[[reinforcement.ties]]\nblocks = [1]\n"
        "start = ['0 m', '1.5 m']\nend = ['-3 m', '1.5 m']\nstrength = '4 kN'\n"
    )
    return tmp_path / "case.toml"


def test_limit_and_check_take_ties(tied, capsys):
    assert cli.main(["limit", str(tied), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["non_associative"]
    assert found == pytest.approx((W * B / 2 + 4e3 * Z) / (W * H / 2), rel=1e-6)
    assert cli.main(["check", str(tied), "--output", str(tied.parent / "look")]) == 0
    assert (tied.parent / "look" / "figures" / "blocks.png").exists()
    printed = capsys.readouterr().out
    assert "tie 1: block 1 to an anchor at (-3, 1.5) m, 3 m long, yields at 4.000 kN" in printed


RIGID = "reinforcement.ties.0.stiffness: is missing: the finite elements know no rigid tie"
UNKNOWN = "walls with ties are not verified, as it is not known at which elongation a tie breaks"
VERIFIED = (
    "reinforcement.ties=[{blocks=[1], start=[0, 1.5], end=[-3, 1.5], strength=4000, stiffness=1e6}]",
    "seismic.peak_ground_acceleration=1.5",
)


@pytest.mark.parametrize(("settings", "said"), [((), RIGID), (VERIFIED, UNKNOWN)])
def test_a_run_with_rigid_ties_or_a_verification_is_refused(tied, tmp_path, monkeypatch, capsys, settings, said):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["run", str(tied), *(word for one in settings for word in ("--set", one))]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("command", ["study", "export"])
def test_what_takes_no_ties_says_so(tied, tmp_path, monkeypatch, capsys, command):
    monkeypatch.chdir(tmp_path)
    assert cli.main([command, str(tied)]) == 2
    assert f"reinforcement.ties: {command} takes no ties yet; " in capsys.readouterr().err


HELD = "reinforcement.ties=[{blocks=[1], start=[0, 1.5], end=[-3, 1.5], strength=4000, stiffness=1e6}]"
SHORT = ("run.models=['macro']", "stepping.final_displacement=1 mm")


def carried_out(command, path, output, *settings):
    words = [word for one in settings for word in ("--set", one)]
    return cli.main([command, str(path), *([] if command == "report" else ["--output", str(output)]), *words])


def contents(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.usefixtures("without_pictures")
@pytest.mark.parametrize("load", [(), ("load.envelope=true",)])
def test_a_report_does_not_verify_a_wall_with_ties(tied, tmp_path, capsys, load):
    """[seismic] may be changed after a run; with load cases each has its own case.toml, and the last is changed."""
    run = tmp_path / "run"
    assert carried_out("run", tied, run, HELD, *SHORT, *load) == 0
    changed = sorted(run.rglob("case.toml"))[-1]
    text = changed.read_text(encoding="utf-8")
    changed.write_text(text.replace("[seismic]\n", "[seismic]\npeak_ground_acceleration = 0.981\n"), encoding="utf-8")
    before = contents(run)
    assert carried_out("report", run, None) == 2
    assert f"{changed}: reinforcement.ties: {UNKNOWN}" in capsys.readouterr().err
    assert contents(run) == before


@pytest.mark.parametrize("analysis", ["limit", "macro"])
def test_sensitivity_does_not_verify_a_wall_with_ties(tied, tmp_path, capsys, analysis):
    given = (HELD, "sensitivity.friction=[0.4, 0.6]", f"sensitivity.analysis={analysis}")
    asked = "seismic.peak_ground_acceleration=0.981"
    assert carried_out("sensitivity", tied, tmp_path / "out", *given, asked) == 2
    assert f"{tied}: reinforcement.ties: {UNKNOWN}" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.usefixtures("without_pictures")
@pytest.mark.parametrize(("settings", "said"), [((), RIGID), (VERIFIED, UNKNOWN)])
def test_load_cases_that_are_refused_leave_an_earlier_run_alone(tied, tmp_path, capsys, settings, said):
    run = tmp_path / "run"
    assert carried_out("run", tied, run, HELD, *SHORT, "load.envelope=true") == 0
    before = contents(run)
    again = [word for one in ("load.envelope=true", *settings) for word in ("--set", one)]
    assert cli.main(["run", str(tied), "--output", str(run), "--force", *again]) == 2
    assert said in capsys.readouterr().err
    assert contents(run) == before


def test_the_verification_itself_takes_no_ties(tied):
    """The last gate: whatever road leads to it, an analysis with forces of ties is not verified."""
    case = cases.read(tied, [HELD])
    assemblage, analysis = driver.limit(case)
    assert analysis.headline.tie_forces == pytest.approx([4e3], rel=1e-6)
    asked = replace(case.seismic, peak_ground_acceleration=0.981)
    with pytest.raises(CaseError, match="walls with ties are not verified"):
        verify(asked, case.load, case.limit_analysis, assemblage, analysis, [])


HUNG = "reinforcement.ties=[{blocks=[1], start=[0.25, 2.0], end=[0.25, 5.0], strength=4000}]"


@pytest.mark.usefixtures("without_pictures")
def test_an_anchor_does_not_go_down_with_a_support(tied, tmp_path, capsys):
    """An anchor above a block bears 4 kN of its weight, 20 kN: the ground that gives way bears the rest. Where there is
    no other ground it is not said what the anchor is fixed to."""
    assert cli.main(["limit", str(tied), "--settle", "0", "--set", HUNG, "--output", str(tmp_path / "one")]) == 2
    assert "reinforcement.ties.0.blocks: no support stays where 0 gives way; add" in capsys.readouterr().err
    record = json.loads((tmp_path / "wall.json").read_text())
    record["blocks"].append({"id": 2, "polygon": box(-9.0, -0.5, 4.0, 0.5), "fixed": True})
    (tmp_path / "wall.json").write_text(json.dumps(record))
    assert cli.main(["limit", str(tied), "--settle", "0", "--set", HUNG, "--output", str(tmp_path / "two")]) == 0
    assert "least reaction 16.0000 kN" in capsys.readouterr().out


def test_finite_elements_from_python_refuse_ties_in_one_line():
    tied = with_ties(block(), [Tie(blocks=(1,), start=(0.0, Z), end=(-3.0, Z), strength=4e3, stiffness=1e7)])
    with pytest.raises(CaseError) as refused:
        push(tied, analyse(tied), one_body_per_block(tied))
    said = str(refused.value)
    assert "\n" not in said
    assert "finite elements with ties: `run`, with [[reinforcement.ties]]" in said

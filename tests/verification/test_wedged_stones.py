"""Stones that nothing but a wedge holds go down under the dead load, and the wall goes on without them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.app import cli
from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.limit_analysis.wedged_stones import stones_in_wedges
from orchestrator.loads import LiveLoad, LoadSettings, loads_on
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from orchestrator.masonry.wall import Block, Wall
from orchestrator.present.answer import answer_of_limit
from orchestrator.storage.values import write_blocks
from tests.support.pushover_chain import rectangle


def towers(side: float, width: float) -> Wall:
    """Two towers 2 m high, of a width and of 1 m, with a square stone between them that rests on nothing."""
    blocks = (
        Block(0, rectangle(-1.0, -0.3, 7.0, 0.3), True, 20e3),
        Block(1, rectangle(0.0, 0.0, width, 2.0), False, 20e3),
        Block(2, rectangle(width + side, 0.0, 1.0, 2.0), False, 20e3),
        Block(3, rectangle(width, 1.0, side, side), False, 20e3),
    )
    return Wall("towers", blocks, 0.3, 0.7)


@pytest.mark.parametrize("loaded", ["all", "towers"])
@pytest.mark.parametrize("side", [0.2, 0.21, 0.25])
def test_a_small_stone_between_towers_falls_and_the_slender_one_overturns_by_itself(side, loaded):
    """b / H = 0.25, the closed form: pushed to the right it leans on nothing. The answer was open, and where the stone
    has no live load it stayed so."""
    assemblage = find_joints(towers(side, 0.5), JointSettings())
    live = tuple(LiveLoad(blocks=(stone,), force=weight) for stone, weight in ((1, 6e3), (2, 12e3)))
    load = LoadSettings(distribution="per_block", live=live) if loaded == "towers" else LoadSettings()
    found = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    assert found.headline.load_multiplier == pytest.approx(0.25, rel=1e-3)
    (failure,) = found.local_failures
    assert failure.stones == (3,)
    assert failure.multipliers == (0.0, 0.0)
    assert failure.share == pytest.approx(side**2 / (3.0 + side**2))
    share = f"{100 * failure.share:.2g} % of the dead load"
    assert f"local failure under the dead load: stone 3 ({share}) comes loose, unless wedged" in found.remarks
    assert failure.state.mechanism.velocities[3] == pytest.approx([0.0, -1.0, 0.0], abs=1e-9), "it goes down"
    assert not found.going_down
    assert f", of what is left when stones of {share} have come loose, " in answer_of_limit(found)


def test_what_only_a_wedge_holds_is_no_state_of_the_kinematic_verification(tmp_path, capsys):
    """It starts to move at 0.25 g, as the slender tower alone; a division by nothing ended the run."""
    (tmp_path / "case.toml").write_text(
        '[wall]\nblocks = "blocks.json"\n[seismic]\npeak_ground_acceleration = "0.1 g"\n'
    )
    write_blocks(tmp_path, towers(0.2, 0.5))
    run = ["run", str(tmp_path / "case.toml"), "--output", str(tmp_path / "run")]
    assert cli.main([*run, "--model", "macro"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "of the wall without the stones that go down under the dead load unless they are wedged" in printed
    assert cli.main(["report", str(tmp_path / "run")]) == 0, "what is stored is read again"


@pytest.mark.parametrize("seed", [3, 4])
def test_states_of_what_is_left_are_those_of_a_wall_drawn_without_what_came_loose(seed):
    """A pinnacle falls at b / H = 0.2: descents began at its slips alone, and the range of the wall was too narrow."""
    wall = irregular_courses(IrregularCourses(1.6, 1.2, widths=(0.2, 0.5), heights=(0.15, 0.25), seed=seed))
    pinnacle = Block(len(wall.blocks), rectangle(0.75, 1.2, 0.06, 0.3), False, wall.blocks[1].unit_weight)
    without = analyse(find_joints(wall, JointSettings()))
    found = analyse(find_joints(replace(wall, blocks=(*wall.blocks, pinnacle)), JointSettings()))
    assert [failure.stones for failure in found.local_failures] == [(pinnacle.id,)]
    assert without.sequence.load_multiplier < 0.98 * without.headline.load_multiplier
    assert found.headline.load_multiplier == pytest.approx(without.headline.load_multiplier, rel=1e-6)
    assert found.non_associative_range == pytest.approx(without.non_associative_range, rel=1e-6)


def test_a_large_stone_between_towers_leaves_open_whether_they_stand():
    """0.8 m x 0.8 m, a tenth of the dead load: that is no local failure."""
    assemblage = find_joints(towers(0.8, 2.0), JointSettings())
    assert stones_in_wedges(assemblage, loads_on(assemblage.wall), LimitAnalysisSettings()) == (3,)
    found = analyse(assemblage)
    assert found.going_down == (3,)
    assert not found.local_failures


def test_what_falls_without_what_has_come_loose_came_loose_with_it():
    """The centroid of a T is 0.5 mm beyond its foot: it leans on a chip, which friction holds on the tower beside it.
    With the chip the T falls, 46 % of the dead load: they were taken away, and the answer was the tower's 0.12 = mu."""
    outline = np.array([(0.0, 0.0), (0.5, 0.0), (0.5, 0.9), (1.1754, 0.9), (1.1754, 2.0), (0.0, 2.0)])
    chip, tower = rectangle(1.1754, 1.0, 0.2, 0.2), rectangle(1.3754, 0.0, 1.0, 2.0)
    shapes = [rectangle(-1.0, -0.3, 7.0, 0.3), outline, tower, chip]
    blocks = [Block(k, shape, k == 0, 20e3) for k, shape in enumerate(shapes)]
    found = analyse(find_joints(Wall("head", tuple(blocks), 0.3, 0.12), JointSettings()))
    assert not found.local_failures
    assert found.headline.load_multiplier == pytest.approx(found.associative.load_multiplier, rel=2e-3)
    assert found.headline.load_multiplier < 0.04

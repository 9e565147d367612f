"""Blocks that meet in a point have no joint: limit analysis says so where its mechanism takes one into the other.

A block of 0.6 m x 0.5 m slides on a bed with friction 0.6; at its foot begins a slope of the ground, which it meets in
one corner. The way to the slope is barred: no multiplier moves the block so, and 0.6 is too low.
"""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from orchestrator import JointSettings, analyse, find_joints, loads_on, storage
from orchestrator.app import cli
from orchestrator.limit_analysis.moved_outlines import blocks_in_each_other
from orchestrator.loads import LoadSettings
from orchestrator.masonry.patterns import Rubble, rubble, running_bond
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import Block, Wall
from tests.support.paths import DATA
from tests.support.pushover_chain import rectangle
from tests.support.undrawn import undrawn

SAID = "go into each other"


def bed(angle, apart=0.0, size=1.0):
    """The wall of the title: the slope begins `apart` from the block, and rises at `angle` in degrees."""
    run = 0.7 / np.tan(np.radians(angle))
    corners = [(0.0, 0.0), (3.0 + run, 0.0), (3.0 + run, 1.2), (1.0 + apart + run, 1.2), (1.0 + apart, 0.5), (0.0, 0.5)]
    ground = Block(7, size * np.array(corners), True, 20e3)
    return Wall("bed", (ground, Block(9, size * rectangle(0.4, 0.5, 0.6, 0.5), False, 20e3)), 0.3, 0.6)


def analysed(wall, direction="+x"):
    assemblage = find_joints(wall, JointSettings())
    return analyse(assemblage, loads=loads_on(assemblage.wall, LoadSettings(direction)))


def said(wall, direction="+x"):
    return [remark for remark in analysed(wall, direction).remarks if SAID in remark]


@pytest.mark.parametrize("angle", [10.0, 45.0, 80.0])
@pytest.mark.parametrize("size", [0.05, 1.0, 100.0])
def test_a_corner_that_goes_into_a_slope_is_told(angle, size):
    (remark,) = said(bed(angle, size=size))
    assert not analysed(bed(angle, size=size)).is_bound
    assert remark.startswith("in the mechanism blocks 7 and 9 go into each other at (")
    assert "the multiplier may be too low" in remark


def test_far_from_the_origin_nothing_else_is_told():
    """Last digits of coordinates are larger there: shapely met "Ring edge missing" in what two blocks share."""
    assemblage = find_joints(read_blocks(DATA / "ferris_tinloi_wall1.json"), JointSettings())
    state, blocks = analysed(assemblage.wall).headline, assemblage.wall.blocks
    for place in 1e6 * np.random.default_rng(3).random((8, 2)):
        moved = replace(assemblage.wall, blocks=tuple(replace(one, polygon=one.polygon + place) for one in blocks))
        assert not blocks_in_each_other(replace(assemblage, wall=moved), state)


def test_away_from_the_slope_and_short_of_it_nothing_is_told():
    assert not said(bed(45.0), "-x")
    assert not said(bed(45.0, apart=0.05))


def test_a_slope_that_was_taken_away_does_not_bar_the_way():
    wall = bed(45.0)
    assemblage = find_joints(wall, JointSettings())
    state = analysed(wall).headline
    assert blocks_in_each_other(assemblage, state)
    assert not blocks_in_each_other(assemblage, state, without={7})


def test_a_joint_that_closes_in_the_mechanism_is_no_finding():
    """Two blocks whose joint crushes, or that stand apart, go into each other: other checks know."""
    wall = running_bond(2, 2)
    assemblage = find_joints(wall, JointSettings())
    state = analysed(wall).headline
    turned = replace(state.mechanism, velocities=-state.mechanism.velocities, opening=-state.mechanism.opening)
    closed = replace(state, mechanism=turned)
    silent = replace(closed, mechanism=replace(turned, opening=np.abs(turned.opening)))
    assert (turned.opening < 0.0).any()
    assert not blocks_in_each_other(assemblage, closed)
    assert blocks_in_each_other(assemblage, silent)


@pytest.mark.parametrize(
    "wall",
    [
        pytest.param(read_blocks(DATA / "ferris_tinloi_wall4.json"), id="published"),
        pytest.param(read_blocks(DATA / "arch27_t0107.json"), id="arch"),
        pytest.param(read_blocks(DATA / "rubble_36_stones.json"), id="drawn rubble"),
        pytest.param(rubble(Rubble(1.6, 1.4, stone=0.3, flatness=1.6, seed=3)), id="rubble"),
        pytest.param(read_blocks(DATA / "tower_5_blocks.json"), id="overturns"),
    ],
)
def test_walls_whose_contacts_are_all_joints_are_not_accused(wall):
    assert not said(wall)
    assert not said(wall, "-x")


def test_the_terminal_tells_it(tmp_path, capsys):
    path, wall = tmp_path / "bed.json", bed(45.0)
    blocks = [{"id": one.id, "polygon": one.polygon.tolist(), "fixed": one.fixed} for one in wall.blocks]
    units = {"length": "m", "unit_weight": "N/m3"}
    record = {"name": "bed", "units": units, "thickness": 0.3, "unit_weight": 20e3, "friction": 0.6, "blocks": blocks}
    path.write_text(json.dumps(record))
    assert cli.main(["limit", str(path), "--output", str(tmp_path / "run")]) == 0
    printed = capsys.readouterr().out.replace("\n", " ")
    assert "blocks 7 and 9 go into each other" in printed
    assert "is no upper bound, as stones bear where there is no joint." in printed
    assert "upper bound, and no lower one" not in printed


WEDGE = {
    "units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.3, "unit_weight": 20.0, "friction": 0.505,
    "blocks": [
        {"id": 0, "polygon": [[-1, -0.3], [4, -0.3], [4, 0], [-1, 0]], "fixed": True},
        {"id": 1, "polygon": [[0, 0], [0.6, 0], [0.6, 1], [0, 1]]},
        {"id": 2, "polygon": [[1.2, 0], [1.8, 0], [1.8, 1], [1.2, 1]]},
        {"id": 3, "polygon": [[0, 1], [0.6, 1], [0.5, 1.5], [0, 1.5]]},
        {"id": 4, "polygon": [[1.2, 1], [1.8, 1], [1.8, 1.5], [1.3, 1.5]]},
        {"id": 5, "polygon": [[0.6, 1], [1.2, 1], [1.3, 1.5], [0.5, 1.5]]},
    ],
}  # fmt: skip
"""a wedge between two stones on piers, whose lower corners just meet the piers'"""


def test_a_wedge_that_comes_to_rest_on_a_corner_is_told(tmp_path, capsys):
    """As drawn it bears a hundredth of its weight: friction of 0.505 for a thrust of 0.5. Once the wedge has gone down
    on the piers it bears 17 times as much, on corners: what that rests on is said. With elements of the default size
    it goes into the piers, and the curve ends there (docs/limits.md)."""
    (tmp_path / "wedge.json").write_text(json.dumps(WEDGE), encoding="utf-8")
    run = ["run", str(tmp_path / "wedge.json"), "--model", "micro", "--output", str(tmp_path / "run")]
    run += ["--set", "mesh.size=150mm"]
    run += ["--set", "stepping.load_increment=0.1"]  # 17 times what limit analysis expects is far in thirtieths of that
    with undrawn():
        assert cli.main(run) == 0
    printed = capsys.readouterr().out.replace("\n", " ")
    (found,) = storage.read_summary(tmp_path / "run").pushover
    assert found.peak_multiplier > 10 * storage.read_summary(tmp_path / "run").limit_analysis.multiplier
    assert "with contacts that were not drawn, without which it does not stand there" in printed
    assert "points in which stones touch as without force" in printed

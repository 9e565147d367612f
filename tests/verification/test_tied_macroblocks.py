"""Ties and macroblocks: bodies of several stones are held as their stones are, by statics and by the run of every
stone."""

from __future__ import annotations

import json

import numpy as np
import pytest

from orchestrator.app import driver
from orchestrator.settings import case as cases
from tests.support.pushover_chain import rectangle

pytestmark = pytest.mark.usefixtures("without_pictures")

WIDTH, HEIGHT, STONES, THICKNESS, UNIT_WEIGHT = 0.4, 1.2, 4, 0.3, 20e3
WEIGHT = UNIT_WEIGHT * WIDTH * HEIGHT * THICKNESS
STRENGTH, LEVEL = 0.2 * WEIGHT, 1.05
"""of the tie, and the height at which it holds the uppermost stone, m"""
TIED = WIDTH / HEIGHT + 2 * STRENGTH * LEVEL / (WEIGHT * HEIGHT)
"""lambda W h / 2 = W b / 2 + T z about the toe of the slender pier, which leans away from the stocky one"""


def case_of(folder, ties, *settings):
    """A slender pier of four stones beside a stocky one of four, both on the ground."""
    blocks = [{"id": 0, "polygon": rectangle(-6.0, -0.2, 10.0, 0.2).tolist(), "fixed": True}]
    for number in range(STONES):
        y, h = number * HEIGHT / STONES, HEIGHT / STONES
        blocks.append({"id": 1 + number, "polygon": rectangle(0.0, y, WIDTH, h).tolist()})
        blocks.append({"id": 11 + number, "polygon": rectangle(-4.0, y, 3.0, h).tolist()})
    wall = {"units": {"length": "m", "unit_weight": "N/m3"}, "thickness": THICKNESS, "unit_weight": UNIT_WEIGHT}
    (folder / "wall.json").write_text(json.dumps(wall | {"friction": 5.0, "blocks": blocks}))
    rows = ", ".join(
        f"{{blocks={blocks}, start={start}, end={end}, strength={STRENGTH}, stiffness=2e6}}"
        for blocks, start, end in ties
    )
    given = [f"reinforcement.ties=[{rows}]", "stepping.final_displacement=5mm", *settings]
    return cases.read(folder / "wall.json", given)


ACROSS = ([14, 4], [-1.0, LEVEL], [0.0, LEVEL])
WITHIN = ([1, 4], [0.2, 0.15], [0.2, LEVEL])


@pytest.mark.parametrize("how", ["macroblocks.choose=automatic", "macroblocks.tol_n=1e-3"])
def test_a_pier_of_stones_is_held_as_they_are(tmp_path, how):
    case = case_of(tmp_path, [ACROSS], how)
    assert driver.segment(case).partition.count < 2 * STONES
    summary = driver.run(case, tmp_path / "run", False, None, lambda _: None).summary
    assert summary.limit_analysis.associative == pytest.approx(TIED, rel=1e-6)
    macro, micro = summary.pushover
    assert macro.bodies < micro.bodies
    for pushed in (macro, micro):
        assert pushed.valid
        assert pushed.peak_multiplier == pytest.approx(TIED, rel=3e-3)
        forces = np.genfromtxt(tmp_path / "run" / pushed.model / "ties.csv", delimiter=",", names=True)
        assert forces["tie_1_N"].max() == pytest.approx(STRENGTH, rel=1e-6)


def test_a_tie_joins_no_stones_and_within_a_macroblock_holds_nothing(tmp_path):
    """Two piers tied to each other stay two macroblocks; a tie along a pier that turns as one is pointed out."""
    across, within = driver.segment(case_of(tmp_path, [ACROSS])), driver.segment(case_of(tmp_path, [WITHIN]))
    wall = across.assemblage.wall
    body = dict(zip((block.id for block in wall.blocks), across.partition.body_of_block.tolist(), strict=True))
    assert body[14] != body[4]
    assert not any("tie 1" in said for said in across.partition.remarks)
    assert (
        "tie 1 joins two stones of one macroblock: it holds nothing that could part there" in within.partition.remarks
    )
    assert within.analysis.headline.load_multiplier == pytest.approx(WIDTH / HEIGHT, rel=1e-6)

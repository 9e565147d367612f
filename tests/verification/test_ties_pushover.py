"""Ties in the FE pushover: blocks that are held back, against statics by hand and limit analysis with rigid ties."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.app import driver
from orchestrator.app.progress import IncrementDone
from orchestrator.limit_analysis import analyse
from orchestrator.masonry.patterns import running_bond
from orchestrator.masonry.ties import Tie, with_ties
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.increments import Increment
from orchestrator.pushover.settings import ElasticSettings
from orchestrator.settings import case as cases
from orchestrator.storage.files import write_json
from orchestrator.storage.values import blocks_record
from tests.support.limit_analysis_cases import analysed
from tests.support.pushover_chain import assemblage_of, model_of, rectangle, run, stack
from tests.verification.test_ranks import start

pytestmark = pytest.mark.usefixtures("without_pictures")

WIDTH, HEIGHT, THICKNESS, UNIT_WEIGHT = 0.4, 1.0, 0.1, 25e3
WEIGHT = UNIT_WEIGHT * WIDTH * HEIGHT * THICKNESS
FREE = WIDTH / HEIGHT
RIGID = ElasticSettings(elastic_modulus=1e13)
HELD = Tie(blocks=(1,), start=(-WIDTH / 2, HEIGHT), end=(-2.0, HEIGHT), strength=0.2 * WEIGHT, stiffness=5e5)
"""holds the top of the block at its left; with T at its top the multiplier rises by T h / (W h / 2)"""


def pushed(*ties: Tie, final=2e-2, step=0.05, friction=5.0, wall=None, **options):
    wall = wall or stack((WIDTH, HEIGHT), friction=friction)
    return run(model_of(wall, ties=ties, **options), final, displacement_increment=step)


def rows(result) -> list[Increment]:
    return [result.under_gravity, *(i for i in result.increments if i.phase != "gravity")]


@pytest.mark.parametrize("pretension", [0.0, 0.05 * WEIGHT])
def test_the_multiplier_rises_by_the_tie_that_yields(pretension):
    """lambda W h / 2 = W b / 2 + T h; limit analysis says the same, whatever stiffness and pretension."""
    tie = replace(HELD, pretension=pretension)
    result = pushed(tie)
    expected = FREE + 2 * tie.strength / WEIGHT
    assert result.peak == pytest.approx(expected, rel=2e-3)
    assert result.increments[-1].tie_force == pytest.approx([tie.strength])
    assert result.increments[-1].tie_rest[0] > result.under_gravity.tie_rest[0] + 1e-3, "it has stretched for good"
    wall = with_ties(assemblage_of(stack((WIDTH, HEIGHT), friction=5.0)), (tie,))
    assert analyse(wall).associative.load_multiplier == pytest.approx(expected, rel=1e-6)


def test_the_elastic_branch_has_the_stiffness_of_the_tie():
    """After uplift the base shear grows by k u h / (h / 2) with the displacement u of the top, until the tie yields."""
    result = pushed(replace(HELD, strength=WEIGHT), final=2e-3, elastic=RIGID)
    rising = [i for i in rows(result) if i.control_displacement > 0.2e-3 and i.tie_force[0] < 0.999 * WEIGHT]
    shear, moved = (np.array([getattr(i, name) for i in rising]) for name in ("base_shear", "control_displacement"))
    assert len(rising) > 5
    assert np.diff(shear) / np.diff(moved) == pytest.approx(2 * HELD.stiffness, rel=0.01)
    assert shear[-1] == pytest.approx(FREE * WEIGHT + 2 * HELD.stiffness * moved[-1], rel=2e-3)


def test_the_pretension_is_there_when_the_load_begins():
    """lambda = 0: the tie pulls with its pretension, the supports against it; the block lifts off P h later."""
    pretension = 0.1 * WEIGHT
    result = pushed(replace(HELD, pretension=pretension), final=1e-3, elastic=RIGID)
    still = result.under_gravity
    assert still.tie_force == pytest.approx([pretension], rel=1e-12)
    assert abs(still.base_shear) < 1e-6 * WEIGHT, "anchor and bed hold each other in balance"
    lifted = next(i for i in rows(result) if i.tie_force[0] > pretension + 0.002 * WEIGHT)
    expected = FREE + 2 * pretension / WEIGHT
    assert lifted.load_multiplier == pytest.approx(expected + 2 * (lifted.tie_force[0] - pretension) / WEIGHT, rel=5e-3)


def test_a_tie_does_not_push_but_a_floor_does():
    """The other way the tie is slack; one that pushes holds the block as it does this way."""
    slack, floor = (pushed(replace(HELD, pushes=pushes), direction=-1) for pushes in (False, True))
    assert slack.peak == pytest.approx(FREE, rel=2e-3)
    assert slack.increments[-1].tie_force[0] == 0.0
    assert floor.peak == pytest.approx(FREE + 2 * HELD.strength / WEIGHT, rel=2e-3)
    assert floor.increments[-1].tie_force == pytest.approx([-HELD.strength])
    wall = with_ties(assemblage_of(stack((WIDTH, HEIGHT), friction=5.0)), (replace(HELD, pushes=True),))
    assert analysed(wall, -1).associative.load_multiplier == pytest.approx(floor.peak, rel=2e-3)


def test_an_upright_tie_through_the_bed():
    """Anchored below the middle of the bed: (W + T) b / 2 = lambda W h / 2."""
    tie = Tie(blocks=(1,), start=(0.0, HEIGHT), end=(0.0, -0.1), strength=0.5 * WEIGHT, stiffness=1e6)
    result = pushed(tie)
    assert result.peak == pytest.approx(1.5 * FREE, rel=3e-3)


def test_a_tie_between_two_blocks():
    """A slender pier leans away from a stocky one to which its top is tied."""
    blocks = (
        Block(0, rectangle(-4.0, -0.2, 8.0, 0.2), True, UNIT_WEIGHT),
        Block(1, rectangle(-WIDTH / 2, 0.0, WIDTH, HEIGHT), False, UNIT_WEIGHT),
        Block(2, rectangle(-3.0, 0.0, 2.0, HEIGHT), False, UNIT_WEIGHT),
    )
    tie = Tie(blocks=(2, 1), start=(-1.0, 0.9), end=(-WIDTH / 2, 0.9), strength=0.2 * WEIGHT, stiffness=1e6)
    result = pushed(tie, wall=Wall("piers", blocks, THICKNESS, 5.0))
    assert result.peak == pytest.approx(FREE + 2 * 0.9 * tie.strength / WEIGHT, rel=3e-3)
    last = result.increments[-1]
    assert last.base_shear == pytest.approx(last.load_multiplier * result.model.horizontal_load, rel=1e-3)


def turned(point, angle):
    """A point of the block turned clockwise about its right toe."""
    toe = np.array([WIDTH / 2, 0.0])
    arm = np.asarray(point) - toe
    cosine, sine = np.cos(angle), np.sin(angle)
    return toe + np.array([cosine * arm[0] + sine * arm[1], -sine * arm[0] + cosine * arm[1]])


def test_a_tie_turns_with_the_wall():
    """Large displacements: moments about the toe of the turned block, the tie along the line to its anchor."""
    tie = replace(HELD, end=(-0.5, HEIGHT), strength=10 * WEIGHT, stiffness=1e4)
    result = pushed(tie, final=0.3, large_displacement=True)
    toe, anchor = np.array([WIDTH / 2, 0.0]), np.array(tie.end)
    compared = 0
    for state in rows(result):
        if state.moving or state.control_displacement < 0.02:
            continue
        angle = np.linspace(0.0, 0.4, 40_001)
        tops = (turned((-WIDTH / 2, HEIGHT), 0.0)[0], turned((WIDTH / 2, HEIGHT), 0.0)[0])
        mean = WIDTH / 2 * (1 - np.cos(angle)) + HEIGHT * np.sin(angle)
        theta = float(np.interp(state.control_displacement, mean, angle))
        assert tops[0] < tops[1]
        end, centre = turned(tie.start, theta) - toe, turned((0.0, HEIGHT / 2), theta) - toe
        line = anchor - toe - end
        length = np.linalg.norm(line)
        pull = tie.stiffness * (length - 1 * (0.5 - WIDTH / 2))
        held = float(end[0] * line[1] - end[1] * line[0]) / length * pull  # counter-clockwise
        expected = (WEIGHT * -centre[0] + held) / (WEIGHT * centre[1])
        assert state.tie_force[0] == pytest.approx(pull, rel=0.01)
        assert state.load_multiplier == pytest.approx(expected, abs=5e-3 * FREE)
        compared += 1
    assert compared > 10


@pytest.mark.parametrize("large_displacement", [False, True])
@pytest.mark.parametrize("pretension", [0.0, 0.05 * WEIGHT])
def test_energy_and_reactions_count_the_tie(pretension, large_displacement):
    result = pushed(replace(HELD, pretension=pretension), large_displacement=large_displacement)
    last = result.increments[-1]
    assert result.effort.energy_error < 0.01
    total = last.internal_energy + last.dissipated_energy + last.other_work + last.energy_error + last.lost_in_motion
    assert last.external_work == pytest.approx(total, rel=1e-9)
    yielding = HELD.strength * (last.tie_rest[0] - result.under_gravity.tie_rest[0])
    assert yielding > 0.2 * last.dissipated_energy
    for state in rows(result):
        if not state.moving:
            assert state.base_shear == pytest.approx(state.load_multiplier * WEIGHT, abs=2e-3 * WEIGHT)


CASE = [
    "run.models=['micro']",
    "stepping.final_displacement=0.3mm",
    "joints.classes=[{normal_stiffness='20 N/mm3', shear_stiffness='8 N/mm3', compressive_strength='0.1 MPa'}]",
]


@pytest.fixture(scope="module")
def tied(tmp_path_factory):
    """A running bond of 17 stones on mortar that crushes, its highest stone tied to an anchor."""
    folder = tmp_path_factory.mktemp("tied")
    wall = running_bond(3, 5)
    write_json(folder / "wall.json", blocks_record(wall))
    top = max((b for b in wall.blocks if not b.fixed), key=lambda b: float(b.polygon.mean(axis=0) @ [-1e-3, 1.0]))
    x, y = top.polygon.mean(axis=0)
    tie = (
        f"{{blocks=[{top.id}], start=[{x}, {y}], end=[{x - 3.0}, {y}], strength='0.5 kN', stiffness='2 kN/mm', "
        "pretension='0.1 kN'}"
    )
    return folder / "wall.json", [*CASE, f"reinforcement.ties=[{tie}]"]


class Killed(Exception):
    """Stands for the signal that ends a run between two increments."""


def curve_of(folder):
    table = np.genfromtxt(folder / "micro" / "curve.csv", delimiter=",", names=True)
    return np.column_stack([table[name] for name in ("load_multiplier", "base_shear_N", "control_displacement_m")])


@pytest.fixture(scope="module")
def whole(tied, tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    driver.run(cases.read(tied[0], tied[1]), folder, False, None, lambda _: None)
    forces = np.genfromtxt(folder / "micro" / "ties.csv", delimiter=",", names=True)
    assert forces["tie_1_N"][forces["load_multiplier"] == 0.0][-1] == pytest.approx(100.0), "the pretension"
    assert forces["tie_1_N"][-1] > 101.0
    return curve_of(folder)


def test_a_tied_wall_on_mortar_is_resumed(tied, whole, tmp_path):
    def report(event):
        if isinstance(event, IncrementDone) and event.increment.number == 20:
            raise Killed

    with pytest.raises(Killed):
        driver.run(cases.read(tied[0], tied[1]), tmp_path, False, None, report)
    driver.run(cases.read(tied[0], tied[1]), tmp_path, True, None, lambda _: None)
    found = curve_of(tmp_path)
    assert len(found) > 25
    assert found == pytest.approx(whole, rel=1e-10, abs=1e-12)


def test_a_tied_wall_on_mortar_is_the_same_on_two_ranks(tied, whole, tmp_path):
    """Until an increment takes more than ten iterations: of what follows rounding decides (docs/limits.md), but for the
    peak and where the curve ends."""
    arguments = [part for setting in tied[1] for part in ("--set", setting)]
    start(2, tmp_path, *arguments, "--set", "newton.distribute_above=0", wall=tied[0])
    found, iterations = (
        curve_of(tmp_path),
        np.genfromtxt(tmp_path / "micro" / "curve.csv", delimiter=",", names=True)["newton_iterations"],
    )
    alike = int(np.argmax(np.append(iterations, np.inf) > 10))
    assert alike > 25
    assert found[:alike] == pytest.approx(whole[:alike], rel=1e-8, abs=1e-12 * whole.max())
    assert found.max(axis=0) == pytest.approx(whole.max(axis=0), rel=1e-3)
    assert found[-1] == pytest.approx(whole[-1], rel=1e-3)

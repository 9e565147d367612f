"""What falls under the weight alone and is a small part is a local failure: the wall goes on without it.

Triangular chips stand at the free ends of a running bond, between a face at 40 degrees and the stone above. Friction of
0.6 locks them there, and limit analysis has them standing. In finite elements friction is at its limit after an elastic
slip of contact.slip_tolerance, 1e-3 mm; stones shorten by 5e-5 mm under their weight, so that a chip has let go of
what presses it before friction holds it.
"""

from __future__ import annotations

import csv
import json
from itertools import islice, pairwise
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from orchestrator import storage
from orchestrator.app import driver
from orchestrator.app.cli import main
from orchestrator.app.progress import IncrementDone
from orchestrator.app.pushed import Pushed, push
from orchestrator.basis.errors import ConvergenceError
from orchestrator.limit_analysis import LimitAnalysis, analyse
from orchestrator.loads import LiveLoad, LoadSettings, loads_on
from orchestrator.loads.local_part import MOST_LOCAL
from orchestrator.macroblocks.criteria import Partition, one_body_per_block, partition_of
from orchestrator.masonry.joints import Assemblage, JointSettings, find_joints
from orchestrator.masonry.wall import Block, Wall
from orchestrator.present.answer import answer_of_run
from orchestrator.pushover.increments import Increment
from orchestrator.pushover.meshing import MeshSettings
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import ContactSettings, NewtonSettings, SteppingSettings
from orchestrator.pushover.solve.linear_system import LinearSystem
from orchestrator.settings import case as cases
from orchestrator.storage.stored_increments import StateStore
from tests.support.pushover_chain import model_of
from tests.support.seconds import shared
from tests.support.undrawn import undrawn
from tests.support.walls import between

WIDTH, COURSES, HIGH, CHIP = 1.2, 4, 0.3, 0.25
"""m, and number; a chip is CHIP wide at its top"""
SHARE = 0.5 * CHIP * HIGH / (WIDTH * COURSES * HIGH)
SHORT = SteppingSettings(final_displacement=0.01)


def chipped(right: bool = True, left: bool = False, chips: bool = True) -> Wall:
    """Four courses of running bond on a support; the ends of the second one are chips. Those come last, right first."""
    outlines = [between(-0.3, -0.3, WIDTH + 0.3, 0.0)]
    for course in range(COURSES):
        cuts = (0.0, 0.3, 0.9, WIDTH) if course % 2 else (0.0, 0.6, WIDTH)
        for one, other in pairwise(cuts):
            outlines.append(between(one, course * HIGH, other, (course + 1) * HIGH))
    ends = [[WIDTH, HIGH], [WIDTH, 2 * HIGH], [WIDTH - CHIP, 2 * HIGH]], [[0, HIGH], [CHIP, 2 * HIGH], [0, 2 * HIGH]]
    if right:
        outlines[5] = np.array([[0.9, HIGH], ends[0][0], ends[0][2], [0.9, 2 * HIGH]])
    if left:
        outlines[3] = np.array([ends[1][0], [0.3, HIGH], [0.3, 2 * HIGH], ends[1][1]])
    if chips:
        outlines += [np.array(end) for end, is_there in zip(ends, (right, left), strict=True) if is_there]
    blocks = tuple(Block(n, outline, n == 0, 20e3) for n, outline in enumerate(outlines))
    return Wall("chipped", blocks, 0.5, 0.6)


NUMBER = len(chipped().blocks) - 1


def analysed(wall: Wall, load: LoadSettings) -> tuple[Assemblage, LimitAnalysis]:
    assemblage = find_joints(wall, JointSettings())
    return assemblage, analyse(assemblage, loads=loads_on(wall, load))


def pushed(
    wall: Wall,
    load: LoadSettings,
    partition: Partition | None = None,
    slip_tolerance: float = 1e-6,
    mesh: MeshSettings | None = None,
) -> Pushed:
    assemblage, analysis = analysed(wall, load)
    bodies, contact = partition or one_body_per_block(assemblage), ContactSettings(slip_tolerance)
    return push(assemblage, analysis, bodies, load, contact=contact, stepping=SHORT, mesh=mesh)


def block_file(folder: Path) -> Path:
    """Write the wall with one chip into a folder."""
    blocks = [{"id": one.id, "polygon": one.polygon.tolist(), "fixed": one.fixed} for one in chipped().blocks]
    record = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.5, "friction": 0.6, "unit_weight": 20.0}
    (folder / "wall.json").write_text(json.dumps(record | {"blocks": blocks}), encoding="utf-8")
    return folder / "wall.json"


@pytest.fixture(scope="module", params=["+x", "-x"])
def done(request, tmp_path_factory):
    """Direction, exit code and folder of `run` with both models, of elements of one size with the chip or without."""
    folder = tmp_path_factory.mktemp("chipped")
    options = [f"load.direction={request.param}", "stepping.final_displacement=10mm", "project.language=en"]
    options.append("mesh.toe_offset=0.5")
    command = ["run", str(block_file(folder)), "--output", str(folder / "run")]
    with undrawn():
        code = main([*command, *(word for option in options for word in ("--set", option))])
    return request.param, code, folder / "run"


def test_a_run_goes_on_without_it_and_says_what_to_try(done):
    _, code, folder = done
    assert code == 0
    summary = storage.read_summary(folder)
    assert not summary.failed
    (micro,) = (one for one in summary.pushover if one.model == "micro")
    (event,) = micro.events
    assert (event.bodies, event.under_gravity, event.load_multiplier) == ((f"block {NUMBER}",), True, 0.0)
    assert event.dead_load_share == pytest.approx(SHARE, rel=1e-6)
    assert micro.at_peak.fallen == pytest.approx(SHARE, rel=1e-6)
    assert micro.valid
    assert micro.energy_error < 1e-3
    (said,) = (text for text in storage.remarks(summary) if "fell" in text and text.startswith("micro FE: block"))
    assert said.startswith(
        f"micro FE: block {NUMBER} (2.6 % of the dead load) fell under the dead load alone; the wall"
    )
    assert "limit analysis has all stones standing there: try a smaller contact.slip_tolerance" in said
    assert said in " ".join((folder / "report.html").read_text(encoding="utf-8").split())
    with undrawn():
        assert main(["report", str(folder)]) == 0
    with (folder / "micro" / "curve.csv").open(newline="") as file:
        first = next(csv.DictReader(file))
    assert (first["load_multiplier"], first["fallen_bodies"]) == ("0.0", "1")
    assert float(first["horizontal_load_N"]) == pytest.approx((1 - SHARE) * summary.wall.weight, rel=1e-6)


def test_what_is_left_bears_what_the_wall_bears_that_was_drawn_without_it(done):
    direction, _, folder = done
    micro = next(one for one in storage.read_summary(folder).pushover if one.model == "micro")
    bare = pushed(chipped(chips=False), LoadSettings(direction), mesh=MeshSettings(toe_offset=0.5))
    assert micro.peak_multiplier == pytest.approx(bare.capacity.peak_multiplier, rel=5e-3)


def test_with_a_smaller_slip_tolerance_it_stands_until_the_load_takes_it():
    """Limit analysis has it come loose at 0.092."""
    load = LoadSettings("+x")
    _, analysis = analysed(chipped(), load)
    (failure,) = analysis.local_failures
    assert failure.stones == (NUMBER,)
    assert failure.multipliers[0] > 0.05
    fine = pushed(chipped(), load, slip_tolerance=1e-8)
    (event,) = fine.summary.events
    assert not event.under_gravity
    assert event.load_multiplier > 0.05
    coarse = pushed(chipped(), load)
    assert coarse.summary.events[0].under_gravity
    for one in (fine, coarse):
        assert one.capacity.peak_multiplier == pytest.approx(analysis.headline.load_multiplier, rel=0.01)


def test_a_macroblock_that_falls_under_gravity_is_local_as_a_stone_is():
    """To -x limit analysis lists no loose stone; the chip is a body beside two others."""
    load = LoadSettings("-x")
    assemblage, analysis = analysed(chipped(), load)
    assert not analysis.local_failures
    height = np.array([one.polygon[:, 1].mean() for one in assemblage.wall.blocks])
    group = np.where(height > 2 * HIGH, 2, 1)
    group[[0, NUMBER]] = 0, 3
    partition = partition_of(assemblage, group)
    assert partition.count == 3
    done = pushed(chipped(), load, partition)
    assert done.summary.model == "macro"
    (event,) = done.summary.events
    assert event.under_gravity
    assert event.bodies == (f"block {NUMBER}",)
    assert not done.complaints


@pytest.mark.parametrize("share", [0.04, 0.06])
def test_a_chip_with_more_of_the_live_load_than_a_local_part_is_the_wall(share):
    """2.6 % of the dead load: it is what the wall was asked to bear that decides."""
    forces = LiveLoad(blocks=(1,), force=(1 - share) * 1e3), LiveLoad(blocks=(NUMBER,), force=share * 1e3)
    load = LoadSettings(distribution="per_block", live=forces)
    if share > SteppingSettings().local_share:
        with pytest.raises(ConvergenceError, match=f"does not stand under its dead load: block {NUMBER} falls"):
            pushed(chipped(), load)
        return
    (event,) = pushed(chipped(), load).summary.events
    assert event.under_gravity


def test_chips_that_do_not_touch_are_failures_of_their_own():
    """All that is loose falls at once under gravity. Two of 2.6 % each, 5.2 % together, are no wall that falls."""
    assert SteppingSettings().local_share < 2 * SHARE
    done = pushed(chipped(left=True), LoadSettings("+x"))
    events = done.summary.events
    assert {body for event in events for body in event.bodies} == {f"block {NUMBER}", f"block {NUMBER + 1}"}
    assert all(event.under_gravity for event in events)
    assert not done.complaints
    assert 2 * SHARE < MOST_LOCAL


def test_one_that_is_larger_than_a_local_part_is_the_wall():
    assemblage, analysis = analysed(chipped(), LoadSettings("+x"))
    small = SteppingSettings(local_share=0.9 * SHARE)
    with pytest.raises(ConvergenceError, match=f"does not stand under its dead load: block {NUMBER} falls"):
        push(assemblage, analysis, one_body_per_block(assemblage), LoadSettings("+x"), stepping=small)


@pytest.mark.usefixtures("without_pictures")
def test_macroblocks_that_are_every_stone_have_its_curve_which_is_followed_once(tmp_path):
    """With a fine slip tolerance and elements of 0.2 m the chip falls under the load to -x, where limit analysis lists
    no loose stone; finer elements hold it, and bear its 0.6000."""
    settings = ["load.direction=-x", "stepping.final_displacement=10mm", "contact.slip_tolerance=0.00001mm"]
    settings += ["mesh.size=200mm", "mesh.toe_offset=0.5"]
    case, told = cases.read(block_file(tmp_path), settings), list[IncrementDone]()

    def report(event):
        if isinstance(event, IncrementDone):
            told.append(event)

    found = driver.segment(case)
    stones = found.divided(one_body_per_block(found.assemblage))
    outcome = driver.push(case, stones, tmp_path / "run", False, None, report)
    assert outcome.summary.macroblocks.count == NUMBER
    macro, micro = outcome.summary.pushover
    assert macro.events == micro.events
    assert macro.events[0].load_multiplier > 0.05
    assert macro.peak_multiplier == micro.peak_multiplier
    assert {event.model for event in told} == {"macro"}
    curves = [(tmp_path / "run" / model / "curve.csv").read_bytes() for model in ("macro", "micro")]
    assert curves[0] == curves[1]
    assert "macroblocks are every stone, too" in answer_of_run(outcome.summary)
    again = driver.push(case, stones, tmp_path / "run", True, None, report)
    assert len(told) == macro.steps
    assert again.summary.pushover[1].peak_multiplier == micro.peak_multiplier


@shared
def path() -> tuple[object, list[Increment]]:
    model = model_of(chipped(), mesh_size=0.3, large_displacement=True)
    with LinearSystem(model, MPI.COMM_SELF) as system:
        return model, list(islice(Pushover(model, system, NewtonSettings(), SHORT).increments(), 60))


def test_gravity_goes_on_until_all_weight_of_what_is_left_acts():
    model, increments = path()
    gravity = [one for one in increments if one.phase == "gravity"]
    first = next(k for k, one in enumerate(gravity) if one.fallen.any())
    assert gravity[first].moving
    assert gravity[first].time < 1.0
    last = gravity[-1]
    assert (last.time, last.moving, last.fallen.sum()) == (1.0, False, 1)
    assert last.horizontal_load == pytest.approx((1 - SHARE) * model.weight, rel=1e-6)
    slave, master = model.pairs
    assert not last.normal_force[(slave == NUMBER - 1) | (master == NUMBER - 1)].any()
    on_ground = np.maximum(slave, master) >= model.bodies
    assert last.normal_force[on_ground].sum() == pytest.approx((1 - SHARE) * model.weight, rel=1e-6)
    assert [one.phase for one in increments[len(gravity) :]][:3] == ["load"] * 3


def test_a_run_that_is_resumed_while_it_falls_has_the_same_increments(tmp_path):
    """Bit for bit, before it is taken out and after, from the increment as it comes back from its file."""
    model, increments = path()
    out = next(k for k, one in enumerate(increments) if one.fallen.any())
    for start in (out - 2, out):
        assert increments[start].moving
        store = StateStore(tmp_path / str(start), "chipped")
        store.append(increments[start])
        (stored,) = StateStore(tmp_path / str(start), "chipped").increments()
        with LinearSystem(model, MPI.COMM_SELF) as system:
            following = list(islice(Pushover(model, system, NewtonSettings(), SHORT).increments(stored), 10))
        for found, expected in zip(following, increments[start + 1 :], strict=False):
            assert (found.number, found.phase, found.time) == (expected.number, expected.phase, expected.time)
            assert found.displacement.tobytes() == expected.displacement.tobytes()
            assert found.fallen.tobytes() == expected.fallen.tobytes()

"""A small part that falls is an event at its own multiplier, and the wall goes on to its own peak.

One stone of b x h on a wide block overturns at b/h, whatever its share of the mass: no static state carries more, and
what moves carries nothing.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import islice, pairwise

import numpy as np
import pytest
from mpi4py import MPI

from orchestrator.app.pushed import Pushed, push
from orchestrator.assessment.capacity import find_capacity
from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.loads import DeadLoad, LiveLoad, LoadSettings, loads_on
from orchestrator.macroblocks.automatic import macroblocks_of
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from orchestrator.masonry.wall import Block, Wall
from orchestrator.present.answer import answer_of_limit
from orchestrator.pushover.increments import Increment
from orchestrator.pushover.meshing import MeshSettings
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import NewtonSettings, SteppingSettings
from orchestrator.pushover.solve.linear_system import LinearSystem
from orchestrator.storage.stored_increments import StateStore
from tests.support.pushover_chain import Run, model_of, rectangle, run
from tests.support.seconds import shared

BOUND = SteppingSettings().out_of_balance
HEIGHTS = (0.8, 0.85, 0.9, 0.95, 1.0)
"""of pinnacles 0.3 m wide, m"""
PINS = {  # stone b, h and block B, H in m, mesh size in m
    0.30: (1.0, 3.0, 7.0, 1.0, 1.0),
    0.02: (0.5, 1.5, 9.0, 4.0, 2.0),
    0.0015: (0.2, 0.6, 10.0, 8.0, 4.0),
    0.0001: (0.05, 0.15, 10.0, 7.5, 4.0),
}


def pin(b: float, h: float, width: float, height: float) -> Wall:
    """A stone in the middle of a wide block."""
    blocks = (
        Block(0, rectangle(-width, -0.5, 3 * width, 0.5), True, 25e3),
        Block(1, rectangle(0, 0, width, height), False, 25e3),
        Block(2, rectangle(width / 2 - b / 2, height, b, h), False, 25e3),
    )
    return Wall("pin", blocks, 0.3, 0.7)


def chimney(stones: int = 3) -> Wall:
    """A facade of 3 m x 2.4 m in running bond with a chimney of three stones, 0.2 m x 0.6 m: 1/3."""
    blocks, level = [Block(0, rectangle(-1, -0.3, 5, 0.3), True, 20e3)], 0.0
    for course in range(6):
        off = 0.25 * (course % 2)
        cuts = [0.0, *(off + 0.5 * k for k in range(7) if 0 < off + 0.5 * k < 3), 3.0]
        for left, right in pairwise(cuts):
            blocks.append(Block(len(blocks), rectangle(left, level, right - left, 0.4), False, 20e3))
        level += 0.4
    blocks += [Block(len(blocks) + k, rectangle(2.0, level + 0.2 * k, 0.2, 0.2), False, 20e3) for k in range(stones)]
    return Wall("chimney", tuple(blocks), 0.4, 0.7)


def pushed_with(wall: Wall, stepping: SteppingSettings) -> Pushed:
    """Push every stone of a wall as `run` does, with elements of one size."""
    assemblage = find_joints(wall, JointSettings())
    mesh = MeshSettings(toe_offset=0.5)
    return push(assemblage, analyse(assemblage), one_body_per_block(assemblage), stepping=stepping, mesh=mesh)


@shared
def pushed(share: float) -> Run:
    *sizes, mesh = PINS[share]
    model = model_of(pin(*sizes), mesh_size=mesh, large_displacement=True)
    assert model.body_mass[1] / model.body_mass.sum() == pytest.approx(share, rel=0.1)
    return run(model, 0.1)


@shared
def facade() -> Run:
    return run(model_of(chimney(), mesh_size=0.4, large_displacement=True), 0.1)


def hold(increments: list[Increment], body: int) -> Increment:
    """Return the last static increment before a body falls, or of all."""
    standing = [i for i in increments if not i.moving and not i.fallen[body]]
    return max(standing, key=lambda i: i.load_multiplier)


@pytest.mark.parametrize("share", PINS)
def test_a_stone_overturns_at_b_over_h_whatever_its_share_of_the_mass(share):
    result = pushed(share)
    assert hold(result.increments, 1).load_multiplier == pytest.approx(1 / 3, rel=5e-3)
    if share >= SteppingSettings().local_share:  # the wall's own peak
        assert result.peak == pytest.approx(1 / 3, rel=5e-3)
        assert result.effort.events == ()
        return
    (event,) = result.effort.events
    assert event.bodies == ("block 2",)
    assert event.dead_load_share == pytest.approx(share, rel=0.1)
    assert event.load_multiplier == pytest.approx(1 / 3, rel=5e-3)
    largest = result.curve.static.load_multiplier.max()
    assert largest == pytest.approx(0.7, rel=5e-3), "what is left slides at the coefficient of friction"


def falls_from_a_tower(stones: int, slenderness: float, left: float, width: float, height: float) -> None:
    """A pin on a tower 2 m high overturns at 1/3, and the tower at its slenderness, whether or not the pin is gone."""
    courses = [rectangle(0, 2.0 / stones * n, 2 * slenderness, 2.0 / stones) for n in range(stones)]
    blocks = [
        Block(0, rectangle(-1, -0.5, 3, 0.5), True, 25e3),
        Block(9, rectangle(left, 2.0, width, height), False, 25e3),
    ]
    blocks += [Block(n, course, False, 25e3) for n, course in enumerate(courses, 1)]
    found = pushed_with(Wall("pin on a tower", tuple(blocks), 0.3, 0.7), SteppingSettings())
    (event,) = found.summary.events
    assert event.bodies == ("block 9",)
    assert event.load_multiplier == pytest.approx(1 / 3, rel=5e-3)
    assert found.curve.static.load_multiplier.max() == pytest.approx(slenderness, rel=5e-3)


@pytest.mark.parametrize("slenderness", [0.336, 0.338, 0.340, 0.342, 0.344])
def test_a_stone_that_falls_just_before_the_wall_is_not_the_wall(slenderness):
    """A pin of 0.3 % and a tower that overturn in one increment of load: both are driven, and the pin alone goes on."""
    falls_from_a_tower(1, slenderness, slenderness - 0.02, 0.04, 0.12)


@pytest.mark.parametrize("stones", [1, 2])
def test_a_stone_that_creeps_from_rest_to_rest_just_before_the_wall_is_not_the_wall(stones):
    """A pin of 1.8 %, driven with the tower, leans in motions that each come to rest at a lower load."""
    falls_from_a_tower(stones, 0.34, 0.2, 0.09, 0.27)


@pytest.mark.parametrize(("force", "share"), [(100.0, 0.145 / 4.825), (250.0, 0.295 / 4.975)])
def test_a_floor_on_a_stone_counts_in_its_share(force, share):
    """A pin of 45 N on 4.68 kN, with a force that has inertia at its centroid: it overturns at 60/125 = 0.48 all the
    same. With 100 N it is 3.0 % of the dead load and falls off the wall; with 250 N it is 5.9 %, and the wall fails."""
    courses = ((0, 0, 0.7, 0.5), (0, 0.5, 0.7, 0.5), (0, 1.0, 0.64, 0.125), (0.64, 1.0, 0.06, 0.125))
    blocks = (Block(0, rectangle(0, -0.2, 0.7, 0.2), True, 20e3),)
    blocks += tuple(Block(n, rectangle(*one), False, 20e3) for n, one in enumerate(courses, 1))
    load = LoadSettings(dead=(DeadLoad(blocks=(4,), force=force, inertia=True),))
    assemblage = find_joints(Wall("pin", blocks, 0.3, 0.8), JointSettings())
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    found = push(assemblage, analysis, one_body_per_block(assemblage), load)
    if share >= SteppingSettings().local_share:
        assert not analysis.local_failures
        assert analysis.headline.load_multiplier == pytest.approx(0.48, rel=1e-6)
        assert found.capacity.peak_multiplier == pytest.approx(0.48, rel=5e-3)
        return
    (failure,), (event,) = analysis.local_failures, found.summary.events
    assert failure.share == pytest.approx(share, rel=1e-9)
    assert event.dead_load_share == pytest.approx(share, rel=1e-6)
    assert event.load_multiplier == pytest.approx(0.48, rel=5e-3)
    assert found.capacity.peak_multiplier > 0.6


def test_the_chimney_falls_and_the_facade_goes_on_to_its_own_peak():
    """It overturns as one; its stones come off one after the other in the same motion, the lowest may come to rest.

    What is left carries what the facade carries that never had a chimney.
    """
    result = facade()
    events = result.effort.events
    assert events[0].bodies == ("block 42",)
    assert {name for event in events for name in event.bodies} <= {"block 40", "block 41", "block 42"}
    for event in events:
        assert event.dead_load_share == pytest.approx(len(event.bodies) * 0.04 / (3 * 2.4 + 3 * 0.04))
        assert event.load_multiplier == pytest.approx(1 / 3, rel=5e-3)
        assert event.base_shear == pytest.approx(event.load_multiplier * result.model.weight, rel=1e-4)
    first = result.increments[events[0].increment - result.increments[0].number]
    assert first.moving
    assert first.fallen.sum() == 1
    stood = [row for row in result.increments if not row.moving and row.number < first.number][-1]
    stone = result.model.meshes.body_of_node == first.fallen.argmax()
    moved = (first.displacement - stood.displacement)[: len(stone)][stone, :2].mean(axis=0)
    assert 0.45 * 0.2 < np.linalg.norm(moved) < 0.65 * 0.2, "half of its size, and no more than three steps of motion"
    bare = run(model_of(chimney(0), mesh_size=0.4, large_displacement=True), 0.1)
    largest = result.curve.static.load_multiplier.max()
    assert largest == pytest.approx(bare.curve.static.load_multiplier.max(), rel=1e-2)
    assert largest > 1.02 * events[0].load_multiplier
    assert result.curve.static.fallen_bodies[result.curve.static.load_multiplier.argmax()] >= 2


def test_macroblocks_lose_the_chimney_and_bear_what_every_stone_bears():
    """The stones that limit analysis lists as loose fall at b/h as they do stone by stone; the facade goes on."""
    assemblage = find_joints(chimney(), JointSettings())
    analysis = analyse(assemblage)
    bodies = macroblocks_of(assemblage, analysis)
    assert bodies.count < 10
    done = push(assemblage, analysis, bodies, stepping=SteppingSettings(final_displacement=0.1))
    assert done.summary.valid
    assert done.summary.events[0].load_multiplier == pytest.approx(1 / 3, rel=5e-3)
    largest = facade().curve.static.load_multiplier.max()
    assert done.curve.static.load_multiplier.max() == pytest.approx(largest, rel=0.02)


def test_a_stone_that_falls_while_the_part_around_it_is_driven_does_not_unload_the_wall():
    """The narrow stone at the end of the top course is driven with 23 others when it loses its balance.

    The wall then carries what the same wall carries that was drawn without it, with the same elements.
    """
    courses = IrregularCourses(1.4, 1.0, seed=3)
    wall = irregular_courses(courses)
    narrow = max(wall.blocks, key=lambda block: block.id)
    with_it, without = (
        pushed_with(one, SteppingSettings(final_displacement=courses.height / 30))
        for one in (wall, replace(wall, blocks=tuple(block for block in wall.blocks if block is not narrow)))
    )
    (event,) = with_it.summary.events
    assert event.bodies == (f"block {narrow.id}",)
    curve = with_it.curve
    before = curve.step < event.increment
    assert curve.moving[before][-1], "it moves before it is out"
    assert curve.stopped_because.startswith("final displacement")
    carried = [done.curve.static.load_multiplier.max() for done in (with_it, without)]
    assert carried[0] == pytest.approx(carried[1], rel=5e-3)


@pytest.mark.parametrize("made", [*(f"pin {share}" for share in PINS), "chimney"])
def test_every_row_that_counts_is_static_body_by_body(made):
    result = facade() if made == "chimney" else pushed(float(made.split()[1]))
    curve = result.curve
    assert curve.static.out_of_balance.max() <= BOUND
    balanced = (curve.out_of_balance <= BOUND) & (curve.moving == 0)
    assert find_capacity(curve).peak_base_shear == curve.base_shear_N[balanced].max()


@pytest.mark.parametrize("made", ["pin", "chimney"])
def test_what_has_fallen_touches_nothing_and_carries_nothing(made):
    result = facade() if made == "chimney" else pushed(0.02)
    slave, master = result.model.pairs
    after = [i for i in result.increments if i.fallen.any()]
    assert len(after) > 3
    for before, increment in pairwise(after):
        gone = np.append(increment.fallen, [False])
        touching = gone[np.minimum(slave, result.model.bodies)] | gone[np.minimum(master, result.model.bodies)]
        assert not increment.normal_force[touching].any()
        left = float(result.model.body_weight @ ~before.fallen)
        assert increment.horizontal_load == pytest.approx(left, rel=1e-9)


def test_a_run_that_is_resumed_in_the_middle_of_a_motion_has_the_same_increments(tmp_path):
    """Bit for bit, from the increment as it comes back from its file."""
    result = pushed(0.02)
    moving = [k for k, i in enumerate(result.increments) if i.moving]
    start = moving[len(moving) // 2]
    store = StateStore(tmp_path, "pin")
    store.append(result.increments[start])
    (stored,) = StateStore(tmp_path, "pin").increments()
    settings = SteppingSettings(final_displacement=0.1)
    with LinearSystem(result.model, MPI.COMM_SELF) as system:
        onward = Pushover(result.model, system, NewtonSettings(), settings).increments(stored)
        following = list(islice(onward, 8))
    for found, expected in zip(following, result.increments[start + 1 :], strict=False):
        assert (found.number, found.phase, found.moving) == (expected.number, expected.phase, expected.moving)
        assert found.displacement.tobytes() == expected.displacement.tobytes()
        assert found.normal_force.tobytes() == expected.normal_force.tobytes()
        assert found.base_shear == expected.base_shear
        assert found.load_multiplier == expected.load_multiplier


def test_base_shear_of_a_wall_that_has_lost_stones_is_that_of_what_is_left():
    """Pinnacles that overturn at b/h on a block that slides at 0.65: the live load acts on the block alone then."""
    blocks = [
        Block(0, rectangle(-2, -0.5, 10, 0.5), True, 25e3),
        Block(1, rectangle(0, 0, 6, 2), False, 25e3),
        *(Block(2 + k, rectangle(0.5 + k, 2, 0.3, height), False, 25e3) for k, height in enumerate(HEIGHTS)),
    ]
    analysis = analyse(find_joints(Wall("pinnacles", tuple(blocks), 0.4, 0.65), JointSettings()))
    left, lost = 25e3 * 0.4 * 6 * 2, 25e3 * 0.4 * 0.3 * sum(HEIGHTS)
    assert {stone for failure in analysis.local_failures for stone in failure.stones} == set(range(2, 7))
    assert analysis.horizontal_load == pytest.approx(left + lost)
    assert analysis.headline.load_multiplier == pytest.approx(0.65, rel=1e-6)
    assert analysis.headline.base_shear == pytest.approx(0.65 * left, rel=1e-6)
    assert analysis.bound.base_shear == pytest.approx(0.65 * left, rel=1e-6)
    assert analysis.associative.base_shear == pytest.approx((left + lost) * 0.3 / max(HEIGHTS), rel=1e-6)
    assert f"base shear {0.65 * left / 1e3:.2f} kN, of what is left" in answer_of_limit(analysis)


def pinnacles(*heights: float) -> Wall:
    """A block of 1 m x 2 m that carries pinnacles of 0.1 m width; 6 kN each metre of height."""
    blocks = [Block(0, rectangle(-1, -0.2, 3, 0.2), True, 20e3), Block(1, rectangle(0, 0, 1, 2), False, 20e3)]
    blocks += [Block(2 + k, rectangle(0.2 + 0.3 * k, 2, 0.1, height), False, 20e3) for k, height in enumerate(heights)]
    return Wall("pinnacles", tuple(blocks), 0.3, 0.6)


def per_block(*ids: int) -> LoadSettings:
    return LoadSettings(distribution="per_block", live=(LiveLoad(blocks=ids, force=1e3),))


def overturns(height: float) -> float:
    """Multiplier of 1 kN at the centroid of a pinnacle: W b = F h."""
    return 20e3 * 0.3 * 0.1 * height * 0.1 / (1e3 * height)


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize("loaded", [(1, 2), (2,)])
def test_a_light_stone_with_much_of_the_live_load_is_the_wall(loaded):
    """A pinnacle of 1.5 % of the dead load with half of the live load, or all of it: it overturns at F = W b / h, and
    that is what the wall bears of the loads that were asked for. No state exceeds the associative one."""
    wall, load = pinnacles(0.3), per_block(*loaded)
    assemblage = find_joints(wall, JointSettings())
    analysis = analyse(assemblage, loads=loads_on(wall, load))
    assert not analysis.local_failures
    assert analysis.headline.load_multiplier == pytest.approx(overturns(0.3), rel=1e-6)
    assert analysis.headline.load_multiplier <= analysis.associative.load_multiplier * (1 + 1e-6)
    for partition in (one_body_per_block(assemblage), macroblocks_of(assemblage, analysis)):
        found = push(assemblage, analysis, partition, load)
        assert found.capacity.peak_multiplier == pytest.approx(overturns(0.3), rel=5e-3)
        assert not found.summary.events
        assert found.summary.steps < 200


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_a_light_stone_with_little_of_the_live_load_is_local():
    """The same pinnacle with 1 kN beside 30 kN on the block, which overturns at W b / 2 over 30 kN x 1 m: 3.2 % of the
    live load and 1.5 % of the dead load come loose, and what is left bears what it bears."""
    wall = pinnacles(0.3)
    live = (LiveLoad(blocks=(1,), force=30e3), LiveLoad(blocks=(2,), force=1e3))
    assemblage = find_joints(wall, JointSettings())
    analysis = analyse(assemblage, loads=loads_on(wall, LoadSettings(distribution="per_block", live=live)))
    (failure,) = analysis.local_failures
    assert failure.stones == (2,)
    assert failure.share == pytest.approx(0.18 / 12.18)
    assert analysis.headline.load_multiplier == pytest.approx(12 * 0.5 / 30, rel=1e-6)


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_a_wall_from_which_all_live_load_has_fallen_ends():
    """Pinnacles of 1 kN and 0.9 kN, 53 % and 47 % of the live load, with 60 % called local by hand: of the two that
    overturn one after the other the first is more than the half that may be lost, and the wall's own failure."""
    live = (LiveLoad(blocks=(2,), force=1e3), LiveLoad(blocks=(3,), force=0.9e3))
    wall, load = pinnacles(0.3, 0.3), LoadSettings(distribution="per_block", live=live)
    assemblage = find_joints(wall, JointSettings())
    settings = replace(LimitAnalysisSettings(), local_share=0.6)
    analysis = analyse(assemblage, settings, loads_on(wall, load))
    assert analysis.headline.load_multiplier == pytest.approx(overturns(0.3), rel=1e-6)
    stepping = SteppingSettings(local_share=0.6)
    found = push(assemblage, analysis, one_body_per_block(assemblage), load, stepping=stepping)
    assert found.curve.static.load_multiplier.max() == pytest.approx(overturns(0.3), rel=5e-3)
    assert found.capacity.peak_base_shear == pytest.approx(1.9e3 * overturns(0.3), rel=5e-3)
    assert found.summary.steps < 500

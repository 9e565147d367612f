"""What `analyse` refuses, and how the answers are put together."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from orchestrator.basis.errors import CaseError, FallsError
from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.paper.linear_program import solve_gravity_lp
from orchestrator.limit_analysis.paper.yield_conditions import coulomb
from orchestrator.loads import DeadLoad, LoadSettings, loads_on
from orchestrator.masonry.interfaces import straight_interfaces
from orchestrator.masonry.joints import Assemblage, JointSettings, find_joints
from orchestrator.masonry.patterns import running_bond
from orchestrator.masonry.wall import Wall
from tests.support.walls import upright


def cantilever(overhang):
    """Block 12 on block 11 on a floor, the upper one displaced by `overhang` (m) of its 1 m."""
    blocks = (upright(10, -2, -1, 6, 1, fixed=True), upright(11, 0, 0, 1, 0.5), upright(12, overhang, 0.5, 1, 0.5))
    start, end = np.array([[1.0, 0.0], [1.0, 0.5]]), np.array([[0.0, 0.0], [overhang, 0.5]])
    joints = straight_interfaces(np.array([0, 1]), np.array([1, 2]), start, end, 1.0, np.full(2, 0.7))
    return Assemblage(Wall("cantilever", blocks, 1.0, 0.7), joints)


def test_overhang_of_less_than_half_a_block_stands():
    """lambda = (0.5 - overhang)/0.25 for the upper block about the lower one's edge."""
    found = analyse(cantilever(0.4))
    assert found.associative.load_multiplier == pytest.approx(0.1 / 0.25, abs=1e-9)
    assert found.weight == pytest.approx(20e3)
    assert found.non_associative_range == pytest.approx((0.4, 0.4), abs=1e-8)


@pytest.mark.parametrize("modulus", [-1.0, 0.0, np.nan, "soft"])
def test_an_elastic_modulus_that_no_stone_has_is_refused(modulus):
    with pytest.raises(CaseError, match=r"^elastic_modulus: "):
        analyse(cantilever(0.4), elastic_modulus=modulus)


def test_arguments_of_another_kind_are_told_which_is_expected():
    wall = cantilever(0.4)
    loads = loads_on(wall.wall)
    with pytest.raises(
        CaseError, match=r"settings: Loads was given, LimitAnalysisSettings is expected; write analyse\("
    ):
        analyse(wall, loads)
    with pytest.raises(CaseError, match=r"loads: LoadSettings was given, Loads is expected; .*loads=loads_on"):
        analyse(wall, loads=LoadSettings())


def test_overhang_of_more_than_half_a_block_falls_and_is_named():
    with pytest.raises(CaseError) as refused:
        analyse(cantilever(0.6))
    assert refused.value.key == "wall"
    assert "cannot stand under its own weight: block 12 would move, unless held by a force of " in refused.value.problem
    assert "11" not in refused.value.problem.split("move")[0]


@pytest.mark.parametrize(
    ("overhang", "key", "says"),
    [
        (0.4, "load.dead", "the wall stands under its own weight, but not under this dead load too: block 12 would "),
        (0.6, "wall", "cannot stand under its own weight: block 12 would move, unless held by a force of "),
    ],
)
def test_a_wall_that_falls_under_an_extra_dead_load_falls_under_its_own_weight_only_where_it_does(overhang, key, says):
    """10 kN stand 0.1 m inside the edge of the block below, and 5 kN are 0.3 m outside; or 10 kN stand 0.1 m outside
    and 1 kN far inside."""
    at = (overhang + 0.9, 0.8) if overhang < 0.5 else (overhang + 0.1, 0.8)
    load = LoadSettings(dead=(DeadLoad((12,), force=5e3 if overhang < 0.5 else 1e3, at=at),))
    wall = cantilever(overhang)
    with pytest.raises(CaseError) as refused:
        analyse(wall, loads=loads_on(wall.wall, load))
    assert refused.value.key == key
    assert refused.value.problem.startswith(says)


def test_marginal_overhang_is_on_the_verge():
    """Centroid exactly over the edge: lambda = 0, and what rounding makes of it is no answer."""
    with pytest.raises(FallsError, match="on the verge of collapse under its dead load"):
        analyse(cantilever(0.5))


@pytest.mark.parametrize("beyond", [1e-4, 1e-5])
def test_overhang_beyond_half_a_block_by_a_hair_falls(beyond):
    """What is missing is W beyond / (block length), 1.4e-5 block weights for 1e-5 m: above what passes as rounding."""
    with pytest.raises(CaseError, match="block 12 would move"):
        analyse(cantilever(0.5 + beyond))


@pytest.mark.parametrize(("courses", "stones"), [(9, 13), (30, 33)])
def test_nothing_is_missing_in_walls_that_stand_however_large(courses, stones):
    """Rounding only: 1e-10 is 1e4 times less than what passes."""
    assemblage = find_joints(running_bond(stones, courses), JointSettings())
    equilibrium = assemble_equilibrium(assemblage)
    missing, _ = solve_gravity_lp(equilibrium, coulomb(assemblage))
    assert len(equilibrium.free_blocks) > 100
    assert missing < 1e-10


def test_wedged_block_is_refused_in_plain_words():
    blocks = (upright(0, -1, 0, 1, 1, fixed=True), upright(1, 0, 0, 1, 1), upright(2, 1, 0, 1, 1, fixed=True))
    floor = upright(3, -1, -1, 3, 1, fixed=True)
    i, j = np.array([[0, 1, 3], [1, 2, 1]])
    start, end = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0]]), np.array([[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]])
    joints = straight_interfaces(i, j, start, end, 1.0, np.full(3, 0.7))
    wedged = Assemblage(Wall("wedged", (*blocks, floor), 1.0, 0.7), joints)
    with pytest.raises(CaseError, match="no live load in this direction brings it down while sliding dilates"):
        analyse(wedged)


def test_input_is_left_alone_and_result_is_frozen_and_can_be_sent_to_other_ranks():
    assemblage = cantilever(0.2)
    found = analyse(assemblage)
    with pytest.raises(ValueError, match="read-only"):
        found.associative.joint_forces[0, 0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        found.associative.mechanism.velocities[0, 0] = 1.0
    copy = pickle.loads(pickle.dumps(found))
    assert copy.associative.load_multiplier == found.associative.load_multiplier
    assert analyse(assemblage).sequence.load_multiplier == found.sequence.load_multiplier


def test_very_large_walls_have_the_same_headline_without_the_papers_value():
    found = analyse(cantilever(0.2), LimitAnalysisSettings(search_blocks=1, sequence_blocks=1))
    assert found.sequence is None
    assert found.headline is found.path
    assert found.headline.load_multiplier == analyse(cantilever(0.2)).headline.load_multiplier
    assert found.remarks[-1] == "the paper's sequence left out for so many blocks, more than 1"


def test_records_tell_every_linear_program():
    settings = LimitAnalysisSettings(seed_cohesions=(1e-2, 1e-5))
    found = analyse(cantilever(0.2), settings)
    assert len(found.associative.records) == 1
    assert sorted({record.parameter for record in found.sequence.records}) == [0.0, 1e-5, 1e-2]
    assert all(
        record.status in ("Solved", "AlmostSolved") and record.iterations > 0 for record in found.sequence.records
    )


def test_a_sequence_whose_power_does_not_balance_is_no_answer():
    """No fixed point balances to 1e-30, so this asks for the refusal."""
    found = analyse(cantilever(0.2), LimitAnalysisSettings(power_tolerance=1e-30))
    assert found.sequence is None
    assert "is out of balance" in found.remarks[-1]


def test_headline_and_range_fall_back_when_an_answer_is_missing():
    found = analyse(cantilever(0.2))
    assert found.headline is found.path
    without = replace(found, path=None)
    assert without.headline is found.sequence
    third = replace(without, sequence=None)
    assert third.headline is found.lowest
    astray = replace(found, path=replace(found.path, converged=False))
    assert astray.headline is astray.path, "the last rest"
    nothing = replace(third, lowest=None, highest=None)
    assert nothing.headline is found.associative
    assert nothing.non_associative_range is None

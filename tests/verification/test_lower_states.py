"""Search for other states beside the one that loading meets: validity, lowest and highest, mirror images."""

from __future__ import annotations

import numpy as np
import pytest
from shapely.geometry import Polygon

from orchestrator import one_body_per_block, push
from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.paper.yield_conditions import coulomb
from orchestrator.limit_analysis.validation import validate
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from tests.support.limit_analysis_cases import analysed, answers, case, mirrored
from tests.support.walls import of_file

NAMES = [
    "block_on_10deg_slope", "ferris_tinloi_wall1", "ferris_tinloi_wall3", "ferris_tinloi_wall4", "ferris_tinloi_wall6",
    "orduna_panel_set13", "tower_5_blocks", "tower_slide_5_blocks",
]  # fmt: skip


@pytest.mark.parametrize("rule", ["sequence", "path", "lowest"])
@pytest.mark.parametrize("name", NAMES)
def test_every_state_reported_is_valid(name, rule):
    wall = case(name)
    found = validate(wall, assemble_equilibrium(wall), coulomb(wall), getattr(answers(name), rule))
    assert found.complaints == ()


@pytest.mark.parametrize("name", NAMES)
def test_lowest_and_highest_enclose_every_other_and_none_exceeds_the_bound(name):
    found = answers(name)
    for state in (found.sequence, found.path):
        assert found.lowest.load_multiplier <= state.load_multiplier + 1e-5
        assert found.highest >= state.load_multiplier - 1e-5
    assert found.highest <= found.associative.load_multiplier + 1e-6
    assert found.non_associative_range == pytest.approx((found.lowest.load_multiplier, found.highest), abs=1e-5)


@pytest.mark.parametrize(("seed", "friction"), [(1, 0.75), (2, 0.4)])
def test_mirrored_irregular_wall_has_the_same_headline_and_range(seed, friction):
    wall = find_joints(irregular_courses(IrregularCourses(1.2, 1.0, friction=friction, seed=seed)), JointSettings())
    there, behind = analyse(wall), analysed(mirrored(wall), -1)
    assert behind.headline.load_multiplier == pytest.approx(there.headline.load_multiplier, abs=1e-6)
    assert behind.non_associative_range == pytest.approx(there.non_associative_range, abs=1e-5)


def test_a_long_motion_ends_in_a_valid_state_and_its_peak_in_large_displacements_is_that_of_micro_fe():
    """Random wall 9 of docs/studies. Undisplaced it bears 1.3 % more than micro-FE, whose blocks have moved: 2.0 % more
    than rigid blocks that have, so that last digits decide which of the two is the headline."""
    pattern = IrregularCourses(1.4, 2.8, openings=((0.475, 0.925, 1.0, 1.7),), seed=9)
    wall = find_joints(irregular_courses(pattern), JointSettings())
    found = analyse(wall, LimitAnalysisSettings(large_displacements=False))
    state = found.headline
    assert state is found.path
    assert state.converged
    assert validate(wall, assemble_equilibrium(wall), coulomb(wall), state).complaints == ()
    assert state.load_multiplier == pytest.approx(found.last_rest, rel=0.01)
    peak = analyse(wall).rigid_curve[:, 1].max()
    assert peak == pytest.approx(0.2803, rel=0.01), "peak of micro-FE, run 14 of docs/studies/macroblock_peaks.csv"


def test_a_last_rest_is_closed_by_a_valid_state_beside_it_and_the_answer_says_so():
    """In a long motion no forces are found that a mechanism asks for."""
    pattern = IrregularCourses(1.0, 1.4, friction=0.6, seed=1)
    wall = find_joints(irregular_courses(pattern), JointSettings())
    loads = loads_on(wall.wall, LoadSettings("-x"))
    found = analyse(wall, LimitAnalysisSettings(large_displacements=False), loads)
    state = found.headline
    assert state is found.path
    assert state.converged
    assert validate(wall, assemble_equilibrium(wall, loads), coulomb(wall), state).complaints == ()
    assert state.load_multiplier == pytest.approx(found.last_rest, rel=0.01)
    assert state.flow_rule in ("descent", "sequence")
    assert any(remark.startswith("the path was not followed to its end: state closed by ") for remark in found.remarks)


def test_a_column_that_the_stone_beside_it_holds_is_found_where_it_overturns_by_itself():
    """Rubble with a column of five stones at its edge. Loading meets 0.226, as a stone that leans on the column goes
    down with it; the column alone overturns about its lowest corner, and finite elements come to that."""
    wall = of_file("rubble_46_stones")
    column = [Polygon(wall.wall.blocks[block].polygon) for block in (4, 19, 21, 34, 41)]
    edge = np.array(max((point for stone in column for point in stone.exterior.coords), key=lambda p: (p[0], -p[1])))
    arms = np.abs([np.array(stone.centroid.coords[0]) - edge for stone in column])
    alone = np.divide(*(np.array([stone.area for stone in column]) @ arms))
    found = analyse(wall)
    assert found.headline.load_multiplier > 1.3 * alone
    assert found.lowest.load_multiplier == pytest.approx(alone, rel=1e-6)
    assert found.lowest.converged
    curve = push(wall, found, one_body_per_block(wall)).curve.static
    multiplier, moved = curve.load_multiplier, curve.control_displacement_m
    peak = int(np.argmax(multiplier))
    assert multiplier[peak] < 0.8 * found.headline.load_multiplier
    assert multiplier[moved > 1.1 * moved[peak]].max() == pytest.approx(alone, rel=0.03), "where it comes to from there"

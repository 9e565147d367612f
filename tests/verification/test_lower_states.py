"""Complementarity program and search for lower states: validity, published values found again, mirror images."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.joints import JointSettings, find_joints
from orchestrator.limit_analysis import analyse
from orchestrator.limit_analysis.complementarity import solve_complementarity
from orchestrator.limit_analysis.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.lower_states import TwoPrograms, complementary_start, descent, lowest, starts
from orchestrator.limit_analysis.validation import validate
from orchestrator.limit_analysis.yield_conditions import coulomb
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from tests.support.limit_analysis_cases import answers, assemblage_of, box, case, mirrored

NAMES = [
    "block_on_10deg_slope", "ferris_tinloi_wall1", "ferris_tinloi_wall3", "ferris_tinloi_wall4", "ferris_tinloi_wall6",
    "orduna_panel_set13", "tower_5_blocks", "tower_slide_5_blocks",
]  # fmt: skip
RULES = ("sequence", "dilation_shift", "complementarity", "lowest")


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("name", NAMES)
def test_every_state_reported_is_valid(name, rule):
    wall = case(name)
    found = validate(wall, assemble_equilibrium(wall, 1), coulomb(wall), getattr(answers(name), rule))
    assert found.complaints == ()


@pytest.mark.parametrize("name", NAMES)
def test_lowest_is_not_above_any_other(name):
    found = answers(name)
    others = [getattr(found, rule).load_multiplier for rule in RULES[:3]]
    assert found.lowest.load_multiplier <= min(others) + 1e-5
    assert found.non_associative_range[0] == pytest.approx(found.lowest.load_multiplier, abs=1e-5)
    assert found.lowest.load_multiplier <= found.associative.load_multiplier + 1e-9


def test_published_state_of_wall_4_without_the_sequence():
    """0.264 (Ferris and Tin-Loi 2001): equal first forces lead to 0.307, larger ones on the load's side to this."""
    wall = case("ferris_tinloi_wall4")
    equilibrium, friction = assemble_equilibrium(wall, 1), coulomb(wall)
    programs = TwoPrograms(equilibrium, friction)
    found = []
    for start in starts(wall, 1, 2):
        _, slip = complementary_start(programs, equilibrium, friction, start)
        found.append(lowest(descent(programs, slip)).forces.load_multiplier)
    assert found == pytest.approx([0.3070, 0.264], abs=5e-4)


def test_complementarity_of_one_block():
    """min(mu, b/h) for a block of 0.5 x 1 m and of 1 x 0.5 m; cohesion c adds c b/W to the sliding one."""
    slender = assemblage_of([box(-3, -1, 6, 1), box(0, 0, 0.5, 1.0)])
    flat = assemblage_of([box(-3, -1, 6, 1), box(0, 0, 1.0, 0.5)])
    for wall, expected in ((slender, 0.5), (flat, 0.65)):
        found = solve_complementarity(assemble_equilibrium(wall, 1), coulomb(wall))
        assert found.converged
        assert found.load_multiplier == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(("seed", "friction"), [(1, 0.75), (2, 0.4)])
def test_mirrored_irregular_wall_has_the_same_headline_and_complementarity(seed, friction):
    wall = find_joints(irregular_courses(IrregularCourses(1.2, 1.0, friction=friction, seed=seed)), JointSettings())
    there, behind = analyse(wall), analyse(mirrored(wall), load_direction=-1)
    assert behind.headline.load_multiplier == pytest.approx(there.headline.load_multiplier, abs=1e-6)
    assert behind.complementarity.load_multiplier == pytest.approx(there.complementarity.load_multiplier, abs=1e-5)
    assert np.isfinite(there.lowest.load_multiplier)

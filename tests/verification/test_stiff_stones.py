"""Rigid blocks of ever stiffer stones: how a mechanism moves is a matter of geometry, not of the modulus.

What stones give way by before they let go falls with their modulus. From there on blocks of any modulus go the way of
rigid ones, along which the multiplier falls as second-order work says (softening_slope.py); within so long a step of
prescribed displacements friction leaves more than one equilibrium, and the others bear up to 15 % more.
"""

from __future__ import annotations

from dataclasses import replace

import pytest

from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.limit_analysis.gravity import associative_optimum, problem_of
from orchestrator.limit_analysis.search.rigid_pushover import rigid_pushover
from orchestrator.limit_analysis.softening_slope import softening_slope
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from tests.support.limit_analysis_cases import transformed

LOAD = LoadSettings("-x")
DRAWN_ALONE = LimitAnalysisSettings(search_blocks=1, sequence_blocks=1, large_displacements=False)
MODULI = (3.5e9, 35e9, 3.5e12)


def courses_of_22():
    return find_joints(irregular_courses(IrregularCourses(0.8, 0.6, seed=1)), JointSettings())


@pytest.mark.parametrize("modulus", MODULI)
def test_stones_of_any_modulus_move_as_rigid_ones_do(modulus):
    assemblage = courses_of_22()
    loads = loads_on(assemblage.wall, LOAD)
    drawn = analyse(assemblage, DRAWN_ALONE, loads).headline
    problem = replace(problem_of(assemblage, loads), elastic_modulus=modulus)
    found = rigid_pushover(problem, associative_optimum(problem).load_multiplier)
    moves = (found.displacement > 5e-6) & (found.displacement < 2e-4)
    falls = softening_slope(assemblage, loads, drawn) * found.displacement[moves]
    assert moves.sum() >= 5
    assert found.multiplier[moves] == pytest.approx(drawn.load_multiplier + falls, rel=2e-3)
    assert found.peak == pytest.approx(drawn.load_multiplier, rel=1e-5)


@pytest.mark.parametrize(("modulus", "size"), [(modulus, 1.0) for modulus in MODULI] + [(3.5e9, 0.01)])
def test_the_headline_of_stiff_or_small_stones_is_the_state_that_they_meet_as_drawn(modulus, size):
    """Before, 0.5676 of 35 GPa and for the wall a hundredth as large, which is as stiff for its weight."""
    assemblage = transformed(courses_of_22(), lambda polygon: size * polygon)
    found = analyse(assemblage, loads=loads_on(assemblage.wall, LOAD), elastic_modulus=modulus)
    assert found.headline.load_multiplier == pytest.approx(0.49544, rel=1e-4)
    assert found.interval is None

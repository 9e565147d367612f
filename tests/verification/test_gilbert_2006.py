"""Gilbert, Casapulla, Ahmed 2006 (Computers & Structures 84, 873-887): the sequence for non-associative friction.

Every block file in tests/data with the values it carries; the arch on the two sides of its least thickness; the wall
that has no solution by the sequence.
"""

from __future__ import annotations

import pytest

from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from tests.support.limit_analysis_cases import FOLDERS, answers, case, description

NAMES = sorted(path.stem for folder in FOLDERS for path in folder.glob("*.json") if "expected" in path.read_text())
WITH_ASSOCIATIVE = [name for name in NAMES if description(name)["expected"].get("associative")]
WITH_SEQUENCE = [name for name in NAMES if description(name)["expected"].get("non_associative")]


def test_all_files_are_found():
    assert len(NAMES) == 15
    assert len(WITH_ASSOCIATIVE) == 13
    assert len(WITH_SEQUENCE) == 12


@pytest.mark.parametrize("name", WITH_ASSOCIATIVE)
def test_associative_value_of_file(name):
    expected = description(name)["expected"]["associative"]
    assert answers(name).associative.load_multiplier == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("name", WITH_SEQUENCE)
def test_sequence_value_of_file(name):
    """The files give five digits; 1e-4 as for the associative value."""
    expected = description(name)["expected"]["non_associative"]
    assert answers(name).sequence.load_multiplier == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("name", WITH_SEQUENCE)
def test_non_associative_values_do_not_exceed_the_associative(name):
    """The associative optimum bounds every statically admissible state (lower-bound theorem)."""
    found = answers(name)
    highest = max(found.sequence.load_multiplier, found.path.load_multiplier, found.highest)
    assert highest <= found.associative.load_multiplier + 1e-9


def test_arch_below_its_least_thickness_is_refused_naming_blocks():
    with pytest.raises(CaseError) as refused:
        analyse(case("arch27_t0106"))
    assert refused.value.key == "wall"
    assert "cannot stand under its own weight: blocks 0, 1, 2" in refused.value.problem
    assert refused.value.remedy


def test_arch_above_its_least_thickness_stands():
    assert 0.0 < answers("arch27_t0107").associative.load_multiplier < 0.01


def test_keystone_wall_has_no_solution_by_the_sequence_and_says_so():
    found = answers("keystone_wall_13x9")
    assert found.sequence is None
    (remark,) = [remark for remark in found.remarks if "the paper's sequence found no state" in remark]
    assert "no joint forces satisfy equilibrium and friction" in remark
    assert found.share_lost == pytest.approx(0.0187, abs=1e-4), "the stones that hang come loose first"


def test_seeds_hardly_matter_on_wall_4():
    """Any seed schedule that ends low enough must end on the same state (docs/theory.md, section 3; six digits)."""
    other = analyse(case("ferris_tinloi_wall4"), LimitAnalysisSettings(seed_cohesions=(0.2, 3e-3, 1e-5)))
    assert other.sequence.load_multiplier == pytest.approx(
        answers("ferris_tinloi_wall4").sequence.load_multiplier, abs=1e-6
    )


def test_a_sequence_cut_short_is_no_answer():
    settings = LimitAnalysisSettings(minimum_iterations=2, maximum_iterations=2, seed_cohesions=(1e-1,))
    found = analyse(case("ferris_tinloi_wall3"), settings)
    assert found.sequence is None
    assert "not settled after 2 linear programs" in found.remarks[-1]

"""What is said of a wall that is pushed in large displacements."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from orchestrator.limit_analysis.paper.limit_state import is_of_geometry
from orchestrator.limit_analysis.remarks import answer_words, geometry_words, mechanism_words, paper_words
from tests.support.limit_analysis_cases import FLOOR, assemblage_of, box

FAR = np.array([[0.0, 0.0], [1e-6, 0.01], [2e-4, 0.20], [3e-4, 0.15]])
"""displacements in m and multipliers: twenty elastic displacements have been left behind at the peak by far"""
NEAR = np.array([[0.0, 0.0], [1e-6, 0.01], [2e-5, 0.20], [2.1e-5, 0.04]])
"""the peak is met where joints give way elastically, and lost at once"""


@pytest.mark.parametrize(
    ("curve", "drawn", "shows"),
    [(FAR, 0.2, True), (NEAR, 0.2, False), (NEAR, 0.201, False), (NEAR, 0.21, True)],
)
def test_geometry_shows_where_a_wall_has_moved_far_or_bears_less(curve, drawn, shows):
    assert is_of_geometry(curve, drawn) == shows


def met(curve, is_past=True, drawn=0.19):
    """A wall that was pushed along a curve; in small displacements it was at rest up to `drawn`."""
    pushed = SimpleNamespace(curve=curve, multiplier=curve[:, 1], peak=float(curve[:, 1].max()), is_past=is_past)
    state = SimpleNamespace(load_multiplier=pushed.peak, converged=False, flow_rule="last_rest")
    path = SimpleNamespace(last_rest=drawn, state=SimpleNamespace(load_multiplier=drawn), soft_from=None, carries=None)
    part = SimpleNamespace(assemblage=assemblage_of([FLOOR, box(0.0, 0.0, 0.5, 1.0)]), elastic_modulus=3.5e9)
    return SimpleNamespace(
        pushed=pushed, state=state, path=path, part=part, geometry_decides=True, is_unloaded=False, spread=None,
        multiplier=pushed.peak, displaced_rests=True,
    )  # fmt: skip


def test_a_peak_that_is_lost_before_anything_has_moved_is_not_put_down_to_geometry():
    snaps = met(NEAR)
    assert list(answer_words(snaps)) == ["rigid blocks in large displacements bear 0.2000, in small ones 0.1900"]
    assert next(mechanism_words(snaps)) == "at rest up to 0.2000; as it moves what it bears falls to 0.0400 or less"
    (said,) = answer_words(met(FAR))
    assert said == "geometry decides: rigid blocks in large displacements bear 0.2000, in small ones 0.1900"
    for one in (met(FAR), met(NEAR, is_past=False)):
        assert not any("falls to" in words for words in mechanism_words(one))


def test_where_geometry_does_not_show_the_modulus_is_no_matter():
    assert not any("elastic modulus" in words for words in geometry_words(met(NEAR)))
    assert any("elastic modulus" in words for words in geometry_words(met(FAR)))


@pytest.mark.parametrize(
    ("paper", "known", "told"),
    [(0.066, (0.146, 0.2), True), (0.15, (0.146, 0.2), False), (0.066, (0.05, 0.2), False), (0.066, None, False)],
)
def test_a_paper_s_value_below_all_that_loading_reaches_is_told_as_that(paper, known, told):
    """Of 0.1046 met by loading in large displacements; a path on other joints may end lower than the paper's value."""
    paper, headline = (SimpleNamespace(load_multiplier=value) for value in (paper, 0.1046))
    answer = SimpleNamespace(
        sequence=paper, headline=headline, path=headline, non_associative_range=known, local_failures=()
    )
    said = "loading was not found to come to the paper's value 0.0660, a state of other forces between the stones"
    assert list(paper_words(None, None, answer, 0.05)) == [said] * told

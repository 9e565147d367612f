"""Two parts of an analysis at the same time: both results, the first's error first."""

from __future__ import annotations

from threading import Barrier

import pytest

from orchestrator.limit_analysis.side_by_side import side_by_side


def raising(text):
    raise ValueError(text)


def test_both_run_at_the_same_time():
    meeting = Barrier(2, timeout=10.0)  # broken unless both come to it
    assert sorted(side_by_side(meeting.wait, meeting.wait)) == [0, 1]


def test_each_result_is_in_its_place():
    assert side_by_side(lambda: "first", lambda: 2) == ("first", 2)


@pytest.mark.parametrize(
    ("first", "second", "message"),
    [
        (lambda: raising("of the first"), lambda: raising("of the second"), "of the first"),
        (lambda: 1, lambda: raising("of the second"), "of the second"),
    ],
)
def test_the_first_error_is_raised(first, second, message):
    with pytest.raises(ValueError, match=message):
        side_by_side(first, second)

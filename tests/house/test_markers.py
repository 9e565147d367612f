"""`make quick` leaves out what is slow by itself, and what would have to wait for a fixture of something slow."""

from __future__ import annotations

import pytest

from tests.conftest import when_alone


def test_who_shares_a_fixture_pays_for_it_where_the_first_is_left_out():
    """The first makes the run that the second looks at; the third looks at another, the fourth at none."""
    assert when_alone([40.0, 0.1, 0.2, 0.3], [{"run"}, {"run"}, {"other run"}, ()]) == [40.0, 40.0, 0.2, 0.3]


def test_a_slow_test_that_was_not_first_did_not_pay_for_the_fixture():
    assert when_alone([0.1, 40.0, 0.2], [{"wall"}, {"wall"}, {"wall"}]) == [0.1, 40.0, 0.2]


@pytest.fixture(scope="module")
def folder():
    return 1


def test_fixtures_of_a_module_are_seen(request, folder):
    from tests.conftest import _shared_fixtures

    assert _shared_fixtures(request.node) == {("folder", "tests/house/test_markers.py", "None")}

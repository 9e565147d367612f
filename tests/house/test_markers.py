"""`make quick` leaves out what is slow alone: by itself, or by what it shares with others, whoever comes first.

`make test` leaves out what is long.
"""

from __future__ import annotations

import ast

import pytest

from tests.conftest import SLOW, shared_fixtures, stored
from tests.support.paths import PROJECT
from tests.support.seconds import Ledger

QUICK = 70.0
"""CPU seconds of all fast tests; two processes that collect them take 15 more, so that two processors need 43"""


def test_the_fast_tests_take_less_than_a_minute_together():
    alone = [seconds.alone for seconds in stored().values() if seconds.alone <= SLOW]
    assert len(alone) > 500
    assert sum(alone) < QUICK, "lower SLOW, or look at what has grown: pytest --store-seconds FILE"


def test_every_test_in_the_table_is_there():
    known: dict[str, set[str]] = {}
    for test in stored():
        file, name = test.split("::")
        known.setdefault(file, set()).add(name)
    for file, names in known.items():
        body = ast.parse((PROJECT / file).read_text()).body
        assert names <= {part.name for part in body if isinstance(part, ast.FunctionDef)}, file


class Clock:
    """A clock that stands still but for what is worked."""

    now = 0.0

    def __call__(self) -> float:
        return self.now

    def work(self, seconds: float) -> None:
        self.now += seconds


def test_a_test_that_comes_first_is_not_charged_twice_and_one_that_comes_later_is_charged():
    clock = Clock()
    ledger = Ledger(clock)
    with ledger.measuring() as first:
        clock.work(1.0)
        with ledger.making("run"):
            clock.work(40.0)
    with ledger.measuring() as second:
        clock.work(0.25)
        ledger.use("run")
    with ledger.measuring() as third:
        clock.work(2.0)
    assert [span.seconds for span in (first, second, third)] == [1.0, 0.25, 2.0]
    assert [span.used for span in (first, second, third)] == [{"run"}, {"run"}, set()]
    assert ledger.seconds == {"run": 40.0}


def test_what_is_made_of_something_shared_is_charged_with_that_too():
    """A curve from a wall: the wall was there before, a second wall is made on the way."""
    clock = Clock()
    ledger = Ledger(clock)
    with ledger.measuring(), ledger.making("wall"):
        clock.work(3.0)
    with ledger.measuring(), ledger.making("curve"):
        ledger.use("wall")
        clock.work(5.0)
        with ledger.making("other wall"):
            clock.work(7.0)
    with ledger.measuring() as later:
        ledger.use("curve")
        ledger.use("what nobody made")
    assert later.used == {"wall", "curve", "other wall"}
    assert ledger.seconds == {"wall": 3.0, "curve": 5.0, "other wall": 7.0}


@pytest.fixture(scope="module")
def folder():
    return 1


def test_fixtures_of_a_module_are_seen(request, folder):
    assert shared_fixtures(request.node) == {("folder", "tests/house/test_markers.py", "None")}

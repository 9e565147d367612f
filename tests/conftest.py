"""Markers, and the order of files: what takes long comes first.

    mpi     its file starts processes by mpirun (tests.support.ranks or .killing)
    fe      its file uses the finite elements (orchestrator.pushover)
    slow    it took more than SLOW CPU seconds when seconds.csv was written, or shares a fixture with one that did
    fast    it took less, or was not there: `make quick`

`pytest --store-seconds`, in one process, writes what its tests took, with the processes they started, into seconds.csv.
"""

from __future__ import annotations

import csv
import os
from collections import Counter
from collections.abc import Collection, Hashable, Iterator, Sequence
from pathlib import Path

import pytest

TABLE = Path(__file__).parent / "seconds.csv"
SLOW = 1.0
"""CPU seconds above which a test is slow, and is listed in seconds.csv"""
WRITTEN: dict[str, float] = {}


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--store-seconds", action="store_true", help="write CPU seconds of these tests into seconds.csv")


def pytest_configure(config: pytest.Config) -> None:
    for line in (__doc__ or "").splitlines()[2:6]:
        name, about = line.split(maxsplit=1)
        config.addinivalue_line("markers", f"{name}: {about}")


def stored() -> dict[str, float]:
    """Return the CPU seconds of slow tests by their id."""
    if not TABLE.exists():
        return {}
    with TABLE.open(newline="") as file:
        return {test: float(seconds) for test, seconds in csv.reader(file)}


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests; put the files that take longest first, so that the last ones to be shared out are short."""
    seconds = stored()
    of_file: Counter[Path] = Counter()
    own = [seconds.get(item.nodeid, 0.0) for item in items]
    for item, spent, alone in zip(items, own, when_alone(own, [_shared_fixtures(item) for item in items]), strict=True):
        of_file[item.path] += spent
        for name in _markers(item, alone):
            item.add_marker(name)
    items.sort(key=lambda item: -of_file[item.path])


def when_alone(seconds: Sequence[float], shared: Sequence[Collection[Hashable]]) -> list[float]:
    """Return what each test may take where the others are left out: the first that uses a fixture has paid for all."""
    paid: dict[Hashable, float] = {}
    for spent, fixtures in zip(seconds, shared, strict=True):
        for fixture in fixtures:
            paid.setdefault(fixture, spent)
    return [max([spent, *(paid[one] for one in used)]) for spent, used in zip(seconds, shared, strict=True)]


def _shared_fixtures(item: pytest.Item) -> set[Hashable]:
    """Return the fixtures of these tests that a test shares with others, each with its parameter."""
    assert isinstance(item, pytest.Function)
    parameters = item.callspec.params if hasattr(item, "callspec") else {}
    found = {name: known[-1] for name, known in item._fixtureinfo.name2fixturedefs.items()}
    return {
        (name, one.baseid, repr(parameters.get(name)))
        for name, one in found.items()
        if one.baseid and one.scope != "function"
    }


def _markers(item: pytest.Item, seconds: float) -> list[str]:
    module = item.getparent(pytest.Module)
    assert module is not None
    used = {getattr(value, "__module__", None) or "" for value in vars(module.obj).values()}
    found = ["slow" if seconds > SLOW else "fast"]
    found += ["mpi"] * bool(used & {"tests.support.ranks", "tests.support.killing"})
    return found + ["fe"] * any(name.startswith(("orchestrator.pushover.", "tests.support.pushover")) for name in used)


def cpu_seconds() -> float:
    """Return the CPU seconds of this process and of those it has waited for."""
    spent = os.times()
    return spent.user + spent.system + spent.children_user + spent.children_system


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    before = cpu_seconds()
    result = yield
    WRITTEN[item.nodeid] = cpu_seconds() - before
    return result


def pytest_sessionfinish(session: pytest.Session) -> None:
    if not session.config.getoption("--store-seconds"):
        return
    found = {test: spent for test, spent in (stored() | WRITTEN).items() if spent > SLOW}
    with TABLE.open("w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows((test, f"{found[test]:.1f}") for test in sorted(found))

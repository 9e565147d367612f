"""Markers, and the order of files: what takes long comes first, and files that use several processes go one by one.

    mpi     its file starts processes by mpirun (tests.support.ranks or .killing)
    fe      its file uses the finite elements (orchestrator.pushover)
    slow    alone it takes more than SLOW CPU seconds, or seconds.csv does not know it
    fast    alone it takes no more than that: `make quick`
    long    alone it takes more than LONG CPU seconds, and starts no ranks: `make long`, which `make test` leaves out

`pytest --store-seconds`, in one process, writes what its tests took, with the processes they started, into seconds.csv:
all cases of a test together, and what that would be without any other test (tests.support.seconds).
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Hashable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import hypothesis
import pytest

from tests.support.seconds import LEDGER
from tests.support.undrawn import undrawn

TABLE = Path(__file__).parent / "seconds.csv"
SLOW = 0.25
"""CPU seconds of all cases of a fast test together at the most; with 0.35 `make quick` lasts a minute"""
LONG = 1.0
"""CPU seconds of a test that `make test` has at the most; ranks are in it whatever they take"""


hypothesis.settings.register_profile("busy", deadline=None)  # 200 ms are soon over where other work runs beside
hypothesis.settings.load_profile("busy")


class Seconds(NamedTuple):
    """CPU seconds of all cases of a test: its own, and with every fixture and value that it shares with others."""

    own: float
    alone: float


@dataclass
class Measured:
    """What the cases of a test took so far, and the shared values that they used."""

    own: float = 0.0
    used: set[Hashable] = field(default_factory=set)


MEASURED: dict[str, Measured] = {}


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a command writes without --output lands beside no other test's."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def without_pictures() -> Iterator[None]:
    """Of a file no test of which looks at a picture (tests.support.undrawn)."""
    with undrawn():
        yield


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--store-seconds", action="store_true", help="write CPU seconds of these tests into seconds.csv")


def pytest_configure(config: pytest.Config) -> None:
    for line in (__doc__ or "").splitlines()[2:7]:
        name, about = line.split(maxsplit=1)
        config.addinivalue_line("markers", f"{name}: {about}")


def stored() -> dict[str, Seconds]:
    """Return what tests took, by file and name."""
    with TABLE.open(newline="") as file:
        return {row["test"]: Seconds(float(row["own"]), float(row["alone"])) for row in csv.DictReader(file)}


def test_of(item: pytest.Item) -> str:
    """Return file and name of a test, without the case."""
    return item.nodeid.split("[")[0]


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests; put the files that take longest first, so that the last ones to be shared out are short."""
    known = stored()
    of_file: Counter[str] = Counter()
    for test, seconds in known.items():
        of_file[test.split("::")[0]] += seconds.own
    for item in items:
        seconds = known.get(test_of(item))
        item.add_marker("fast" if seconds and seconds.alone <= SLOW else "slow")
        names = _rooms_used(item)
        if seconds and seconds.alone > LONG and "mpi" not in names:
            item.add_marker("long")
        for name in names:
            item.add_marker(name)
        # ranks that wait for each other keep a processor busy: two such tests side by side take several times as long
        item.add_marker(pytest.mark.xdist_group("mpi" if "mpi" in names else item.nodeid.split("::")[0]))
    items.sort(key=lambda item: -of_file[item.nodeid.split("::")[0]])


def _rooms_used(item: pytest.Item) -> list[str]:
    module = item.getparent(pytest.Module)
    assert module is not None
    used = {getattr(value, "__module__", None) or "" for value in vars(module.obj).values()}
    found = ["mpi"] * bool(used & {"tests.support.ranks", "tests.support.killing"})
    return found + ["fe"] * any(name.startswith(("orchestrator.pushover.", "tests.support.pushover")) for name in used)


def shared_fixtures(item: pytest.Item) -> set[Hashable]:
    """Return the fixtures of these tests that a test shares with others, each with its parameter."""
    assert isinstance(item, pytest.Function)
    parameters = item.callspec.params if hasattr(item, "callspec") else {}
    found = {name: known[-1] for name, known in item._fixtureinfo.name2fixturedefs.items()}
    return {
        (name, one.baseid, repr(parameters.get(name)))
        for name, one in found.items()
        if one.baseid and one.scope != "function"
    }


@pytest.hookimpl(wrapper=True)
def pytest_fixture_setup(fixturedef: pytest.FixtureDef[object], request: pytest.FixtureRequest) -> Iterator[None]:
    if fixturedef.scope == "function":
        return (yield)
    with LEDGER.making((fixturedef.argname, fixturedef.baseid, repr(getattr(request, "param", None)))):
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    with LEDGER.measuring() as span:
        result = yield
        for fixture in shared_fixtures(item):
            LEDGER.use(fixture)
    cases = MEASURED.setdefault(test_of(item), Measured())
    cases.own += span.seconds
    cases.used |= span.used
    return result


def pytest_sessionfinish(session: pytest.Session) -> None:
    if not session.config.getoption("--store-seconds"):
        return
    found = stored()
    for test, cases in MEASURED.items():
        found[test] = Seconds(cases.own, cases.own + sum(LEDGER.seconds[value] for value in cases.used))
    with TABLE.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(("test", *Seconds._fields))
        table.writerows((test, f"{found[test].own:.2f}", f"{found[test].alone:.2f}") for test in sorted(found))

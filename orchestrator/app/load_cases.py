"""The load cases of a case before they are run: each alone, and what is refused of all of them before one is analysed.

What is refused of a load case names it, and the key that the case file has it under.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

from orchestrator.app import driver
from orchestrator.app.pushover_run import refuse_own_input
from orchestrator.basis.errors import CaseError, naming
from orchestrator.loads import load_cases, loads_on
from orchestrator.loads.load_cases import key_in_file
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.ties import with_ties
from orchestrator.settings.case import Case, refuse_seismic


def each(case: Case) -> dict[str, Case]:
    """Return the case of each load case alone, by name; a case without load cases is {"": case}. Raises CaseError."""
    with naming(case.file):
        loads = load_cases(case.load)
    return {
        name: replace(case, load=load, name=f"{case.name}, {name}") if name else case for name, load in loads.items()
    }


def refuse_several(case: Case, command: str) -> None:
    """Raise CaseError for a case with load cases, which `command` would leave out."""
    if case.load.several:
        remedy = "give the case.toml in the run folder of one of them, or --set load.cases=[]"
        remedy += " --set load.envelope=false" * case.load.envelope
        raise CaseError("load.cases", f"{command} takes one load case", remedy, str(case.file))


@contextmanager
def told(case: Case, name: str) -> Iterator[None]:
    """Let every CaseError raised inside name the load case `name` of `case`, and the key that the case file has; "" is
    the only one."""
    try:
        yield
    except CaseError as error:
        if not name:
            raise
        key, problem = key_in_file(case.load, name, error.key), f"{error.problem} (load case {name})"
        raise CaseError(key, problem, error.remedy, error.file) from None


def check(case: Case) -> Assemblage:
    """Refuse a wall, ties or loads that cannot be analysed (CaseError)."""
    assemblage = driver.check(case)
    with naming(case.file):
        with_ties(assemblage, case.reinforcement.ties)
        for name, one in each(case).items():
            with told(case, name):
                loads_on(assemblage.wall, one.load)
    return assemblage


def refuse_limit(case: Case) -> Assemblage:
    """Refuse whatever limit analysis refuses of any load case (CaseError), before it has answered for another one."""
    assemblage = check(case)
    _refuse_what_does_not_stand(case, assemblage)
    return assemblage


def refuse_run(case: Case) -> Assemblage:
    """Refuse whatever `run` refuses of the input of any load case (CaseError), before it has run another one."""
    assemblage = check(case)
    refuse_seismic(case)
    refuse_pushover(case, each(case), assemblage)
    _refuse_what_does_not_stand(case, assemblage)
    return assemblage


def refuse_pushover(case: Case, cases: Mapping[str, Case], assemblage: Assemblage) -> None:
    """Refuse what finite elements do not take of load cases, by name, of a case (CaseError)."""
    for name, one in cases.items():
        with told(case, name):
            driver.refuse_pushover(one, assemblage)


def _refuse_what_does_not_stand(case: Case, assemblage: Assemblage) -> None:
    """Refuse a wall that cannot stand under one of several load cases (CaseError); a single one says so by itself,
    before it writes, and is not asked twice."""
    for name, one in each(case).items() if case.load.several else ():
        with told(case, name):
            driver.refuse_what_does_not_stand(one, assemblage)


def refuse_folders(case: Case, output: Path, resume: bool) -> None:
    """Refuse folders of load cases that a run would write its input over, or that hold what it cannot go on with."""
    for name, one in each(case).items():
        refuse_own_input(one, output / name)
        if resume:
            driver.resumed(one, output / name)


def examine(case: Case) -> tuple[Assemblage, list[str]]:
    """Refuse whatever `limit` would refuse, and a verification that `run` would (CaseError); return the assemblage and
    what else is to be said."""
    assemblage = check(case)
    refuse_seismic(case)
    said: list[str] = []
    for name, one in each(case).items():
        with told(case, name):
            said += driver.examine(one, assemblage, partial(key_in_file, case.load, name))
    return assemblage, list(dict.fromkeys(said))

"""Several load cases of one wall: the loads of each, and where the case file says what one of them is wrong in."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

from orchestrator.basis.errors import CaseError
from orchestrator.loads.block_loads import LoadCase, LoadSettings

ENVELOPE = (
    LoadCase("+x mass", "+x", distribution="mass"),
    LoadCase("-x mass", "-x", distribution="mass"),
    LoadCase("+x mass x height", "+x", distribution="mass_height"),
    LoadCase("-x mass x height", "-x", distribution="mass_height"),
)
"""the load cases of an assessment in the plane of a wall: NTC 2018 7.3.4.2, EN 1998-1 4.3.3.4.2.2"""
NOT_A_FOLDER = ("figures", "macro", "micro", "runs", "points")
"""names of folders that the run folder uses itself"""
OF_A_FILE = re.compile(r".*\.(json|csv|html|toml|log|dxf|vtu|xdmf|h5|msh)", re.IGNORECASE)
"""names that it may use for its files"""


def load_cases(settings: LoadSettings) -> dict[str, LoadSettings]:
    """Return the loads of every load case by its name, the envelope's first; {"": settings} where there are none.

    Raises CaseError (key only).
    """
    if not settings.several:
        return {"": settings}
    loads: dict[str, LoadSettings] = {}
    for key, case in _keyed(settings):
        of_its_own = case.name.casefold() in NOT_A_FOLDER or OF_A_FILE.fullmatch(case.name)
        if of_its_own or not re.fullmatch(r"[\w+-]([\w+. -]{0,98}[\w+-])?", case.name):
            remedy = "use letters, digits, + - _ . and spaces, at most 100, and no name of the run folder's own"
            raise CaseError(f"{key}.name", f"{case.name!r} cannot name a folder", remedy)
        if case.name.casefold() in {name.casefold() for name in loads}:
            problem = f"{case.name!r} is the name of another one"
            raise CaseError(f"{key}.name", problem, "give every load case its own name")
        loads[case.name] = _of(case, settings)
    return loads


def _keyed(settings: LoadSettings) -> Iterator[tuple[str, LoadCase]]:
    """Yield every load case with the key that the case file has it under."""
    yield from (("load.envelope", case) for case in ENVELOPE if settings.envelope)
    yield from ((f"load.cases.{number}", case) for number, case in enumerate(settings.cases))


def _of(case: LoadCase, settings: LoadSettings) -> LoadSettings:
    """Return the loads of one load case: what it says, else what [load] says; forces of [load] for "per_block" only."""
    distribution = case.distribution or settings.distribution
    return replace(
        settings,
        direction=case.direction or settings.direction,
        inclination=settings.inclination if case.inclination is None else case.inclination,
        distribution=distribution,
        live=case.live or (settings.live if distribution == "per_block" else ()),
        dead=(*settings.dead, *case.dead),
        cases=(),
        envelope=False,
    )


def key_in_file(settings: LoadSettings, name: str, key: str) -> str:
    """Return the key that the case file has what `key` means in the loads of the load case `name`, as `load_cases`
    returns them: that of the load case where it says so itself, else that of [load]."""
    place, case = next(((place, case) for place, case in _keyed(settings) if case.name == name), ("", None))
    section, _, rest = key.partition(".")
    if case is None or section != "load":
        return key
    field, *inside = rest.split(".")
    shared = len(settings.dead)
    if field == "dead" and not inside and case.dead:  # of all of them: those that only this load case has
        return f"{place}.dead"
    if field == "dead" and inside and int(inside[0]) >= shared:
        return ".".join([place, field, str(int(inside[0]) - shared), *inside[1:]])
    its_own = field != "dead" and getattr(case, field) not in (None, ())
    lacking = field == "live" and case.distribution == "per_block" and not settings.live
    return f"{place}.{rest}" if its_own or lacking else key

"""The ways a run can end badly, each carrying what a person needs to act on it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class CaseError(Exception):
    """What the user gave cannot be used (exit code 2).

    `file` is the file concerned ("" where the raising stage does not know it: the driver fills it in with
    `in_file`), `key` the dotted key, block or joint in it, `problem` what is wrong, `remedy` what would be right.
    """

    def __init__(self, key: str, problem: str, remedy: str, file: str = "") -> None:
        super().__init__(key, problem, remedy, file)
        self.key, self.problem, self.remedy, self.file = key, problem, remedy, file

    def __str__(self) -> str:
        place = ": ".join(part for part in (self.file, self.key) if part)
        return " ".join(f"{place}: {self.problem}; {self.remedy}".splitlines())

    def in_file(self, file: str) -> CaseError:
        """Return the same error naming `file`, unless it names one already."""
        return self if self.file else type(self)(self.key, self.problem, self.remedy, file)


class FallsError(CaseError):
    """A wall that no joint forces carry under its dead load: its own weight, and what else stands on it."""


def refuse_other_kind(argument: str, value: object, kind: type, remedy: str) -> None:
    """Raise CaseError for an argument of a function that is of another kind than it takes; None is one left out."""
    if value is not None:
        require_kinds(remedy, **{argument: (value, kind)})


def require_kinds(remedy: str, **given: tuple[object, type]) -> None:
    """Raise CaseError for the first argument, of those that cannot be left out, that is of another kind than it takes.

    given: by the name of the argument, what was given and the kind.
    """
    for argument, (value, kind) in given.items():
        if not isinstance(value, kind):
            raise CaseError(argument, f"{type(value).__name__} was given, {kind.__name__} is expected", remedy)


@contextmanager
def naming(file: Path) -> Iterator[None]:
    """Let every CaseError raised inside name `file`, unless it names one already."""
    try:
        yield
    except CaseError as error:
        raise error.in_file(str(file)) from None


class ConvergenceError(Exception):
    """A solver gave up (exit code 1 when nothing above can go on): `stage` names it, `where` says at what point."""

    def __init__(self, stage: str, where: str, iterations: int = 0) -> None:
        super().__init__(stage, where, iterations)
        self.stage, self.where, self.iterations = stage, where, iterations

    def __str__(self) -> str:
        return f"{self.stage}: {self.where}"


@contextmanager
def resumable() -> Iterator[None]:
    """Let an interruption (KeyboardInterrupt) of what is done inside say that --resume goes on with it."""
    try:
        yield
    except KeyboardInterrupt as stopped:
        if GO_ON not in getattr(stopped, "__notes__", ()):
            stopped.add_note(GO_ON)
        raise


GO_ON = "go on with --resume"
NO_CONTACT = "with no contact left"
"""how what is said of a collapse ends"""


class CollapseError(Exception):
    """The wall has no equilibrium any more: `bodies` have lost every contact after `displacement` (mm) of the top.

    The natural end of a curve, not a failure of the solver.
    """

    def __init__(self, bodies: str, displacement: float) -> None:
        super().__init__(bodies, displacement)
        self.bodies, self.displacement = bodies, displacement

    def __str__(self) -> str:
        return f"{self.bodies} fell after {self.displacement:.4g} mm, {NO_CONTACT}"


class HeldError(Exception):
    """Supports hold the wall, as it has moved, against any multiple of its live load; `multiplier`: where it was found.

    The natural end of a curve without a peak, not a failure of the solver.
    """

    def __init__(self, multiplier: float) -> None:
        super().__init__(multiplier)
        self.multiplier = multiplier

    def __str__(self) -> str:
        return f"held by supports at a load multiplier of {self.multiplier:.4g}: this load does not bring the wall down"


class ResultError(Exception):
    """A run finished but a check of its result failed (exit code 3): `check` names it, `detail` has the figures."""

    def __init__(self, check: str, detail: str) -> None:
        super().__init__(check, detail)
        self.check, self.detail = check, detail

    def __str__(self) -> str:
        return f"result not valid: {self.check}: {self.detail}"

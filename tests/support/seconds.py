"""What a test takes alone: its own CPU seconds, and those of every shared value it uses, whoever made it first.

A shared value is a fixture of more than one test (tests/conftest.py) or what a function marked `shared` returns.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import wraps
from typing import TypeVar

Made = TypeVar("Made")


def cpu_seconds() -> float:
    """Return the CPU seconds of this process and of those it has waited for."""
    spent = os.times()
    return spent.user + spent.system + spent.children_user + spent.children_system


@dataclass
class Span:
    """A stretch of work: what it took without the making of shared values, the values it used, and their making."""

    seconds: float = 0.0
    used: set[Hashable] = field(default_factory=set)
    making: float = 0.0


class Ledger:
    """The seconds that each shared value took without those it was made of, and which those are."""

    def __init__(self, clock: Callable[[], float] = cpu_seconds) -> None:
        self.clock = clock
        self.seconds: dict[Hashable, float] = {}
        self.parts: dict[Hashable, set[Hashable]] = {}
        self.spans: list[Span] = []

    @contextmanager
    def measuring(self) -> Iterator[Span]:
        """Measure what is done: the span is filled in at its end."""
        span, begun = Span(), self.clock()
        self.spans.append(span)
        try:
            yield span
        finally:
            self.spans.pop()
            whole = self.clock() - begun
            span.seconds = whole - span.making
            if self.spans:
                self.spans[-1].making += whole

    @contextmanager
    def making(self, value: Hashable) -> Iterator[None]:
        """Measure what is done to make a shared value, which is used by what asked for it."""
        with self.measuring() as span:
            yield
        self.seconds[value] = span.seconds
        self.parts[value] = span.used
        self.use(value)

    def use(self, value: Hashable) -> None:
        """Note that what is being done uses a value, if that is one that has been made."""
        if self.spans and value in self.seconds:
            self.spans[-1].used |= {value} | self.parts[value]


LEDGER = Ledger()


def shared(make: Callable[..., Made]) -> Callable[..., Made]:
    """Make a value once for each set of arguments; every test that asks for it is charged with what it took."""
    known: dict[Hashable, Made] = {}

    @wraps(make)
    def once(*arguments: Hashable) -> Made:
        value = (make.__module__, make.__qualname__, arguments)
        if value in known:
            LEDGER.use(value)
            return known[value]
        with LEDGER.making(value):
            known[value] = make(*arguments)
        return known[value]

    return once

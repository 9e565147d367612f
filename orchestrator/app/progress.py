"""What a running analysis reports as it goes: a stage that begins or is done, an increment that has converged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from orchestrator.pushover.increments import Increment


@dataclass(frozen=True, slots=True)
class IncrementDone:
    """One converged increment of a pushover; `fraction` of the final displacement that is reached."""

    model: str
    increment: Increment
    weight: float
    seconds: float
    fraction: float

    def __str__(self) -> str:
        return f"{self.model} FE: {self.increment}"


@dataclass(frozen=True, slots=True)
class StageDone:
    """A stage is done: its name, what it cost in s, its result in a few words."""

    stage: str
    seconds: float
    text: str


@dataclass(frozen=True, slots=True)
class StageBegun:
    """What is being done from now on, in a few words: `stage` as that of StageDone, `text` what it does."""

    stage: str
    text: str


Report = Callable[[StageBegun | StageDone | IncrementDone], None]

"""summary.json as values: the figures that scripts outside this repository read; the keys stay. All SI."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any, Literal

from orchestrator.limit_analysis.paper.limit_state import LimitAnalysis, LimitState
from orchestrator.macroblocks.criteria import Partition
from orchestrator.masonry.joints import Assemblage
from orchestrator.storage.effort import Event
from orchestrator.storage.files import plain, write_json


@dataclass(frozen=True, slots=True)
class AtPeak:
    """What the wall is at its peak, against the wall as drawn."""

    fallen: float = 0.0
    """share of the dead load that has fallen"""
    bound_left: float | None = None
    """associative multiplier of what is left, where anything has fallen; None where nothing bounds it"""
    drawn_contacts: float | None = None
    """highest multiplier that it bears, as it has moved, without contacts not drawn (closed gaps), where they press"""
    increment: int = 0
    """number of the increment"""


@dataclass(frozen=True, slots=True)
class Snap:
    """The farthest motion of a wall from one state of rest to the next one, before its peak."""

    load_multiplier: float
    """of the rest that it lost"""
    moved: float
    """by the control displacement, or of the part of the wall that moves where the top stands, m"""
    share: float | None
    """of the control displacement at the peak; None where the top stands"""
    bore_less: bool = True
    """on the way; else a load in between may find it at rest there"""


@dataclass(frozen=True, slots=True)
class NarrowPeak:
    """How soon after its peak a wall bears 5 % less."""

    load_multiplier: float
    """of the first state of rest that does"""
    moved: float
    """by the control displacement since the peak, m"""


@dataclass(frozen=True, slots=True)
class PushoverSummary:
    """One pushover: size of its model, effort (`Effort`), capacity (`Capacity`), cost, and whether it is valid."""

    model: Literal["macro", "micro"]
    bodies: int
    nodes: int
    tetrahedra: int
    contacts: int
    displacements: Literal["large", "small"]
    ranks: int
    steps: int
    moving_steps: int
    newton_iterations: int
    rescues: dict[str, int]
    energy_error: float | None
    """None where it is not a number"""
    events: tuple[Event, ...]
    max_penetration: float
    """largest overlap of displaced outlines, m"""
    max_penetration_over_size: float
    """and over the smaller body's size"""
    peak_base_shear: float
    peak_multiplier: float
    displacement_at_peak: float
    final_displacement: float
    initial_stiffness: float | None
    """None where the control displacement goes against the live load at first"""
    equilibrium_residual: float | None
    """None where it is not a number"""
    peak_reached: bool
    seconds: dict[str, float]
    """mesh, assembly, factorise, contact, total"""
    peak_memory: int
    """bytes"""
    stopped_because: str
    complaint: str | None
    """why the curve ended early or is not valid; None for a good one"""
    valid: bool
    not_valid_because: str | None
    """the checks of the result that failed (pushover.checks), in words"""
    toe_error: float = 0.0
    """moment that toes which crush carry too much at the peak, over that of the live load"""
    crack_size: float = 0.0
    """size that elements need at bonded joints that crack at the peak, m; 0 where none does"""
    crack_error: float = 0.0
    """moment that bonds which crack carry too much at the peak, over that of the live load"""
    crushing: bool = False
    """whether a joint has a finite compressive strength"""
    max_pressed_gap: float = 0.0
    """largest distance of displaced outlines of two bodies that press each other, m"""
    max_pressed_gap_over_size: float = 0.0
    """and over the smaller body's size"""
    at_peak: AtPeak = AtPeak()
    held: bool = False
    """whether the curve ended because supports hold the wall, as it has moved, against any multiple of the load"""
    control_share: float = 1.0
    """control displacement at the curve's end over the motion of the body that went farthest, both since gravity"""
    snap: Snap | None = None
    """None where it moved no farther between states of rest before the peak than a tenth of the largest increment"""
    spike: NarrowPeak | None = None
    """None for a peak that is no spike"""


@dataclass(frozen=True, slots=True)
class WallSummary:
    """Blocks without supports, joints; weight of the blocks, all vertical load, and horizontal load at λ = 1 (N);
    whether joints have cohesion or tensile strength."""

    blocks: int
    joints: int
    weight: float
    vertical_load: float
    horizontal_load: float
    bonded: bool = False


@dataclass(frozen=True, slots=True)
class LooseStones:
    """Stones (ids) that come loose before the wall fails, their share of the dead load, and the lowest and highest
    multiplier at which they do."""

    stones: tuple[int, ...]
    share: float
    multipliers: tuple[float, float]


Kind = Literal["collapse state", "peak in large displacements", "last load at rest", "an upper bound only"]
IN_BRACKETS: tuple[Kind, ...] = ("peak in large displacements", "last load at rest")
"""What the wall bears, but no collapse state: its multiplier is printed in brackets."""


@dataclass(frozen=True, slots=True)
class LimitSummary:
    """Multipliers of micro limit analysis (`LimitAnalysis` says what they are), None where there is none.

    non_associative: the headline, where there is more than a bound; papers_value: of the paper's sequence.
    """

    associative: float
    non_associative: float | None
    non_associative_range: tuple[float, float] | None
    iterations: int
    converged: bool
    equilibrium_residual: float
    base_shear: float
    """of the headline, N"""
    seconds: float
    associative_left: float | None = None
    base_shear_left: float | None = None
    """of the associative state of what local failures left, N"""
    path: float | None = None
    last_rest: float | None = None
    soft_from: float | None = None
    interval: tuple[float, float] | None = None
    large_displacements: float | None = None
    """the most that rigid blocks bore in large displacements, where they were pushed"""
    rigid_peak: float | None = None
    """the same where it is a peak: it was passed"""
    pressed_peak: float | None = None
    """about what is left of it, or of the state of a wall that was not pushed so, as stones give way at edges that they
    turn about"""
    papers_value: float | None = None
    lowest: float | None = None
    highest: float | None = None
    local_failures: tuple[LooseStones, ...] = ()
    is_bound: bool = True
    """whether no state of rigid stones exceeds the associative one: not where stones touch in one point"""
    meets_in_points: bool = False
    """whether stones touch in one point, or go into each other in one, in which limit analysis has no force"""
    going_down: tuple[int, ...] = ()
    """stones (ids) that go down unless they are wedged, where loading finds no rest under the dead load"""

    @property
    def multiplier(self) -> float:
        """The multiplier that counts."""
        return self.associative if self.non_associative is None else self.non_associative

    @property
    def kind(self) -> Kind:
        """What it is the multiplier of: where no collapse state was found, of one of the others."""
        if self.non_associative is None:
            return "an upper bound only"
        if self.converged:
            return "collapse state"
        geometry_decides = self.non_associative == self.large_displacements
        return "peak in large displacements" if geometry_decides else "last load at rest"

    @property
    def in_brackets(self) -> bool:
        """Whether it is printed in brackets."""
        return self.kind in IN_BRACKETS

    @property
    def bound(self) -> float:
        """Highest load multiplier of any state of the stones that do not come loose before, by the static theorem."""
        return self.associative if self.associative_left is None else self.associative_left


@dataclass(frozen=True, slots=True)
class MacroblockSummary:
    """The partition; a tolerance is None where it is infinite or there is none."""

    count: int
    joints: int
    tol_n: float | None
    tol_d: float | None
    trivial: bool


@dataclass(frozen=True, slots=True)
class Summary:
    """A run. macroblocks: None where it stopped before them; pushover may be empty; seismic: the verification.

    failed: models that have no curve, where others have one, and why. settings: of the run, as its case.toml has them,
    blocks_sha256 of its blocks.json, and files: of its other parts, by their names (parts.py); sha256: of all this but
    the verification. None of what was not run.
    """

    case: str
    wall: WallSummary
    limit_analysis: LimitSummary
    macroblocks: MacroblockSummary | None
    pushover: tuple[PushoverSummary, ...]
    seismic: dict[str, Any] | None = None
    settings: dict[str, Any] | None = None
    blocks_sha256: str | None = None
    failed: dict[str, str] | None = None
    files: dict[str, str] | None = None
    sha256: str | None = None

    @property
    def record(self) -> dict[str, Any]:
        """What summary.json holds; what may be None at the end only where there is any."""
        last = ("seismic", "settings", "blocks_sha256", "failed", "files", "sha256")
        return {key: value for key, value in asdict(self).items() if value is not None or key not in last}


def summarise(
    case: str,
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    partition: Partition | None,
    pushovers: Sequence[PushoverSummary],
) -> Summary:
    """Return the summary of a run that is not verified (yet)."""
    blocks = sum(not block.fixed for block in assemblage.wall.blocks)
    sums = (analysis.weight, analysis.vertical_load, analysis.horizontal_load)
    joints = assemblage.joints
    bonded = bool((joints.cohesion > 0.0).any() or (joints.tensile_strength > 0.0).any())
    wall = WallSummary(blocks, joints.count, *sums, bonded)
    merged = None if partition is None else _macroblocks(partition, joints.count)
    return Summary(case, wall, limit_summary(analysis), merged, tuple(pushovers))


def limit_summary(analysis: LimitAnalysis) -> LimitSummary:
    """Return the summary of a limit analysis."""
    headline = analysis.headline
    interval = analysis.non_associative_range
    return LimitSummary(
        associative=analysis.associative.load_multiplier,
        associative_left=_multiplier(analysis.associative_left),
        non_associative=headline.load_multiplier if interval else None,
        non_associative_range=interval,
        path=_multiplier(analysis.path),
        last_rest=analysis.last_rest,
        soft_from=analysis.soft_from,
        interval=analysis.interval,
        large_displacements=None if analysis.rigid_curve is None else float(analysis.rigid_curve[:, 1].max()),
        rigid_peak=analysis.rigid_peak,
        pressed_peak=analysis.pressed_peak,
        papers_value=_multiplier(analysis.sequence),
        lowest=_multiplier(analysis.lowest),
        highest=analysis.highest,
        local_failures=tuple(
            LooseStones(failure.stones, failure.share, failure.multipliers) for failure in analysis.local_failures
        ),
        is_bound=not analysis.points_in_common,
        meets_in_points=not analysis.is_bound,
        going_down=analysis.going_down,
        iterations=len(headline.records),
        converged=interval is not None and headline.converged,
        equilibrium_residual=headline.equilibrium_residual,
        base_shear=headline.base_shear,
        base_shear_left=None if analysis.associative_left is None else analysis.associative_left.base_shear,
        seconds=analysis.seconds,
    )


def _multiplier(state: LimitState | None) -> float | None:
    return None if state is None else state.load_multiplier


def _macroblocks(partition: Partition, joints: int) -> MacroblockSummary:
    tolerances = partition.tolerances
    return MacroblockSummary(
        count=partition.count,
        joints=joints - len(partition.vanished_joints),
        tol_n=None if tolerances is None else tolerances.tol_n,
        tol_d=None if tolerances is None else tolerances.tol_d,
        trivial=partition.count == 1,
    )


def write_summary(folder: Path, summary: Summary) -> Summary:
    """Write summary.json, of a run with its sha256; return what it holds."""
    if summary.files is not None:
        summary = replace(summary, sha256=seal_of(summary))
    write_json(folder / "summary.json", summary.record)
    return summary


def read_summary(folder: str | PathLike[str]) -> Summary:
    """Return what `write_summary` wrote. Raises OSError, and ValueError for a file that holds something else."""
    return _parsed((Path(folder) / "summary.json").read_bytes())


def seal_of(summary: Summary) -> str:
    """Return a hash of all but the verification, which `report` may make again; the same before and after reading."""
    alone = replace(summary, seismic=None, sha256=None)
    as_read = _parsed(json.dumps(plain(alone.record)).encode()).record  # where 0 may have become 0.0
    return hashlib.sha256(json.dumps(plain(as_read), sort_keys=True).encode()).hexdigest()


def _parsed(content: bytes) -> Summary:
    from pydantic import TypeAdapter, ValidationError

    try:
        return TypeAdapter(Summary).validate_json(content)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise ValueError(": ".join(filter(None, ("summary.json", place, first["msg"])))) from error

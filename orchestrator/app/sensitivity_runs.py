"""The runs of `sensitivity`: every point of the ranges under every load case; tables, tornado and fragility.

A point is one file in `points`, written when it is whole. Its name ends with a hash of everything it depends on: a
point that is there is not run again, so that an interrupted study continues where it stopped. Ranks 1 and up share
them.
"""

from __future__ import annotations

import hashlib
import tempfile
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from orchestrator import storage
from orchestrator.app import driver, load_cases, pushover_run
from orchestrator.app.counted_capacity import NO_ANSWER, Quantity, compared, governing, quantity_of
from orchestrator.app.progress import Report, StageBegun, StageDone
from orchestrator.assessment.seismic.seismic_verification import verify
from orchestrator.assessment.seismic.settings import limit_states
from orchestrator.assessment.sensitivity import (
    ALIKE,
    Lognormal,
    SensitivityPoint,
    SensitivitySettings,
    fragility,
    latin_hypercube,
    lognormal,
    one_at_a_time,
    ranges,
    value_of_range,
)
from orchestrator.basis.errors import CaseError, ConvergenceError, FallsError, naming
from orchestrator.basis.parallel import Spread, on_root, workers_into
from orchestrator.basis.printed import counted
from orchestrator.basis.program import sources
from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.masonry.joints import Assemblage, JointClass
from orchestrator.present import plots
from orchestrator.present.verdict import Answered
from orchestrator.settings.case import Case, RunSettings, as_record, refuse_verification
from orchestrator.settings.project import ProjectSettings

if TYPE_CHECKING:
    from mpi4py import MPI

FALLS = "cannot stand"
"""which kind of answer a wall has that falls under its dead load"""
OF_JOINTS = ("friction", "cohesion", "tensile_strength", "compressive_strength")
COLUMNS = ("point", "capacity", "kind", "quantity", "load_case", "check", "remark")


@dataclass(frozen=True, eq=False, slots=True)
class PointRun:
    """One point: its case, and the file that holds its result once it is known."""

    point: SensitivityPoint
    case: Case
    file: Path


@dataclass(frozen=True, eq=False, slots=True)
class SensitivityOutcome:
    """What a study leaves: the quantity; the capacity of the case as given and which kind of answer it is; rows of the
    tornado with the largest first; the capacity of every sample; the lognormal fit; how many samples are of which kind;
    which load cases are not compared.

    bars: name, low, high (SI); of each end at_ (capacity), found_ and kind_: what was found, of which kind. A capacity
    is None, of ends and samples, where none is known or one of another kind, which is compared with nothing.
    """

    quantity: Quantity
    base: float | None
    kind: str
    bars: tuple[dict[str, Any], ...]
    samples: tuple[float | None, ...]
    fit: Lognormal | None
    kinds: Mapping[str, int]
    steep: tuple[str, ...] = ()


def sensitivity(
    case: Case, output: Path, comm: MPI.Intracomm | None, report: Report, force: bool = False
) -> SensitivityOutcome | None:
    """Run the ranges of [sensitivity] into `output`; None on the ranks that only work. Raises CaseError, where not by
    `force` for a folder with the table of another analysis too."""
    on_root(comm, refuse, case)
    if case.sensitivity.analysis != "limit":
        pushover_run.start_finite_elements()
    with workers_into(output, comm) as spread:
        return _sensitivity(case, output, spread, report, force) if spread else None


def _sensitivity(case: Case, output: Path, spread: Spread, report: Report, force: bool) -> SensitivityOutcome:
    began, settings = perf_counter(), case.sensitivity
    storage.refuse_run(output)
    limits = ranges(settings)
    points = (*one_at_a_time(limits), *latin_hypercube(limits, settings.samples, settings.seed))
    digests = _digest_of(case)
    runs = [_run_of(point, case, output / "points", digests) for point in points]
    of = hashlib.sha256(repr([(run.point.name, run.file.name) for run in runs]).encode()).hexdigest()
    source = storage.Source("sensitivity", as_record(case, str(case.block_file)), (case.file, case.block_file), of)
    if not force:
        storage.refuse_other_points(output, "sensitivity.csv", source)
    missing = [run for run in runs if not run.file.exists()]
    report(StageDone("points", 0.0, f"{len(runs)}, {len(runs) - len(missing)} of them run before"))
    for number, said in enumerate(spread(compute, missing), 1):
        report(StageDone(f"{number} of {len(missing)}", perf_counter() - began, said))
    report(StageBegun("sensitivity", "pictures"))
    answers = {run.point.name: storage.read_json(run.file) for run in runs}
    with storage.placed([output], source, force):
        return _presented(case, output, limits, [run.point for run in runs], answers)


def refuse(case: Case) -> None:
    """Refuse whatever the input shows that a point would refuse, before any is run (CaseError)."""
    with naming(case.file):
        limits = ranges(case.sensitivity)
    assemblage = load_cases.check(case)
    _refuse_ends(case, limits)
    refuse_verification(case)
    if case.sensitivity.analysis != "limit":
        pushed = compared(replace(case, run=RunSettings((case.sensitivity.analysis,))))
        load_cases.refuse_pushover(case, pushed, assemblage)
    if not compared(case):
        problem = "all of them have a live load that is more vertical than horizontal, which no base shear compares"
        remedy = "give one of them alone, as [load] without load cases"
        raise CaseError("load.cases", problem, remedy, str(case.file))


def _refuse_ends(case: Case, limits: Mapping[str, tuple[float, float]]) -> None:
    """Raise CaseError for an end of a range with which the wall of the case is no wall."""
    for name, ends in limits.items():
        for end in ends:
            try:
                driver.check(varied(case, {name: end}))
            except CaseError as error:
                raise CaseError(f"sensitivity.{name}", error.problem, error.remedy, str(case.file)) from None


def varied(case: Case, values: Mapping[str, float]) -> Case:
    """Return the case with other values: of every joint by a last joint class, of every block by [wall]."""
    of_joints: dict[str, Any] = {name: values[name] for name in OF_JOINTS if name in values}
    of_wall: dict[str, Any] = {name: values[name] for name in ("unit_weight", "thickness") if name in values}
    wall = replace(case.wall, **of_wall)
    if "unit_weight" in values:
        wall = replace(wall, classes=tuple(replace(one, unit_weight=None) for one in wall.classes))
    joints = replace(case.joints, classes=(*case.joints.classes, JointClass(**of_joints))) if of_joints else case.joints
    return replace(case, wall=wall, joints=joints)


def _digest_of(case: Case) -> Callable[[SensitivityPoint], str]:
    only = SensitivitySettings(analysis=case.sensitivity.analysis)
    alike = replace(case, file=Path(), name="", project=ProjectSettings(), sensitivity=only)
    common = repr((alike, storage.hash_file(case.block_file), sources()))

    def digest(point: SensitivityPoint) -> str:
        return hashlib.sha256(f"{common}{point.values!r}".encode()).hexdigest()[:16]

    return digest


def _run_of(point: SensitivityPoint, case: Case, folder: Path, digest: Callable[[SensitivityPoint], str]) -> PointRun:
    changed = replace(varied(case, dict(point.values)), sensitivity=case.sensitivity)
    return PointRun(point, changed, folder / f"{digest(point)}.json")


def compute(run: PointRun) -> str:
    """Compute one point into its file; return what happened in a few words."""
    analysis = run.case.sensitivity.analysis
    answers, remarks = [], []
    for name, one in compared(run.case).items():
        load = name or f"{one.load.direction} {one.load.distribution}"
        about = (load, one.load.direction, one.load.distribution)
        try:
            summary = _limit(one) if analysis == "limit" else _pushed(one)
        except FallsError as error:
            record = {"capacity": 0.0, "kind": FALLS, "load_case": load, "check": "dead load", "remark": error.problem}
            storage.write_json(run.file, {"values": dict(run.point.values)} | record)
            return f"{run.point.name}: {error.problem}"
        except ConvergenceError as error:
            remarks.append(f"{load}: {error}")
            continue
        answers.append(Answered(*about, summary))
    record = governing(answers, remarks, quantity_of(run.case))
    storage.write_json(run.file, {"values": dict(run.point.values)} | record)
    capacity = record["capacity"]
    return f"{run.point.name}: " + ("no answer" if capacity is None else f"{capacity:.4g}")


def _limit(case: Case) -> storage.Summary:
    """Return the summary of limit analysis, with the kinematic checks where a ground acceleration is asked for."""
    assemblage, analysis = driver.limit(case)
    summary = storage.summarise(case.name, assemblage, analysis, None, [])
    return replace(summary, seismic=_kinematic(case, assemblage, analysis))


def _kinematic(case: Case, assemblage: Assemblage, analysis: LimitAnalysis) -> dict[str, Any] | None:
    with naming(case.file):
        verified = verify(case.seismic, case.load, case.limit_analysis, assemblage, analysis, [])
    return None if verified is None else verified[0]


def _pushed(case: Case) -> storage.Summary | None:
    """Return the summary of a pushover, of which nothing else is kept: it runs where the system has what is passing."""
    model = case.sensitivity.analysis
    assert model != "limit"
    with tempfile.TemporaryDirectory() as temporary:
        alone = replace(case, run=RunSettings((model,)))
        return driver.run(alone, Path(temporary) / "run", False, None, lambda event: None).summary


def _presented(
    case: Case,
    output: Path,
    limits: Mapping[str, tuple[float, float]],
    points: Sequence[SensitivityPoint],
    answers: Mapping[str, Mapping[str, Any]],
) -> SensitivityOutcome:
    """Write tables and pictures; return the outcome."""
    quantity = quantity_of(case)
    kind = _kind_compared(answers)
    bars: list[dict[str, Any]] = [
        {"name": name, "low": low, "high": high} | _ends(name, answers, kind) for name, (low, high) in limits.items()
    ]
    bars.sort(key=lambda bar: -abs((bar["at_high"] or 0.0) - (bar["at_low"] or 0.0)))
    rows = [
        [point.name, one["capacity"], one["kind"], quantity, one["load_case"], one["check"], one["remark"]]
        + [one["values"].get(name) for name in limits]
        for point in points
        for one in [answers[point.name]]
    ]
    storage.write_csv(output / "sensitivity.csv", (*COLUMNS, *limits), rows)
    samples = [answers[point.name] for point in points if point.name.startswith("sample")]
    sampled = [_compared(one, kind) for one in samples]
    known = [capacity for capacity in sampled if capacity is not None]
    base = answers["as given"]["capacity"]
    plots.save(plots.tornado(bars, base, quantity, case.name), output / "figures", "tornado")
    fit = lognormal(known)
    if known:
        _write_fragility(case, output, known, fit, quantity)
    return SensitivityOutcome(
        quantity, base, kind, tuple(bars), tuple(sampled), fit, Counter(one["kind"] for one in samples),
        tuple(name for name in load_cases.each(case) if name not in compared(case)),
    )  # fmt: skip


def _write_fragility(case: Case, output: Path, known: Sequence[float], fit: Lognormal | None, quantity: str) -> None:
    """Write table and picture of the capacities that are known."""
    ordered, probability = fragility(known)
    fitted = [None if fit is None else fit.probability(x) for x in ordered.tolist()]
    storage.write_csv(
        output / "fragility.csv", (quantity, "probability", "lognormal"),
        zip(ordered.tolist(), probability.tolist(), fitted, strict=True),
    )  # fmt: skip
    demands = [state.peak_ground_acceleration for state in limit_states(case.seismic)]
    figure = plots.fragility_curve(ordered, probability, fit, quantity, demands, case.name)
    plots.save(figure, output / "figures", "fragility")


def _kind_compared(answers: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the kind of answer that all are compared in: that of the case as given, or the one of most points."""
    kind: str = answers["as given"]["kind"]
    if kind not in (NO_ANSWER, FALLS):
        return kind
    others = Counter(one["kind"] for one in answers.values() if one["kind"] not in (NO_ANSWER, FALLS))
    return others.most_common(1)[0][0] if others else kind


def _compared(one: Mapping[str, Any], kind: str) -> float | None:
    """Return a capacity that can be compared; None for one of another kind. A wall that falls has 0 in all of them."""
    capacity: float | None = one["capacity"]
    return capacity if one["kind"] in (kind, FALLS) else None


def _ends(name: str, answers: Mapping[str, Mapping[str, Any]], kind: str) -> dict[str, Any]:
    """Return what a bar says of its two ends."""
    ends: dict[str, Any] = {}
    for end in ("low", "high"):
        one = answers[f"{name} {end}"]
        ends |= {f"at_{end}": _compared(one, kind), f"found_{end}": one["capacity"], f"kind_{end}": one["kind"]}
    return ends


def words(outcome: SensitivityOutcome) -> list[str]:
    """Return what the samples say, in a few sentences."""
    known = [capacity for capacity in outcome.samples if capacity is not None]
    said = _not_compared(outcome)
    if outcome.steep:
        said.insert(0, f"Not compared, as more vertical than horizontal: {', '.join(outcome.steep)}.")
    if known:
        ordered, probability = fragility(known)
        low, middle, high = np.interp((0.05, 0.5, 0.95), probability, ordered)
        found = f"5 % fractile {low:.4g}, median {middle:.4g}, 95 % fractile {high:.4g}"
        found = found if probability[0] <= 0.05 else f"median {middle:.4g}"  # too few samples for fractiles
        of_what = f"{counted(len(known), 'sample')}, {outcome.quantity}"
        said.append(f"{of_what}: from {ordered[0]:.4g} to {ordered[-1]:.4g}, {found}.")
    if outcome.fit is not None:
        fit = outcome.fit
        said.append(f"Lognormal fit: median {fit.median:.4g}, beta {fit.beta:.3f}, off by up to {fit.distance:.2f}.")
    elif len(known) > 1 and known[0] > 0.0 and max(known) - min(known) <= ALIKE * max(known):
        left_out, told = len(outcome.samples) - len(known), " to what is compared" * bool(outcome.steep)
        said.append(
            f"{len(known)} samples have one answer, {left_out} are left out: whether these ranges matter is not known."
            if left_out
            else f"All samples have one answer: these ranges do not matter{told}."
        )
    if fallen := sum(capacity == 0.0 for capacity in known):
        said.append(f"{fallen} of them do not stand under their dead load: their capacity is 0, and there is no fit.")
    if missing := outcome.kinds.get(NO_ANSWER, 0):
        said.append(f"{missing} samples have no answer and are left out: sensitivity.csv says why.")
    others = {kind: count for kind, count in outcome.kinds.items() if kind not in (outcome.kind, NO_ANSWER, FALLS)}
    if others:
        each, many = ", ".join(f"{count} {kind}" for kind, count in others.items()), sum(others.values())
        have = f"{many} of {len(outcome.samples)} samples ha{'s' if many == 1 else 've'}"
        said.append(
            f"{have} another kind of answer ({each}) than {outcome.kind} and are left out of fragility and fit, "
            "which say nothing of them."
        )
    return said


def _not_compared(outcome: SensitivityOutcome) -> list[str]:
    """Return a sentence for every end of a range whose answer is of another kind."""
    return [
        f"{bar['name'].replace('_', ' ')} {value_of_range(bar['name'], bar[end])}: {bar[f'found_{end}']:.4g}, "
        f"{bar[f'kind_{end}']}, not compared with the case as given ({outcome.kind})."
        for bar in outcome.bars
        for end in ("low", "high")
        if bar[f"at_{end}"] is None and bar[f"found_{end}"] is not None
    ]

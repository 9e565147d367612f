"""Values -> run folder and pictures, at the three moments when a run knows something worth keeping."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orchestrator import storage
from orchestrator.assessment.capacity import Capacity
from orchestrator.assessment.seismic.observed import StoredPushover
from orchestrator.assessment.seismic.seismic_verification import verify
from orchestrator.basis.errors import naming
from orchestrator.basis.printed import percent_of
from orchestrator.limit_analysis import LimitAnalysis, LimitState
from orchestrator.loads.block_loads import height_of_live_load
from orchestrator.macroblocks.bodies import Bodies, make_bodies, materials_of
from orchestrator.macroblocks.criteria import Partition, one_body_per_block, stones_of
from orchestrator.masonry.block_properties import block_weights
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.wall import Wall
from orchestrator.present import page, plots
from orchestrator.present.tie_states import shown_ties
from orchestrator.present.weights import load_words, weight_words
from orchestrator.pushover.increments import Increment, PushoverCurve
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.pushover.solids.elastic_constants import constants_of, slip_tolerance_of
from orchestrator.settings.case import Case, as_record, as_toml, refuse_verification
from orchestrator.settings.inventory import class_words, load_sums
from orchestrator.settings.project import Language
from orchestrator.storage.files import plain
from orchestrator.storage.notes import why_not
from orchestrator.storage.stored_run import read_run

if TYPE_CHECKING:
    from orchestrator.pushover.model import ContactModel

FAR_LOWER = 0.05
"""part by which the lowest state found lies below what counts where its mechanism is drawn, too"""
CONTROL_COLUMNS = ("control_displacement_m", "base_shear_N")


def write_segmentation(
    output: Path, case: Case, assemblage: Assemblage, analysis: LimitAnalysis, partition: Partition, bodies: Bodies
) -> None:
    """Write what is known before the finite elements; the summary of an earlier run goes."""
    output.mkdir(parents=True, exist_ok=True)
    (output / "summary.json").unlink(missing_ok=True)
    storage.remove_what_some_have(output)
    storage.write_case(output, as_run(case))
    storage.write_blocks(output, assemblage.wall)
    storage.write_joints(output, assemblage)
    storage.write_limit_analysis(output, assemblage.wall, analysis)
    write_given(output / "figures", case, assemblage)
    write_mechanism(output / "figures", case, assemblage, analysis)
    write_partition(output, case, assemblage, partition, bodies)


def write_partition(output: Path, case: Case, assemblage: Assemblage, partition: Partition, bodies: Bodies) -> None:
    """Write and draw the macroblocks."""
    storage.write_macroblocks(output, assemblage.wall, partition, bodies)
    plots.save(plots.macroblocks(assemblage, partition), output / "figures", "macroblocks", case.project.language)


def write_given(figures: Path, case: Case, assemblage: Assemblage, name: str = "blocks") -> list[Path]:
    """Draw what a case gives: numbered blocks, loads, ties, classes of joints; return the files."""
    picture = plots.given(assemblage, case.load, class_words(assemblage), case.reinforcement.ties)
    return plots.save(picture, figures, name, case.project.language)


def write_mechanism(figures: Path, case: Case, assemblage: Assemblage, analysis: LimitAnalysis) -> list[Path]:
    """Draw the mechanism of the headline state, as picture and DXF, and write its forces beside the pictures' folder;
    likewise the curve of rigid blocks, where there is one, and the mechanism of the lowest state, where that is
    FAR_LOWER. Return the pictures of the mechanism."""
    storage.write_forces(figures.parent, assemblage, analysis.headline, case.reinforcement.ties)
    if storage.write_rigid_curve(figures.parent, analysis) is not None:
        plots.save(plots.rigid_pushover(analysis), figures, "rigid_pushover", case.project.language)
    storage.write_text(figures.parent / "mechanism.dxf", plots.mechanism_dxf(assemblage, analysis.headline))
    loose = {stone for failure in analysis.local_failures for stone in failure.stones}
    weight = weight_words(analysis)
    if analysis.local_failures:
        weight += f", {percent_of(analysis.share_lost)} of it come loose before"
    live = load_words(case.load.distribution, analysis), weight
    state, ties = analysis.headline, case.reinforcement.ties
    height = height_of_live_load(assemblage.wall, case.load)

    def drawn(shown: LimitState, name: str) -> list[Path]:
        figure = plots.mechanism(
            assemblage, shown, case.load.vector, *live, loose=loose, ties=ties, dead=case.load.dead, height=height
        )
        return plots.save(figure, figures, name, case.project.language)

    lowest = analysis.lowest
    if lowest is not None and lowest.load_multiplier < (1.0 - FAR_LOWER) * state.load_multiplier:
        drawn(replace(lowest, flow_rule="unloaded"), "lowest")
    return drawn(state, "mechanism")


def write_settlement(
    figures: Path, assemblage: Assemblage, state: LimitState, angle: float, language: Language = "en"
) -> list[Path]:
    """Draw the mechanism of a support that gives way at `angle`; return the files."""
    reaction = f"least reaction {0.0 - state.load_multiplier / 1e3:.4g} kN"
    figure = plots.mechanism(assemblage, state, np.array([np.cos(angle), np.sin(angle)]), "settlement", "", reaction)
    return plots.save(figure, figures, "settlement", language)


def as_run(case: Case) -> str:
    """Return case.toml of a run folder: all settings, and what they were run with."""
    return "\n".join([as_toml(case, "blocks.json"), "# As run, with:", *_provenance(case), ""])


def _provenance(case: Case) -> list[str]:
    """Return comment lines: versions of everything, hashes of the inputs."""
    lines = [f"# {name} {version}" for name, version in storage.versions().items()]
    return lines + [f"# sha256 of {path.name}: {storage.hash_file(path)}" for path in (case.file, case.block_file)]


def write_pushover(
    store: storage.StateStore,
    case: Case,
    name: str,
    wall: Wall,
    bodies: Bodies,
    model: ContactModel,
    curve: PushoverCurve,
    valid: bool,
) -> None:
    """Write the curve, the ParaView files, what pictures need, and the deformed wall at its peak and its end."""
    storage.write_curve(store.folder, curve)
    contacts = model.possible
    derive, materials = storage.stress_and_pressure(model, bodies), materials_of(bodies, wall)
    storage.write_paraview(store, model.meshes, contacts.point, derive, materials, int(curve.step[-1]))
    touching = model.tracking.touching if model.tracking else len(contacts)
    places = storage.ContactPlaces(contacts.slave_node[:touching], contacts.interface[:touching])
    storage.write_geometry(store, model.meshes, places)
    draw_moments(store, case, name, wall, bodies, model.meshes, places, curve, valid)


def _fallen_share(wall: Wall, bodies: Bodies, state: Increment) -> str:
    """Return the share of the moving blocks' weight that has fallen, in words; "" where none has."""
    weights = block_weights(wall)
    of_body = np.array([weights[list(body.blocks)].sum() for body in bodies.bodies[: bodies.moving]])
    return percent_of(of_body[state.fallen].sum() / of_body.sum()) if state.fallen.any() else ""


def draw_moments(
    store: storage.StateStore,
    case: Case,
    name: str,
    wall: Wall,
    bodies: Bodies,
    meshes: BodyMeshes,
    places: storage.ContactPlaces,
    curve: PushoverCurve,
    valid: bool,
) -> None:
    """Draw the deformed wall at the end of the curve and at its peak, once where they are one; stamped where the curve
    is not valid."""
    static = curve.static
    moments = {"end": curve.step[-1], "peak": static.step[static.base_shear_N.argmax()]}
    words = {"end": "end", "peak": "peak"}
    if moments["end"] == moments["peak"]:
        del moments["peak"]
        words["end"] = "end, with the largest base shear"
        storage.remove_picture(store.folder.parent / "figures", f"{name}_peak")
    under_gravity, loads = float(curve.control_displacement_m[0]), weight_words(load_sums(wall, case.load))
    ties = shown_ties(wall, bodies, meshes, case.reinforcement.ties)
    for moment, number in moments.items():
        state, title = store.read(int(number)), f"{name} FE at its {words[moment]}"
        weights = f"{loads}, {gone} of it fallen" if (gone := _fallen_share(wall, bodies, state)) else loads
        figure = plots.deformed(
            bodies, meshes, state, places, "",
            under_gravity=under_gravity, moment=title, loads=weights, ties=ties, dead=(wall, case.load.dead),
        )  # fmt: skip
        if not valid:
            plots.stamp_not_valid(figure)
        plots.save(figure, store.folder.parent / "figures", f"{name}_{moment}", case.project.language)


def write_summary(
    output: Path,
    case: Case,
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    partition: Partition,
    curves: Mapping[str, tuple[PushoverCurve, Capacity]],
    pushovers: Sequence[storage.PushoverSummary],
    failed: Mapping[str, str],
) -> storage.Summary:
    """Draw all curves ("macro" and "micro" -> curve, capacity) in one picture; write and return the summary.

    failed: models without a curve, and why.
    """
    reasons = storage.reasons(pushovers)
    draw_curves(output / "figures", case.name, analysis, partition, curves, reasons, case.project.language)
    summary = storage.summarise(case.name, assemblage, analysis, partition, pushovers)
    summary = replace(
        summary,
        seismic=write_verification(output, case, assemblage, analysis, partition, curves, pushovers),
        settings=plain(as_record(case, "blocks.json")),
        blocks_sha256=storage.hash_file(output / "blocks.json"),
        failed=dict(failed) or None,
        files=storage.parts_in(output),
    )
    summary = storage.write_summary(output, summary)
    page.write_verdict(output, page.verdict_of(case, summary))
    page.write(output)
    return summary


def write_verification(
    output: Path,
    case: Case,
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    partition: Partition,
    curves: Mapping[str, tuple[PushoverCurve, Capacity]],
    pushovers: Sequence[storage.PushoverSummary],
) -> dict[str, Any] | None:
    """Verify a run from what it has stored, draw it, and write the curves of the control point; return its part of the
    summary, None where no verification is asked for. Raises CaseError."""
    limit, stones = storage.limit_summary(analysis), stones_of(assemblage)
    entries: dict[str, storage.PushoverSummary] = {pushed.model: pushed for pushed in pushovers}
    models = []
    for name, (curve, capacity) in curves.items():
        store, meshes, contacts = storage.read_geometry(output / name)
        bodies = make_bodies(assemblage, partition if name == "macro" else one_body_per_block(assemblage))
        refused = (
            _refused(entries[name], capacity, curve.stopped_because) or why_not(entries[name], limit, stones) or ""
        )
        tolerance = slip_tolerance_of(bodies, case.elastic, case.contact)
        elastic = constants_of(bodies, case.elastic) if case.elastic.element_order == 1 else None
        seen = (bodies, meshes, contacts.interface, tolerance, elastic, curve.static, store.read, refused)
        models.append(StoredPushover(name, *seen))
    with naming(case.file):
        verified = verify(case.seismic, case.load, case.limit_analysis, assemblage, analysis, models)
    if verified is None:
        return None
    record, observed = verified
    drawn = {name: (seen.displacement, curves[name][0].static.base_shear_N) for name, seen in observed.items()}
    for name, columns in drawn.items():
        storage.write_csv(output / name / "control_point.csv", CONTROL_COLUMNS, list(zip(*columns, strict=True)))
    plots.save(plots.verification(record, drawn), output / "figures", "verification", case.project.language)
    return record


def _refused(pushed: storage.PushoverSummary, capacity: Capacity, stopped: str) -> str:
    """Return why a curve may not be verified, or ""."""
    if not pushed.valid:
        return f"the curve is not valid: {pushed.not_valid_because}"
    if not capacity.peak_reached:
        carried = f"the wall carries at least {capacity.peak_base_shear / 1e3:.4g} kN"
        return f"the curve ends before its peak ({carried}; {stopped}): follow it further"
    return ""


def _capacity_of(pushed: storage.PushoverSummary) -> Capacity:
    """Return the capacity that a run has found, which asks of more than its curve whether there is a peak."""
    return Capacity(**{one.name: getattr(pushed, one.name) for one in fields(Capacity)})


def model_labels(bodies: int) -> dict[str, str]:
    """Return what the models are called in pictures of their curves; bodies: how many macroblocks there are."""
    counted = "1 body" if bodies == 1 else f"{bodies} bodies"
    return {"macro": f"macroblock FE ({counted})", "micro": "micro-FE (every stone)"}


def draw_curves(
    figures: Path,
    name: str,
    analysis: LimitAnalysis,
    partition: Partition,
    curves: Mapping[str, tuple[PushoverCurve, Capacity]],
    reasons: Sequence[str],
    language: Language = "en",
) -> None:
    """Draw all curves in one picture, and their bilinear idealisations in another.

    reasons: why curves are not valid, written into the picture.
    """
    labels = model_labels(partition.count)
    labelled = {labels[model]: curve for model, curve in curves.items()}
    plots.save(plots.curves(labelled, analysis, name, reasons), figures, "curves", language)
    simple = {label: (curve, page.bilinear_of(curve)) for label, (curve, _) in labelled.items()}
    if drawn := {label: (curve, line) for label, (curve, line) in simple.items() if not isinstance(line, str)}:
        figure = plots.idealised(drawn, name)
        if reasons:
            plots.stamp_not_valid(figure)
        plots.save(figure, figures, "bilinear", language)


def rebuild(run: Path) -> Path:
    """Draw all pictures of a finished run again, verify it again and write its report.html, from stored results alone.

    Raises CaseError, before anything is written, for a folder that holds no finished run, or another case than the one
    that was run, and for a verification that is not made.
    """
    stored = read_run(run)
    refuse_verification(stored.case)
    figures, wall, language = run / "figures", stored.assemblage.wall, stored.case.project.language
    write_given(figures, stored.case, stored.assemblage)
    write_mechanism(figures, stored.case, stored.assemblage, stored.analysis)
    plots.save(plots.macroblocks(stored.assemblage, stored.partition), figures, "macroblocks", language)
    for model in stored.models:
        drawn = (wall, model.bodies, model.meshes, model.contacts, model.curve, model.summary.valid)
        draw_moments(model.store, stored.case, model.name, *drawn)
    capacities = {model.name: (model.curve, _capacity_of(model.summary)) for model in stored.models}
    reasons = storage.reasons([model.summary for model in stored.models])
    draw_curves(figures, stored.case.name, stored.analysis, stored.partition, capacities, reasons, language)
    results = (stored.case, stored.assemblage, stored.analysis, stored.partition, capacities, stored.summary.pushover)
    summary = replace(stored.summary, seismic=write_verification(run, *results))
    storage.write_summary(run, summary)
    page.write_verdict(run, page.verdict_of(stored.case, summary))
    return page.write(run)

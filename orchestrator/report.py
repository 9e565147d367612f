"""Values -> run folder and pictures, at the three moments when a run knows something worth keeping."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from orchestrator import plots, results
from orchestrator.bodies import Bodies
from orchestrator.capacity import Capacity
from orchestrator.case import Case, as_toml
from orchestrator.joints import Assemblage
from orchestrator.limit_analysis import LimitAnalysis, LimitState
from orchestrator.macroblocks import Partition
from orchestrator.pushover.state import PushoverCurve

if TYPE_CHECKING:
    from orchestrator.pushover.model import ContactModel


def write_segmentation(
    output: Path, case: Case, assemblage: Assemblage, analysis: LimitAnalysis, partition: Partition, bodies: Bodies
) -> None:
    """Write what is known before the finite elements; the summary of an earlier run goes."""
    output.mkdir(parents=True, exist_ok=True)
    (output / "summary.json").unlink(missing_ok=True)
    results.write_case(output, "\n".join([as_toml(case, "blocks.json"), "# As run, with:", *_provenance(case), ""]))
    results.write_blocks(output, assemblage.wall)
    results.write_joints(output, assemblage)
    results.write_limit_analysis(output, assemblage.wall, analysis)
    results.write_macroblocks(output, assemblage.wall, partition, bodies)
    figures = output / "figures"
    plots.save(plots.blocks(assemblage.wall, numbered=True), figures, "blocks")
    write_mechanism(figures, case, assemblage, analysis)
    plots.save(plots.macroblocks(assemblage, partition), figures, "macroblocks")


def write_mechanism(figures: Path, case: Case, assemblage: Assemblage, analysis: LimitAnalysis) -> list[Path]:
    """Draw the mechanism of the headline state; return the files."""
    figure = plots.mechanism(
        assemblage, analysis.headline, analysis.load_direction, case.load.inclination, f"λ × {case.load.name}"
    )
    return plots.save(figure, figures, "mechanism")


def write_settlement(figures: Path, assemblage: Assemblage, state: LimitState, angle: float) -> list[Path]:
    """Draw the mechanism of a support that gives way at `angle`; return the files."""
    reaction = f"least reaction {-state.load_multiplier / 1e3:.4g} kN"
    figure = plots.mechanism(assemblage, state, 1, angle, "settlement", reaction)
    return plots.save(figure, figures, "settlement")


def _provenance(case: Case) -> list[str]:
    """Return comment lines: versions of everything, hashes of the inputs."""
    lines = [f"# {name} {version}" for name, version in results.versions().items()]
    return lines + [f"# sha256 of {path.name}: {results.hash_file(path)}" for path in (case.file, case.block_file)]


def write_pushover(
    store: results.StateStore, name: str, bodies: Bodies, model: ContactModel, curve: PushoverCurve
) -> None:
    """Write the curve, the ParaView files, and the deformed wall at the end of the curve and at its peak."""
    results.write_curve(store.folder, curve)
    contacts = model.possible
    touching = model.tracking.touching if model.tracking else len(contacts)
    results.write_paraview(store, model.meshes, contacts.point, results.stress_and_pressure(model, bodies))
    moments = {"end": curve.step[-1], "peak": curve.step[curve.base_shear_N.argmax()]}
    for moment, number in moments.items():
        increment, title = store.read(int(number)), f"{name} FE at its {moment}"
        figure = plots.deformed(
            bodies,
            model.meshes,
            increment,
            contacts.point[:touching],
            contacts.slave_body[:touching],
            contacts.master_body[:touching],
            title,
        )
        plots.save(figure, store.folder.parent / "figures", f"{name}_{moment}")


def write_summary(
    output: Path,
    name: str,
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    partition: Partition,
    curves: Mapping[str, tuple[PushoverCurve, Capacity]],
    pushovers: list[dict[str, Any]],
) -> dict[str, Any]:
    """Draw all curves ("macro" and "micro" -> curve, capacity) in one picture; write and return the summary."""
    labels = {"macro": f"macroblock FE ({partition.count} bodies)", "micro": "micro-FE (every stone)"}
    labelled = {labels[model]: curve for model, curve in curves.items()}
    plots.save(plots.curves(labelled, analysis, name), output / "figures", "curves")
    summary = results.summary(name, assemblage, analysis, partition, pushovers)
    results.write_summary(output, summary)
    return summary

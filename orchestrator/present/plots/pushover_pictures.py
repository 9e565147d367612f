"""Pictures of the pushover: the deformed wall with the state of its joints, and the capacity curves."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import floor, log10

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import AbstractPathEffect, withStroke

from orchestrator.assessment.capacity import Bilinear, Capacity
from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.basis.printed import marked, printed
from orchestrator.limit_analysis.paper.limit_state import LimitAnalysis
from orchestrator.loads.dead_loads import DeadLoad
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.masonry.wall import Wall
from orchestrator.present.joint_pieces import (
    DAMAGED,
    HAIRLINE,
    NO_STATE,
    THIN,
    front_loops,
    interface_pieces,
    shown_displacement,
    status_of_pieces,
)
from orchestrator.present.plots.canvas import (
    BLUE,
    FAINT,
    GREEN,
    INK,
    ORANGE,
    PURPLE,
    STONE,
    VERMILLION,
    draw_segments,
    draw_supports,
    stamp_not_valid,
    wall_figure,
)
from orchestrator.present.plots.load_arrows import draw_dead_load
from orchestrator.present.plots.words import legend_below, write_title
from orchestrator.present.tie_states import ShownTies, State
from orchestrator.present.weights import multiplied, weight_words
from orchestrator.pushover.increments import ContactStatus, Increment, PushoverCurve
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.storage import ContactPlaces

DRAWN_DISPLACEMENT = 0.06
"""largest displacement of a drawn deformed wall, part of the wall's height, where no factor is given"""
LINES = {
    ContactStatus.STICK: (INK, 0.8, "closed (stick)"),
    ContactStatus.SLIP: (BLUE, 2.0, "slipping"),
    THIN: (VERMILLION, 0.8, f"open by less than {1e3 * HAIRLINE:g} mm"),
    ContactStatus.OPEN: (VERMILLION, 2.2, "open"),
}
TIES: dict[State, tuple[str, float, str]] = {
    "slack": (GREEN, 1.0, "--"), "taut": (GREEN, 2.2, "-"), "yields": (PURPLE, 3.2, "-"),
}  # fmt: skip
FELL = "fallen: where it stood"
BAND = 6.0
"""points; width of the band under a damaged joint"""
MODELS = ((BLUE, "-"), (VERMILLION, "--"), (GREEN, "-."), (PURPLE, ":"))


def deformed(
    bodies: Bodies,
    meshes: BodyMeshes,
    increment: Increment,
    contacts: ContactPlaces,
    name: str,
    amplification: float | None = None,
    under_gravity: float = 0.0,
    moment: str = "",
    loads: str = "",
    ties: ShownTies | None = None,
    dead: tuple[Wall, Sequence[DeadLoad]] | None = None,
) -> Figure:
    """Draw the outline of every body at z = 0, displaced times `amplification`, and its contacts coloured by status.

    Bodies that have fallen are pale outlines where they stood, without joints and loads. Bonded joints that are damaged
    have a band under them whose colour is their degree of damage.

    Without `amplification` it is chosen so that the picture can be read (1, 2 or 5 times a power of
    ten, never below 1). under_gravity: control displacement (m) that the one in the title is counted from. moment:
    what the title begins with; loads: weights in words. ties: drawn with their forces. dead: extra loads of a wall,
    whose arrows move with the nearest nodes of their bodies.
    """
    plane = shown_displacement(meshes, increment)
    supports = [body.exterior for body in bodies.bodies[bodies.moving :]]
    height = float(np.ptp(meshes.nodes[:, 1]))
    factor = amplification or readable_factor(DRAWN_DISPLACEMENT * height, float(np.abs(plane).max()))
    moved = meshes.nodes[:, :2] + factor * plane
    title = _title(moment, increment, loads, under_gravity, factor)
    bars = np.empty((0, 2, 2)) if ties is None else ties.ends + factor * ties.moved(increment)
    figure, axes = wall_figure(np.vstack([moved, *supports, bars.reshape(-1, 2)]), title, name)
    for number in np.flatnonzero(~increment.fallen).tolist():
        axes.add_patch(PathPatch(outline(meshes, number, moved), facecolor=STONE, edgecolor="#888888", linewidth=0.5))
    for number in (fallen := np.flatnonzero(increment.fallen).tolist()):
        left = PathPatch(outline(meshes, number, moved), fill=False, edgecolor=FAINT, linestyle="--", linewidth=0.8)
        axes.add_patch(left).set_label(FELL if number == fallen[0] else "_")
    draw_supports(axes, supports)
    pieces = interface_pieces(bodies, meshes, contacts)
    status = status_of_pieces(bodies, contacts, pieces[0], increment)
    _draw_contacts(axes, pieces, status, increment.damage, moved[contacts.slave_node])
    if ties is not None:
        _draw_ties(axes, bars, increment.tie_force, ties.states(increment))
    if dead is not None and dead[1]:
        draw_dead_load(axes, *dead, _carried_by(bodies, meshes, factor * plane, increment.fallen)).set_label(
            "extra dead loads"
        )
    legend_below(axes, 3)
    return figure


def curves(
    models: Mapping[str, tuple[PushoverCurve, Capacity]],
    analysis: LimitAnalysis,
    name: str,
    not_valid: Sequence[str] = (),
) -> Figure:
    """Draw base shear against control displacement of all `models` (label -> curve, capacity), and micro-LA.

    Displacements are relative to the state under gravity; the second axis is base shear / weight. not_valid: the
    reasons why a curve is not, which nobody who sees the picture can then overlook.
    """
    figure = Figure(figsize=(7.0, 5.2), layout="constrained")
    axes = figure.add_subplot()
    for (label, (curve, capacity)), (colour, style) in zip(models.items(), MODELS * len(models), strict=False):
        draw_curve(axes, curve, colour, style, label)
        peak = (1e3 * capacity.displacement_at_peak, capacity.peak_base_shear / 1e3)
        least = ("≥ ", "≥") if not capacity.peak_reached and not not_valid else ("", "=")
        said = f"peak {least[0]}{printed('force', capacity.peak_base_shear)} kN (λ {least[1]} "
        fell = curve.static.fallen_bodies[np.argmax(curve.static.base_shear_N)] > 0
        said += f"{printed('multiplier', capacity.peak_multiplier)}{' of what is left' * bool(fell)}) at "
        said += f"{printed('displacement', capacity.displacement_at_peak)} mm"
        axes.plot(*peak, "o", color=colour, markeredgecolor="white", markersize=8, label=said, zorder=4)
    draw_limit_analysis(axes, analysis)
    _frame_curves(axes)
    kilonewtons = analysis.headline.horizontal_load / 1e3
    multiplier = axes.secondary_yaxis("right", functions=(_times(1.0 / kilonewtons), _times(kilonewtons)))
    left = " of what is left" if analysis.local_failures else ""
    multiplier.set_ylabel(f"λ = base shear / {multiplied(analysis)}{left}")
    direction = "+x" if analysis.loads.direction[0] > 0 else "−x"
    wrong = [f"NOT VALID: {reason}" for reason in not_valid]
    head = f"Pushover along {direction}: {weight_words(analysis)}"
    write_title(axes, "\n".join([head, *wrong]), name)
    if wrong:
        stamp_not_valid(axes)
    legend_below(axes, 2)
    return figure


def draw_curve(axes: Axes, curve: PushoverCurve, colour: str, style: str, label: str, width: float = 1.8) -> None:
    """Draw the static states of a curve, its motion between them as thin dots, a cross where a part began to fall.

    The axis reaches as far as the static states of all curves do, either way from the state under gravity.
    """
    moved = 1e3 * (curve.control_displacement_m - curve.control_displacement_m[0])
    shear, moving = curve.base_shear_N / 1e3, curve.moving == 1
    static = np.where(moving, np.nan, shear)
    axes.plot(moved, static, style, color=colour, linewidth=width, label=label)
    drawn = axes.get_xlim() if len(axes.get_lines()) > 1 else (0.0, 0.0)
    ends = np.array([shown_from(curve), 1.05 * float(moved[~moving].max()), *drawn])
    if np.ptp(ends) > 0.0:
        axes.set_xlim(ends.min(), ends.max())  # what falls goes far beyond the wall's own displacements
    if moving.any():
        near = moving | np.append(moving[1:], False) | np.append(False, moving[:-1])
        axes.plot(moved, np.where(near, shear, np.nan), ":", color=colour, linewidth=0.8, label=f"{label}, in motion")
    rows = np.arange(len(moved))
    last = np.maximum.accumulate(np.where(moving, 0, rows))
    if (fell := last[1:][np.diff(curve.fallen_bodies) > 0]).size:
        axes.plot(moved[fell], shear[fell], "x", color=colour, markersize=6, label=f"{label}, a part falls")


def shown_from(curve: PushoverCurve) -> float:
    """Return where an axis of displacements begins, mm: at the state under gravity, or behind what goes against the
    load."""
    at_rest = curve.static.control_displacement_m
    return 1.05e3 * float((at_rest - at_rest[0]).min())


def rigid_pushover(analysis: LimitAnalysis) -> Figure:
    """Draw the curve of rigid blocks in large displacements with the multipliers of limit analysis."""
    assert analysis.rigid_curve is not None
    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    axes = figure.add_subplot()
    moved, multiplier = analysis.rigid_curve.T
    peak = printed("multiplier", float(multiplier.max()))
    force = multiplier * load_in_kilonewtons(analysis)
    axes.plot(1e3 * moved, force, color=BLUE, linewidth=1.8, label=f"rigid blocks: λ = {peak} at most")
    draw_limit_analysis(axes, analysis)
    _frame_curves(axes)
    axes.set_xlabel("mean displacement of the loads (mm)")
    if analysis.upright_load is not None:
        axes.set_ylabel("live load (kN)")
    axes.set_xlim(0.0, 1e3 * float(moved.max()))
    head = f"Rigid blocks in large displacements: {weight_words(analysis)}"
    write_title(axes, f"{head}\nE = {analysis.elastic_modulus / 1e9:g} GPa", "")
    legend_below(axes, 2)
    return figure


def readable_factor(drawn: float, largest: float) -> float:
    """Return 1, 2 or 5 times a power of ten, at least 1, so that factor x `largest` is at most `drawn` (both m)."""
    if largest == 0.0 or drawn <= largest:
        return 1.0
    power = 10.0 ** floor(log10(drawn / largest))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= drawn / largest)


def _title(moment: str, increment: Increment, loads: str, under_gravity: float, factor: float) -> str:
    """Return which moment is drawn, its state, the loads (none: not said), and how it is drawn."""
    multiplier, shear = printed("multiplier", increment.load_multiplier), printed("force", increment.base_shear)
    control = printed("displacement", increment.control_displacement - under_gravity)
    drawn = f"control displacement {control} mm, displacements drawn × {factor:g}"
    state = f"Load multiplier {multiplier}, base shear {shear} kN"
    return "\n".join(filter(None, [moment, state, loads, drawn]))


def _carried_by(
    bodies: Bodies, meshes: BodyMeshes, moved: FloatArray, fallen: BoolArray
) -> Callable[[int, FloatArray], FloatArray]:
    """Return where points (p, 2) of a block go that move as the nearest nodes of its body, by `moved` (m, 2); none of
    a body that has fallen."""
    body_of = {block: number for number, body in enumerate(bodies.bodies) for block in body.blocks}

    def carried(block: int, points: FloatArray) -> FloatArray:
        if fallen[body_of[block]]:
            return points[:0]
        nodes = np.flatnonzero(meshes.body_of_node == body_of[block])
        apart = np.linalg.norm(points[:, None] - meshes.nodes[None, nodes, :2], axis=2)
        return points + moved[nodes[apart.argmin(axis=1)]]

    return carried


def outline(meshes: BodyMeshes, body: int, positions: FloatArray) -> Path:
    """Return the closed outlines, holes included, of a body's face at z = 0, with nodes at `positions` (m, 2)."""
    loops = front_loops(meshes, body)
    return Path.make_compound_path(*(Path(positions[[*loop, loop[0]]], closed=True) for loop in loops))


def idealised(models: Mapping[str, tuple[PushoverCurve, Bilinear]], name: str) -> Figure:
    """Draw base shear against control displacement of all `models` (label -> curve, bilinear) with the bilinear."""
    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    axes = figure.add_subplot()
    for (label, (curve, bilinear)), (colour, style) in zip(models.items(), MODELS * len(models), strict=False):
        draw_curve(axes, curve, colour, style, label, 1.0)
        corners = 1e3 * np.array([0.0, bilinear.yield_displacement, bilinear.ultimate_displacement])
        force = bilinear.yield_force / 1e3
        ends = (bilinear.yield_displacement, bilinear.ultimate_displacement)
        first, last = (printed("displacement", end) for end in ends)
        said = f"bilinear: {printed('force', bilinear.yield_force)} kN, yields at {first} mm, ends at {last} mm"
        axes.plot(corners, [0.0, force, force], style, color=colour, linewidth=2.2, marker="s", ms=5, label=said)
    _frame_curves(axes)
    write_title(axes, "Bilinear idealisation", name)
    legend_below(axes, 2)
    return figure


def _draw_contacts(
    axes: Axes,
    pieces_of_joints: tuple[IntArray, IntArray, IntArray],
    status: IntArray,
    damages: FloatArray,
    drawn: FloatArray,
) -> None:
    """Draw every interface on its slave's displaced face (`drawn` (c, 2): displaced contacts), its pieces coloured by
    their status (p,); damages (c,) of the contacts."""
    contact, before, after = pieces_of_joints
    corners = np.stack([0.5 * (drawn[before] + drawn[contact]), 0.5 * (drawn[contact] + drawn[after])], axis=1)
    pieces = {name: corners[status == name] for name in LINES}
    for name, (colour, width, label) in LINES.items():
        draw_segments(axes, pieces[name], colour, width, label)
    damage = np.where(status == NO_STATE, 0.0, damages[contact])
    if (damaged := damage > DAMAGED).any():
        _draw_damage(axes, corners[damaged], damage[damaged])


def _draw_ties(axes: Axes, bars: FloatArray, force: FloatArray, states: Sequence[State]) -> None:
    """Draw ties (m, 2, 2) in m by what they do, each with its force (m,) in N over its middle."""
    for state, (colour, width, dashes) in TIES.items():
        chosen = bars[[one == state for one in states]]
        if len(chosen):
            draw_segments(axes, chosen, colour, width, f"tie, {state}").set_linestyle(dashes)
    halo: list[AbstractPathEffect] = [withStroke(linewidth=2.0, foreground="white", alpha=0.8)]
    for bar, pull in zip(bars, force.tolist(), strict=True):
        said, (x, y) = f"{printed('force', pull)} kN", bar.mean(axis=0).tolist()
        above = axes.annotate(said, (x, y), (0, 3), textcoords="offset points", ha="center", fontsize=8, zorder=6)
        above.set_path_effects(halo)


def _draw_damage(axes: Axes, segments: FloatArray, damage: FloatArray) -> None:
    """Draw a band under the damaged pieces (k, 2, 2) of joints, coloured by their damage (k,), and its scale."""
    band = LineCollection(list(segments), array=damage, cmap="YlGnBu", clim=(0.0, 1.0), linewidths=BAND, zorder=2)
    axes.add_collection(band, autolim=False)
    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.colorbar(band, ax=axes, shrink=0.5, label="damage of bonded joints (1: broken)")


def _frame_curves(axes: Axes) -> None:
    """Label and grid axes of base shear over control displacement, whose curves are drawn; forces begin at none."""
    axes.set_xlabel("control displacement (mm)")
    axes.set_ylabel("base shear (kN)")
    axes.set_ylim(0.0, 1.08 * axes.get_ylim()[1])
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)


def _times(factor: float) -> Callable[[npt.ArrayLike], npt.ArrayLike]:
    return lambda values: np.asarray(values) * factor


def load_in_kilonewtons(analysis: LimitAnalysis) -> float:
    """Return the base shear at a multiplier of 1, or the live load where none of it is horizontal, in kN."""
    upright = analysis.upright_load
    return (analysis.headline.horizontal_load if upright is None else abs(upright)) / 1e3


def draw_limit_analysis(axes: Axes, analysis: LimitAnalysis) -> None:
    """Draw the multipliers of micro limit analysis as base shear or upright live load in kN."""
    kilonewtons = load_in_kilonewtons(analysis)
    associative, headline = analysis.bound, analysis.headline
    which = "" if analysis.associative_left is None else " (without loose stones)"
    said = f"micro-LA, associative{which}: λ = {printed('multiplier', associative.load_multiplier)}"
    axes.axhline(associative.load_multiplier * kilonewtons, color=INK, linestyle=":", linewidth=1.2, label=said)
    interval = analysis.non_associative_range
    if interval is None:
        return
    said = f"micro-LA, {headline.name}: λ = {marked('multiplier', headline.load_multiplier, headline.converged)}"
    axes.axhline(headline.load_multiplier * kilonewtons, color=INK, linestyle="--", linewidth=1.2, label=said)
    low, high = (printed("multiplier", end) for end in interval)
    if low != high:
        said = f"micro-LA, non-associative range: λ = {low} to {high}"
        axes.axhspan(
            interval[0] * kilonewtons, interval[1] * kilonewtons, color=ORANGE, alpha=0.35, linewidth=0, label=said
        )

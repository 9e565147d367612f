"""What a page and the terminal say of a wall in space, in rows of a name and a value."""

from __future__ import annotations

from math import isfinite

import numpy as np

from orchestrator.assessment.seismic.in_space import (
    StartsAt,
    is_part_of_gravity,
    not_accelerated_in_space,
    starts_at,
)
from orchestrator.assessment.seismic.kinematic import LOW_PARTICIPATION
from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.printed import counted, printed
from orchestrator.loads.block_loads import Distribution
from orchestrator.masonry.wall import GRAVITY
from orchestrator.present.weights import applied
from orchestrator.settings.space_case import SpaceCase
from orchestrator.settings.space_inventory import direction_words, load_sums
from orchestrator.space.analysis import BRACKET
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.equilibrium import Torsion
from orchestrator.space.found import SpaceAnalysis
from orchestrator.space.loads import SpaceLoads, SpaceLoadSettings, direction_of
from orchestrator.space.mechanism import Motion, SpaceMechanism
from orchestrator.space.ties import TieForce, tie_forces
from orchestrator.space.wall import SpaceWall

HELD = "held"
"""what is said where no load moves the wall"""
KINEMATIC = "kinematic verification (Circular 7/2019 C8.7.1.2), confidence factor 1"
TWISTS: dict[Torsion, str] = {"corners": "forces at corners", "uniform": "uniform pressure"}
"""under what joints twist"""
DISTRIBUTIONS: dict[Distribution, str] = {
    "mass": "proportional to mass",
    "mass_height": "proportional to mass × height above the base",
    "per_block": "given block by block",
}


def torsions_differ(analysis: SpaceAnalysis) -> bool:
    """Return whether both ways of twisting have bounds that are told apart."""
    one, other = analysis.bound, analysis.other_torsion
    return abs(one - other) > BRACKET * min(one, other)


def bound_words(multiplier: float, digits: int) -> str:
    """Return a multiplier, or that it is infinite: no load moves the wall."""
    return f"{multiplier:.{digits}f}" if isfinite(multiplier) else HELD


def figures(analysis: SpaceAnalysis) -> list[tuple[str, str]]:
    """Return the multipliers and what is applied at the one that counts."""
    headline, interval = analysis.headline, analysis.range
    none = "not looked for" if analysis.looked_for == "none" else "no state found"
    rows = [("associative multiplier (bound)", bound_words(analysis.bound, 4))]
    if torsions_differ(analysis):
        other = TWISTS["uniform" if analysis.torsion == "corners" else "corners"]
        rows.append((f"the same, joints twist as under {other}", bound_words(analysis.other_torsion, 4)))
    shown = ("({:.4f})" if headline.nearly else "{:.4f}").format(headline.load_multiplier) if headline else none
    rows.append(("without dilation", shown))
    if interval:
        rows.append(("without dilation, lowest and highest found", f"{interval[0]:.4f} – {interval[1]:.4f}"))
    name, size = applied(analysis.shown.load_multiplier, analysis.horizontal_load, analysis.upright_load)
    return [*rows, (name if headline else f"{name} (associative)", size)]


def load_words(assemblage: SpaceAssemblage, loads: SpaceLoads) -> str:
    """Return the direction of the live load in words."""
    return f"direction of the live load: {direction_words(loads.direction, assemblage.wall.up)}"


def wall_rows(case: SpaceCase, assemblage: SpaceAssemblage) -> list[tuple[str, str]]:
    """Return how many blocks, supports and joints there are, what they weigh, and under which loads they are."""
    wall, joints = assemblage.wall, assemblage.joints
    free, ties = ~wall.fixed, int(joints.is_tie.sum())
    counts = {"blocks": int(free.sum()), "supports": int(wall.fixed.sum()), "joints": joints.count - ties}
    counts |= {"ties": ties} if ties else {}
    unit_weights = np.array([block.unit_weight for block, moves in zip(wall.blocks, free, strict=True) if moves])
    return [
        (", ".join(counts), ", ".join(map(str, counts.values()))),
        ("weight", f"{wall.weights[free].sum() / 1e3:.3f} kN"),
        ("unit weight", f"{_values(unit_weights / 1e3)} kN/m³"),
        ("friction coefficient", _values(joints.friction[~joints.is_tie])),
        ("joints twist as under", TWISTS[case.limit_analysis.torsion]),
        *load_rows(wall, case.load),
    ]


def load_rows(wall: SpaceWall, load: SpaceLoadSettings) -> list[tuple[str, str]]:
    """Return direction and distribution of the live load, and every extra dead load."""
    dead = [
        ("dead load", f"{one.name}; in all {one.resultant / 1e3:.3f} kN, {'with' if one.inertia else 'without'} mass")
        for one in load_sums(wall, load).extra
    ]
    return [
        ("direction of the live load", direction_words(direction_of(load, wall.up), wall.up)),
        ("distribution of the live load", DISTRIBUTIONS[load.distribution]),
        *dead,
    ]


def _values(values: FloatArray) -> str:
    """Return the lowest and the highest of some values, one where both are told alike."""
    return " – ".join(dict.fromkeys(f"{value:.4g}" for value in (values.min(), values.max())))


def mechanism_rows(analysis: SpaceAnalysis, mechanism: SpaceMechanism) -> list[tuple[str, str]]:
    """Return what the mechanism does, in words, and every tie."""
    wall = analysis.assemblage.wall
    moving = mechanism.moving
    share, bodies = wall.weights[moving].sum() / analysis.weight, int(mechanism.body.max())
    several = "body" if bodies == 1 else "bodies"
    motions: dict[Motion, str] = {"hinges": "hinge", "opens": "open", "slides": "slide", "twists": "twist"}
    kinds = ", ".join(f"{mechanism.count(kind)} {word}" for kind, word in motions.items())
    return [
        (
            "moving",
            f"{counted(len(moving), 'block')} ({100 * share:.0f} % of the weight) in {bodies} {several}",
        ),
        ("joints", kinds),
        *((f"tie {tie.number}", _tie_words(tie)) for tie in tie_forces(analysis.assemblage, analysis.shown.forces)),
    ]


def _tie_words(tie: TieForce) -> str:
    return f"{printed('force', tie.pull)} kN of {printed('force', tie.strength)} kN, {tie.state}"


def kinematic_rows(case: SpaceCase, analysis: SpaceAnalysis) -> list[tuple[str, str]]:
    """Return at which acceleration the mechanism of the lowest state starts, or why that is not known; nothing where
    no kinematic verification is made."""
    if not is_verified(case):
        return []
    found = starts_at(case.load, analysis)
    return [(KINEMATIC, f"not made: {found}" if isinstance(found, str) else _start_words(found))]


def is_verified(case: SpaceCase) -> bool:
    """Return whether a case has a kinematic verification: its load is a part of gravity, and it has no ties."""
    return is_part_of_gravity(case.wall, case.load) and not case.reinforcement.ties


def without_mass(case: SpaceCase) -> list[str]:
    """Return the warning of dead loads without mass, where a kinematic verification is made."""
    return not_accelerated_in_space(case.wall, case.load) if is_verified(case) else []


def _start_words(found: StartsAt) -> str:
    low = f" is below {LOW_PARTICIPATION:g}, and counts as 1" * (found.used != found.participation)
    start = f"{found.acceleration:.3f} m/s2 ({found.acceleration / GRAVITY:.3f} g)"
    of_state = f"of the lowest state found, λ = {found.multiplier:.4f}"
    return f"e* = {found.participation:.3f}{low}; a0* = λ g / e* = {start}, {of_state}"

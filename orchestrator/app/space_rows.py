"""What a page and the terminal say of a wall in space, in rows of a name and a value."""

from __future__ import annotations

from orchestrator.assessment.seismic.in_space import (
    StartsAt,
    is_part_of_gravity,
    not_accelerated_in_space,
    starts_at,
)
from orchestrator.assessment.seismic.kinematic import LOW_PARTICIPATION
from orchestrator.basis.printed import counted
from orchestrator.masonry.wall import GRAVITY
from orchestrator.present.weights import applied
from orchestrator.settings.space_case import SpaceCase
from orchestrator.settings.space_inventory import direction_words
from orchestrator.space.analysis import BRACKET, SpaceAnalysis
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.loads import SpaceLoads
from orchestrator.space.mechanism import Motion, SpaceMechanism

KINEMATIC = "kinematic verification (Circular 7/2019 C8.7.1.2), confidence factor 1"


def torsions_differ(analysis: SpaceAnalysis) -> bool:
    """Return whether both ways of twisting have bounds that are told apart."""
    one, other = analysis.associative.load_multiplier, analysis.other_torsion
    return abs(one - other) > BRACKET * abs(one)


def figures(analysis: SpaceAnalysis) -> list[tuple[str, str]]:
    """Return the multipliers and what is applied at the one that counts."""
    headline, interval = analysis.headline, analysis.range
    none = "not looked for" if analysis.looked_for == "none" else "no state found"
    rows = [("associative multiplier (bound)", f"{analysis.associative.load_multiplier:.4f}")]
    if torsions_differ(analysis):
        other = "uniform pressure" if analysis.torsion == "corners" else "forces at corners"
        rows.append((f"the same, joints twist as under {other}", f"{analysis.other_torsion:.4f}"))
    rows.append(("without dilation", f"{headline.load_multiplier:.4f}" if headline else none))
    if interval:
        rows.append(("without dilation, lowest and highest found", f"{interval[0]:.4f} – {interval[1]:.4f}"))
    name, size = applied(analysis.shown.load_multiplier, analysis.horizontal_load, analysis.upright_load)
    return [*rows, (name if headline else f"{name} (associative)", size)]


def load_words(assemblage: SpaceAssemblage, loads: SpaceLoads) -> str:
    """Return the direction of the live load in words."""
    return f"direction of the live load: {direction_words(loads.direction, assemblage.wall.up)}"


def wall_rows(assemblage: SpaceAssemblage) -> list[tuple[str, str]]:
    """Return how many blocks, supports and joints there are, and what they weigh."""
    wall = assemblage.wall
    free = ~wall.fixed
    return [
        ("blocks, supports, joints", f"{int(free.sum())}, {int(wall.fixed.sum())}, {assemblage.joints.count}"),
        ("weight", f"{wall.weights[free].sum() / 1e3:.3f} kN"),
    ]


def mechanism_rows(analysis: SpaceAnalysis, mechanism: SpaceMechanism) -> list[tuple[str, str]]:
    """Return what the mechanism does, in words."""
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
    ]


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

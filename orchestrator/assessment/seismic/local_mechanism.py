"""The mechanism of micro limit analysis on which the kinematic approach rests, with what moves in it.

It is that of the lowest non-associative state found, that of stones which come loose before the wall fails included,
under a horizontal load proportional to mass; another load is analysed anew for that one, because alpha_0 is a part of g
only there.

Bond (cohesion and tensile strength of joints) bears until it opens: the mechanism starts (SLD) at alpha_0 with it. What
rocks has opened its joints, and a bond that has opened bears nothing. So q at SLV, d_0* and a(d) are of the wall in
which the joints that open or slip in the mechanism have neither cohesion nor tensile strength, analysed anew; joints
that stay closed keep theirs.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from math import inf

import numpy as np

from orchestrator.assessment.seismic.kinematic import Kinematics, Moving, kinematics
from orchestrator.basis.arrays import FloatArray, IntArray, read_only
from orchestrator.basis.errors import CaseError, ConvergenceError
from orchestrator.basis.printed import printed
from orchestrator.geometry.rigid import velocity_of_points
from orchestrator.limit_analysis import LimitAnalysis, LimitAnalysisSettings, LimitState, Mechanism, analyse
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.loads.block_loads import extra_dead_loads, live_loads
from orchestrator.macroblocks.criteria import MacroblockSettings, merged
from orchestrator.masonry.block_properties import block_centroids
from orchestrator.masonry.joints import Assemblage

AS_ONE = MacroblockSettings(choose="tolerances", evaluate_at="ends", tol_n=1e-3, tol_s=1e-3, tol_d=inf)
"""neighbours move as one where their joint opens and slips by less than this part of the largest displacement"""
UPPER_BOUND = (
    "no non-associative state was found: the associative multiplier is an upper bound, and walls that fall under their "
    "own weight can have one"
)
STANDING_OPEN = "whether the wall stands is open: stones go down under the dead load unless they are wedged"
"""why there is no mechanism to rest on where more than a local part goes down"""
WEDGED = "of the wall without the stones that go down under the dead load unless they are wedged"
"""of which wall a mechanism is where limit analysis has taken such stones away"""
OPENED = "once its bond has opened"
"""how a refusal begins of a wall of which no more is known than where it starts to move"""


@dataclass(frozen=True, eq=False, slots=True)
class InMechanism:
    """A mechanism with what moves in it: all masses the live load acts on, all dead loads; remarks say what was done.

    state: what it is the mechanism of, in words. opened: the mechanism once the bond that it opens is gone, or why
    there is none to rest on; None where it opens no bond.
    """

    state: str
    kinematics: Kinematics
    remarks: tuple[str, ...]
    opened: InMechanism | str | None = None


def safest_state(analysis: LimitAnalysis) -> LimitState | None:
    """Return the lowest non-associative state, None where there is none.

    Stones that come loose before the wall fails are such a state: what they fall on is not asked. So is a last rest
    that no limit state closed, lest a higher state found elsewhere stands for a wall of which that is not known. Stones
    that go down under the dead load, as nothing but a wedge holds them, have no state.
    """
    others = [state for state in (analysis.lowest, analysis.sequence) if state is not None and state.converged]
    loose = [failure.state for failure in analysis.local_failures if not failure.under_dead_load]
    states = [*loose, *filter(None, [analysis.path]), *others]
    return min(states, key=lambda state: state.load_multiplier, default=None)


def loads_in_mechanism(
    assemblage: Assemblage, load: LoadSettings, settings: LimitAnalysisSettings, analysis: LimitAnalysis
) -> InMechanism | str:
    """Return the lowest state's mechanism with its masses, analysed anew where the load is not horizontal and
    proportional to mass; or why there is none to rest on."""
    by_mass = replace(load, distribution="mass", inclination=0.0, live=(), cases=())
    remarks: tuple[str, ...] = ()
    if (load.distribution, load.inclination) != ("mass", 0.0):
        try:
            by_mass_on = loads_on(assemblage.wall, by_mass)
            analysis = analyse(assemblage, settings, by_mass_on, analysis.elastic_modulus)
        except (CaseError, ConvergenceError) as error:
            return f"under a horizontal load proportional to mass: {error}"
        remarks = ("analysed for a horizontal load proportional to mass, not for the load of this case",)
    if analysis.going_down:
        return STANDING_OPEN
    if any(failure.under_dead_load for failure in analysis.local_failures):
        remarks = (*remarks, WEDGED)
    state = safest_state(analysis)
    if state is None:
        return UPPER_BOUND
    found = _mechanism_of(assemblage, by_mass, state, remarks + said_of(state, analysis))
    return replace(found, opened=_opened(assemblage, by_mass, settings, analysis, remarks))


def _opened(
    assemblage: Assemblage,
    by_mass: LoadSettings,
    settings: LimitAnalysisSettings,
    analysis: LimitAnalysis,
    remarks: tuple[str, ...],
) -> InMechanism | str | None:
    """Return the mechanism of a wall once the bond that it opens is gone, or why there is none; None if it opens none.

    The wall without it may fail another way, and open more: it is analysed until its mechanism opens no bond.
    """
    start = state = safest_state(analysis)
    while state is not None and (parted := with_bond_opened(assemblage, state.mechanism)) is not None:
        assemblage = parted
        try:
            analysis = analyse(parted, settings, loads_on(parted.wall, by_mass), analysis.elastic_modulus)
        except CaseError as error:
            return f"{OPENED}: {error.problem}"
        except ConvergenceError as error:
            return f"{OPENED}: {error}"
        state = safest_state(analysis)
    if state is start:
        return None
    if state is None or start is None:
        return f"{OPENED}: {UPPER_BOUND}"
    then, first = (printed("multiplier", one.load_multiplier) for one in (state, start))
    said = f"a bond that has opened bears nothing: alpha_0 = {then} then, {first} to open it"
    return _mechanism_of(assemblage, by_mass, state, (*remarks, *said_of(state, analysis), said))


def _mechanism_of(
    assemblage: Assemblage, load: LoadSettings, state: LimitState, remarks: tuple[str, ...]
) -> InMechanism:
    """Return the mechanism of a state under a load proportional to mass."""
    masses, dead = moving_loads(assemblage, load, state.mechanism)
    stones = np.concatenate([block.polygon for block in assemblage.wall.blocks if not block.fixed])
    reach = float(np.hypot(*np.ptp(stones, axis=0)))
    return InMechanism(state.name, kinematics(state.load_multiplier, masses, dead, load.vector, reach), remarks)


def with_bond_opened(assemblage: Assemblage, mechanism: Mechanism) -> Assemblage | None:
    """Return the wall in which joints that open or slip in a mechanism have neither cohesion nor tensile strength, None
    where none of them had any."""
    joints, scaled = assemblage.joints, mechanism.scaled(AS_ONE.scale)
    moves = (np.abs(scaled.opening).max(axis=1) > AS_ONE.tol_n) | (np.abs(scaled.slip) > AS_ONE.tol_s)
    parts = moves & ((joints.cohesion > 0.0) | (joints.tensile_strength > 0.0))
    if not parts.any():
        return None
    cohesion, tension = (read_only(np.where(parts, 0.0, one)) for one in (joints.cohesion, joints.tensile_strength))
    return replace(assemblage, joints=replace(joints, cohesion=cohesion, tensile_strength=tension))


def said_of(state: LimitState, analysis: LimitAnalysis) -> tuple[str, ...]:
    """Return what must be said beside a mechanism that is not simply that of the wall's limit state."""
    local = next((failure for failure in analysis.local_failures if failure.state is state), None)
    if local is not None:
        stones = ", ".join(map(str, local.stones))
        share = f"{100 * local.share:.2g} % of the dead load"
        single = len(local.stones) == 1
        said = f"stone {stones} ({share}) moves" if single else f"stones {stones} ({share}) move"
        return (f"a local failure: {said}, not the wall",)
    if state.converged:
        return ()
    if state.flow_rule == "large_displacements":
        return ("alpha_0 is the peak in large displacements: it lies below the collapse state of the wall as drawn",)
    return ("alpha_0 is the last load at which the wall rests: no limit state was closed",)


def moving_loads(assemblage: Assemblage, load: LoadSettings, mechanism: Mechanism) -> tuple[Moving, Moving]:
    """Return the masses that a load proportional to mass acts on, and all dead loads, with their velocities.

    Stones that move as one are one body; the floors that one body carries are another one, at their own place (the Q_k
    of C8.7.1.2.1.1 beside its P_k).
    """
    wall = assemblage.wall
    live, extra = live_loads(wall, load), extra_dead_loads(wall, load.dead)
    stones = sum(not block.fixed for block in wall.blocks)
    body = merged(assemblage, mechanism, AS_ONE).body_of_block
    number = body[live.block] + np.where(np.arange(len(live.block)) < stones, 0, body.max() + 1)
    own, velocity = slice(0, stones), partial(_velocity_at, assemblage, mechanism)
    masses = Moving(live.size, velocity(live.block, live.point), number)
    block, point = np.append(live.block[own], extra.block), np.vstack([live.point[own], extra.point])
    return masses, Moving(np.append(live.size[own], extra.size), velocity(block, point), body[block])


def _velocity_at(assemblage: Assemblage, mechanism: Mechanism, block: IntArray, point: FloatArray) -> FloatArray:
    """Return the velocities (p, 3) of points (p, 2) of blocks (p,)."""
    of_block = mechanism.velocities[block]
    arm = point - block_centroids(assemblage.wall)[block]
    return np.column_stack([velocity_of_points(of_block, arm), of_block[:, 2]])

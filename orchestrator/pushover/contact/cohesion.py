"""Bonded joints: tension and cohesion that soften, besides Coulomb friction (numpy only).

A contact of tributary area A carries, with f_t no more than c / mu (where Coulomb's cone ends) and damage d,

    tension     p >= -T,  T = (1 - d) f_t A        p: net normal force, N, positive in compression
    shear       |tau| <= max(mu p + (1 - d) c A, 0)
    damage      d = the larger of opening and plastic slip over the softening displacement, never less than before

so that 0 <= p + T, 0 <= gap, and their product is zero: the complementarity of contact with a force shifted by T. The
joint is rigid until T is reached. A crack that closes again does so under the T that is left. A joint that only opens
dissipates G_I = f_t delta / 2 per area, one that only slides G_II = c delta / 2 besides friction.

Dissipation of the normal part: the free energy T(d) opening has the force f_t A x opening on the damage.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, read_only
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.pushover.contact.contact_search import Contacts, contacts_of_interfaces
from orchestrator.pushover.contact.faces import find_touching, tributary
from orchestrator.pushover.increments import Increment
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.pushover.toes import OFFSET


@dataclass(frozen=True, slots=True)
class CoarseCracks:
    """What bonds that crack carry too much, over the live load, and the size in m that elements need there, or 0."""

    error: float
    size: float


@dataclass(frozen=True, eq=False, slots=True)
class Bond:
    """Strength of c contacts while intact, tension, cohesion (c,) in N, and their history; softening in m.

    At the start of the increment: damage (c,), plastic slip (c,) and opening (c,) in m.
    """

    tension: FloatArray
    cohesion: FloatArray
    softening: float
    damage: FloatArray
    slip: FloatArray
    opening: FloatArray

    def at(self, rows: IntArray, damage: FloatArray, slip: FloatArray, gap: FloatArray) -> Bond:
        """Return the bond of the contacts `rows`, with their history; all arrays (possible,), gap NaN where none is."""
        return replace(
            self,
            tension=self.tension[rows],
            cohesion=self.cohesion[rows],
            damage=damage[rows],
            slip=slip[rows],
            opening=np.maximum(np.nan_to_num(gap[rows]), 0.0),
        )

    def summed(self, kept: IntArray, image: IntArray) -> Bond:
        """Return the bond of the contacts `kept` (k,); image (c,): which of them each adds its strength to."""
        tension, cohesion = (np.bincount(image, one, len(kept)).astype(float) for one in (self.tension, self.cohesion))
        history = {name: getattr(self, name)[kept] for name in ("damage", "slip", "opening")}
        return replace(self, tension=tension, cohesion=cohesion, **history)

    @property
    def holds(self) -> BoolArray:
        """(c,): what still carried tension or cohesion at the start of the increment."""
        return (self.damage < 1.0) & ((self.tension > 0.0) | (self.cohesion > 0.0))


@dataclass(frozen=True, eq=False, slots=True)
class BondResponse:
    """What a bond gives at the end of an increment, arrays (c,).

    damage; tension, cohesion in N that it leaves; tension_slope: d tension / d gap, cohesion_slope: d cohesion / d
    plastic slip, N/m; plastic_slip in the increment, m; by_opening: whether opening governs, else slip; intact: bonded
    at the start of the increment.
    """

    damage: FloatArray
    tension: FloatArray
    cohesion: FloatArray
    tension_slope: FloatArray
    cohesion_slope: FloatArray
    plastic_slip: FloatArray
    by_opening: BoolArray
    intact: BoolArray


def bond_response(bond: Bond, gap: FloatArray, trial_slip: FloatArray, slip_tolerance: float) -> BondResponse:
    """Return what is left of the bond at gap (c,) in m and trial elastic slip (c, 2) in m."""
    opening = np.maximum(gap, 0.0)
    plastic = np.maximum(np.linalg.norm(trial_slip, axis=1) - slip_tolerance, 0.0)
    by_opening = opening >= bond.slip + plastic
    bonded = (bond.tension > 0.0) | (bond.cohesion > 0.0)  # others have nothing to lose
    reached = np.where(bonded, np.maximum(opening, bond.slip + plastic) / bond.softening, 0.0)
    damage = np.minimum(np.maximum(bond.damage, reached), 1.0)
    grows = (reached > bond.damage) & (reached < 1.0)
    return BondResponse(
        damage=damage,
        tension=bond.tension * (1.0 - damage),
        cohesion=bond.cohesion * (1.0 - damage),
        tension_slope=np.where(grows & by_opening, -bond.tension / bond.softening, 0.0),
        cohesion_slope=np.where(grows & ~by_opening & (plastic > 0.0), -bond.cohesion / bond.softening, 0.0),
        plastic_slip=plastic,
        by_opening=by_opening,
        intact=bond.holds,
    )


def shear_limit(normal_force: FloatArray, friction: FloatArray, bond: Bond | None) -> tuple[FloatArray, FloatArray]:
    """Return (c,) in N: the shear that contacts reach under their normal forces, and the cohesion in it."""
    if bond is None:
        return friction * np.maximum(normal_force, 0.0), np.zeros(len(normal_force))
    cohesion = bond.holds * bond.cohesion * (1.0 - bond.damage)
    pressed = friction * np.where(bond.holds, normal_force, np.maximum(normal_force, 0.0))
    return np.maximum(pressed + cohesion, 0.0), cohesion


def dissipation(bond: Bond, response: BondResponse, gap: FloatArray) -> FloatArray:
    """Return what breaking takes (c,), J, beyond (cohesion left) x (plastic slip), which friction counts."""
    before, after, width = bond.damage, response.damage, bond.softening
    opening = np.where(response.by_opening, 0.5 * width * (before + after), 0.5 * (bond.opening + np.maximum(gap, 0.0)))
    slid = bond.slip + response.plastic_slip
    intact = np.clip(width * before, bond.slip, slid) - bond.slip
    end = np.maximum(np.minimum(slid / width, 1.0), before)
    softened = (end - 0.5 * end**2) - (before - 0.5 * before**2)
    by_slip = (1.0 - before) * intact + width * softened
    by_both = (1.0 - 0.5 * (before + after)) * response.plastic_slip
    shear = np.where(response.by_opening, by_both, by_slip) - (1.0 - after) * response.plastic_slip
    return bond.tension * opening * (after - before) + bond.cohesion * shear


def coarse_cracks(
    bodies: Bodies, contacts: Contacts, at_peak: Increment, after: Increment | None, moment: float, height: float
) -> CoarseCracks:
    """Return what bonded joints that are open and pressed at once carry too much, as their elements are too long.

    after: the increment after the peak, None where there is none: then every joint counts as if it turned as fast as
    the wall. moment: of the live load about the wall's base at the peak, N m; height: of the wall, m.

    A joint bears most with its toe pressed over x (`Bodies.bond_toe`), and by 2 x / 3 times the toe's force less than
    if the toe were a point. Nodes that stand for h of it take the force nearer to the end by h^2 / (4 x) (toes.py), and
    by no more than all of that; nor is what a joint carries too much more than what its bond carries. A peak is too
    high by it where the joint turns as fast as the wall, and by as much less as it turns more slowly.
    """
    joints, error, size = bodies.interfaces, 0.0, np.inf
    after = after or at_peak
    wall_turns = abs(after.control_displacement - at_peak.control_displacement) / height
    for joint in np.flatnonzero(bodies.bond_toe > 0.0):
        here = np.flatnonzero(contacts.interface == joint)
        force, length, toe = np.maximum(at_peak.normal_force[here], 0.0), joints.length[joint], bodies.bond_toe[joint]
        if not force.any() or not ((at_peak.gap[here] > 0.0) & (at_peak.damage[here] > 0.0)).any():
            continue
        along = (contacts.point[here, :2] - joints.start[joint]) @ joints.tangent[joint]
        if force @ along > 0.5 * length * force.sum():
            along = length - along
        places = np.unique(np.round(along / length, 6)) * length
        element = places[1] - places[0] if len(places) > 1 else length
        beyond = force.sum() * min(element**2 / (4.0 * toe), 2.0 * toe / 3.0)
        bond = 0.5 * joints.tensile_strength[joint] * joints.area[joint] * length
        turns = np.ptp(np.nan_to_num(after.gap - at_peak.gap)[here]) / length
        share = min(turns / wall_turns, 1.0) if wall_turns else 1.0
        error += share * min(beyond, bond) / moment
        size = min(size, 2.0 * np.sqrt(OFFSET * length * toe))
    return CoarseCracks(float(error), float(size) if np.isfinite(size) else 0.0)


def find_bond(bodies: Bodies, meshes: BodyMeshes, contacts: Contacts, possible: int, softening: float) -> Bond | None:
    """Return the bond of `possible` contacts, of which `contacts` come first and touch; None where joints have none."""
    cohesion, tensile = bodies.interfaces.cohesion, bodies.interfaces.tensile_strength
    if not cohesion.any():
        return None
    touching, sides = find_touching(bodies, meshes)
    rows = contacts_of_interfaces(touching, sides, contacts.slave_node, contacts.interface)
    strength = np.zeros((possible, 2))
    for number, strengths in enumerate(zip(tensile, cohesion, strict=True)):
        _, areas = tributary(sides[touching.slave_edge[number]], meshes.nodes)
        strength[rows[number]] += areas[:, None] * np.array(strengths)
    nothing = read_only(np.zeros(possible))
    return Bond(read_only(strength[:, 0]), read_only(strength[:, 1]), softening, nothing, nothing, nothing)

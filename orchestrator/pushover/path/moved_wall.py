"""Limit analysis of a wall where it has moved to, its bodies as rigid, with the contacts that it has there.

A gap that was drawn may close. Then the wall bears more than the joints drawn can, and two questions arise.

Do supports hold it? Then every multiple of the live load is in balance with forces that no contact refuses, and its
multiplier has no upper bound (the static theorem). Such a direction, in which contact forces grow with the live load
for ever, has no part of the dead load, and none of what is bounded: cohesion, ties, contacts that may crush: forces
n >= 0, |s| <= mu n in balance with the live load alone.

Is it the contacts that were not drawn by which it bears so much? Then it bears less without them: Eq. (1) of the
moved wall, with the contacts between faces that touched from the beginning.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.sparse as sparse
from scipy.optimize import linprog

from orchestrator.basis.arrays import BoolArray, FloatArray
from orchestrator.pushover.increments import Increment
from orchestrator.pushover.model import ContactModel, displaced, without


@dataclass(frozen=True, eq=False, slots=True)
class MovedWall:
    """Rigid bodies with d motions and c contacts: cone (2 c, d), what a unit force on each edge of Coulomb's cone does
    on every motion; dead, live (d,) in N; the rows (c,) of the contacts among all possible ones."""

    cone: sparse.csr_matrix
    dead: FloatArray
    live: FloatArray
    rows: npt.NDArray[np.int64]

    def forces(self, contacts: BoolArray) -> sparse.csr_matrix:
        """Return (d, 2 k): balance of the forces of some of the contacts (possible,)."""
        return self.cone[np.tile(contacts[self.rows], 2)].T.tocsr()


def moved_wall(model: ContactModel, state: Increment) -> MovedWall:
    """Return what has not fallen of a wall (`model`: undeformed) in a state of the nodes in front (`in_front`)."""
    left = without(model, state.fallen) if state.fallen.any() else model
    here = displaced(left, state.displacement.ravel(), known=~np.isnan(state.gap))
    motions = rigid_motions(here, state.displacement)
    normal, tangent = here.normal_rows @ motions, here.tangential_rows[::2] @ motions
    rubs = sparse.diags(here.contacts.friction) @ tangent
    cone = sparse.vstack([normal + rubs, normal - rubs]).tocsr()
    return MovedWall(cone, motions.T @ here.gravity, motions.T @ here.lateral, here.rows)


def rigid_motions(model: ContactModel, displacement: FloatArray) -> sparse.csr_matrix:
    """Return (n, 3 b): motions of nodes, displaced by (m, 3) in m, as each body moves by x and y (m) and turns about
    the mean of its nodes, by the angle that moves a point as far away as the wall is high by 1 m."""
    body = model.front.body_of_node
    place = model.front.nodes[:, :2] + displacement[: len(body), :2]
    middle = np.stack([np.bincount(body, place[:, k], model.bodies) for k in range(2)], axis=1)
    arm = (place - (middle / np.bincount(body, minlength=model.bodies)[:, None])[body]) / model.height
    node = np.arange(len(body))
    x, y = 3 * node, 3 * node + 1
    row, column = np.concatenate([x, y, x, y]), np.concatenate([3 * body, 3 * body + 1, 3 * body + 2, 3 * body + 2])
    value = np.concatenate([np.ones(2 * len(body)), -arm[:, 1], arm[:, 0]])
    return sparse.csr_matrix((value, (row, column)), shape=(len(model.lateral), 3 * model.bodies))


def is_held(model: ContactModel, state: Increment) -> bool:
    """Return whether the contacts in compression of a static state bear any multiple of the live load."""
    if state.moving:
        return False
    wall, pressed = moved_wall(model, state), state.normal_force > 0.0
    if model.mortar is not None:
        pressed = pressed & np.isinf(model.mortar.strength)
    return balances(wall.forces(pressed), wall.live)


def balances(forces: sparse.csr_matrix, load: FloatArray) -> bool:
    """Return whether forces, columns (d, k) that may grow, balance a load (d,).

    They balance all of it or nothing, as what may grow is a cone. Asked for the largest part a linear program has an
    answer either way; asked for forces alone HiGHS goes on for ever over some that there are none of.
    """
    rows = sparse.hstack([forces, sparse.csr_matrix(load[:, None] / np.abs(load).max())])
    largest, most = np.append(np.zeros(forces.shape[1]), -1.0), [(0.0, None)] * forces.shape[1] + [(0.0, 1.0)]
    found = linprog(largest, A_eq=rows, b_eq=np.zeros(len(load)), bounds=most, method="highs")
    return found.x is not None and bool(found.x[-1] > 0.5)


def most_of_drawn_contacts(model: ContactModel, state: Increment) -> float | None:
    """Return the highest multiplier at which a wall can stand as it has moved without contacts that were not drawn, 0
    where it cannot stand.

    None where no such contact presses, where nothing bounds it, and for bonds and ties, which are not looked at.
    """
    if model.tracking is None or model.bond is not None or model.ties is not None:
        return None
    pair = model.tracking.pair
    new = ~np.isin(pair, pair[: model.tracking.touching])  # between faces that did not touch as they were drawn
    if not (state.normal_force[new] > 0.0).any():
        return None
    touch = (state.normal_force > 0.0) | (np.nan_to_num(state.gap, nan=np.inf) <= model.slip_tolerance)
    wall = moved_wall(model, state)
    balance = sparse.hstack([wall.forces(touch & ~new), sparse.csr_matrix(wall.live[:, None])]) / model.weight
    if not balances(balance, wall.dead):
        return 0.0
    gain = np.append(np.zeros(balance.shape[1] - 1), -1.0)
    found = linprog(gain, A_eq=balance, b_eq=-wall.dead / model.weight, method="highs")
    return None if found.x is None else float(found.x[-1])

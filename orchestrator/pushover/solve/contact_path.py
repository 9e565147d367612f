"""From one Newton iterate to the next: contacts open, close, crush, stick and slide one by one on the way (numpy only).

Linearised at an iterate, the residual F of newton.py is linear on either side of planes phi_k = 0, and continuous:

    F(x) = F(x_0) + J (x - x_0) + sum over the planes crossed of  w_k U_k phi_k(x),  minus where phi_k > 0 at x_0

    a contact     phi > 0 when it does so          w                        U
    closes        lambda + T - kappa G             -1                       its own row
    crushes       lambda - kappa G - f_c A         1                        its own row
    slides        p_t - gamma, forth               -mu lambda / gamma       force along t between its bodies
                  -p_t - gamma, back               mu lambda / gamma        the same

with G, f_c A of mortar.py, T of cohesion.py, the trial elastic slip p and gamma of contact_law.py; t is the direction
of p where the contact slides at x_0, else the tangent in the wall's plane. Followed is the path x(s) on which

    F(x(s)) = (1 - s) F(x_0)

from s = 0 to the solution at s = 1. Friction that follows the pressure makes J unsymmetric, and its determinant may
change its sign across a plane: neither piece then has its solution on its own side, and Newton's iteration swings
between the two for ever. The path turns instead (s goes back) until another contact changes and turns it again.

Every plane crossed changes J by one rank, so that all pieces have the factors of x_0: with the solutions Y for U,

    dx/ds = y_0 - Y (1 / w + grad phi . Y)^-1 grad phi . y_0,     y_0 = -J^-1 F(x_0)

What is followed are the phi, for which the rates grad phi . Y are enough; x is found at the end, from the sum of the U.
Several solutions together take little longer than one: those of the planes that are next on the way are made too.
Where J is regular a path comes to every piece once, unless it is a ring that comes back to its first: one that meets a
piece again, by rounding too, leads nowhere (every stone of 531: 80,000 planes crossed in place of 120,000; a throw-away
script).

D. Ralph, Mathematics of Operations Research 19 (1994) 352-389; S. P. Dirkse, M. C. Ferris, Optimization Methods and
Software 5 (1995) 123-156.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.pushover.model import ContactModel
from orchestrator.pushover.solve.iterate import Iterate, Target
from orchestrator.pushover.solve.linear_system import LinearSystem

FARTHEST_BACK = -1.0
"""s at which a path that has turned leads away from the solution"""
LONGEST_BACK = 0.2
"""planes crossed on the way back, over the contacts, after which a path goes nowhere (of 2,764 paths of five pushovers
that ended at a solution 11 crossed more)"""
AT_ONCE = 16
"""solutions for planes that are made together, of planes before the end of the path only. By MUMPS, 25,500 unknowns:
10.9 ms a solution alone, 4.2 of four together, 1.9 of sixteen, 1.6 of thirty-two and of more; a tenth of those made for
what comes next is not used (a third with sixteen wherever they lie)"""


@dataclass(frozen=True, eq=False, slots=True)
class Kinks:
    """The p planes that make a difference, of closing, crushing, sliding forth and sliding back of c contacts each.

    number (p,): kind x c + contact. phi (p,) at the iterate, in N and m; beyond (p,): whether it is positive there;
    weight (p,): w. along (c, 2): direction t of the tangents. pull_slope (c,): d tension / d G, N/m; widens (c,):
    d gamma / d lambda, m/N.
    """

    model: ContactModel
    number: IntArray
    phi: FloatArray
    beyond: BoolArray
    weight: FloatArray
    along: FloatArray
    compliance: FloatArray | float
    pull_slope: FloatArray
    widens: FloatArray

    @classmethod
    def at(cls, model: ContactModel, problem: Target, iterate: Iterate) -> Kinks:
        """Return the planes at an iterate."""
        kappa, count, response = model.contact_stiffness, len(iterate.gap), iterate.response
        slip = model.tangential_rows @ (iterate.displacement - problem.displacement)
        trial = problem.elastic_slip + slip.reshape(-1, 2)
        length, slides = np.linalg.norm(trial, axis=1), response.sliding
        along = np.where(slides[:, None], trial / np.where(slides, length, 1.0)[:, None], [1.0, 0.0])
        travel, tolerance = np.einsum("ci,ci->c", along, trial), response.tolerance
        pressed = iterate.normal_force - kappa * iterate.gap
        stiffness = response.limit / tolerance
        crushing = np.isfinite(np.broadcast_to(iterate.strength, count)).astype(float)
        phi = np.concatenate(
            [pressed + iterate.pull, pressed - iterate.strength, travel - tolerance, -travel - tolerance]
        )
        weight = np.concatenate([-np.ones(count), crushing, -stiffness, stiffness])
        number = np.flatnonzero(weight)
        return cls(
            model=model,
            number=number,
            phi=phi[number],
            beyond=np.concatenate([iterate.active, iterate.crushes, slides, np.zeros(count, bool)])[number],
            weight=weight[number],
            along=along,
            compliance=0.0 if problem.mortar is None else problem.mortar.compliance,
            pull_slope=iterate.pull_slope,
            widens=np.divide(model.contacts.friction, stiffness, out=np.zeros(count), where=response.elastic),
        )

    def rates(self, change: FloatArray) -> FloatArray:
        """Return grad phi . change, (..., p) for changes (..., unknowns) of all unknowns."""
        model, count = self.model, len(self.along)
        n, kappa = len(model.gravity), model.contact_stiffness
        force, moved = kappa * change[..., n:-1], change[..., :n].T
        gap = (model.normal_rows @ moved).T + self.compliance * force
        slip = (model.tangential_rows @ moved).T.reshape(*change.shape[:-1], count, 2)
        travel = np.einsum("ci,...ci->...c", self.along, slip)
        pressed, widens = force - kappa * gap, self.widens * force
        every = [pressed + self.pull_slope * gap, pressed, travel - widens, -travel - widens]
        return np.concatenate(every, axis=-1)[..., self.number]

    def load(self, planes: IntArray, amounts: FloatArray) -> FloatArray:
        """Return the sum of so many U, (..., unknowns) for amounts (k, ...) of planes (k,)."""
        kind, contact = np.divmod(self.number[planes], len(self.along))
        slides, sums = kind > 1, amounts.shape[1:]
        force, pull = np.zeros((len(self.along), *sums)), np.zeros((len(self.along), 2, *sums))
        np.add.at(force, contact[~slides], amounts[~slides])
        forth = self.along[contact[slides]]
        np.add.at(pull, contact[slides], np.einsum("ki,k...->ki...", forth, amounts[slides]))
        on_nodes = self.model.tangential_columns @ pull.reshape(-1, *sums)
        return np.concatenate([on_nodes, force, np.zeros((1, *sums))]).T


def followed(model: ContactModel, system: LinearSystem, kinks: Kinks, solution: FloatArray) -> tuple[FloatArray, bool]:
    """Return the change of all unknowns along the path, and whether it ends at the solution.

    solution: that of the piece on which the path begins, whose factors `system` has.
    """
    rate = kinks.rates(solution)
    phi, beyond = kinks.phi.copy(), kinks.beyond.copy()
    share, of_solution = 0.0, 0.0
    known: dict[int, FloatArray] = {}  # rates of the solutions of planes
    crossed, part = np.zeros(0, np.int64), np.zeros(0)  # every plane ever crossed, and the sum of amounts of its U
    rates, between = np.zeros((0, len(phi))), np.zeros((0, 0))  # of solutions of crossed planes: all, of crossed planes
    direction, last, back = 1.0, -1, 0
    names = np.random.default_rng(0).integers(2**63, size=len(phi))
    piece, pieces = 0, {0}  # of changed planes, the names together: here, and wherever the path has been
    for _ in range(len(phi)):
        changed = np.flatnonzero(beyond[crossed] != kinks.beyond[crossed])
        weights = np.where(beyond, 1.0, -1.0)[crossed[changed]] * kinks.weight[crossed[changed]]
        small = np.eye(len(changed)) + weights[:, None] * between[np.ix_(changed, changed)].T
        away = np.zeros(len(crossed))
        try:
            away[changed] = np.linalg.solve(small, weights * rate[crossed[changed]])
        except np.linalg.LinAlgError:
            break
        ahead = rate - away @ rates[: len(crossed)]
        if last >= 0:
            direction = 1.0 if (ahead[last] > 0.0) == beyond[last] else -1.0
            back += direction < 0.0
            if back > LONGEST_BACK * len(model.contacts):
                break
        far = _how_far(phi, beyond, direction * ahead, last)
        plane = int(far.argmin())
        length = float(far[plane])
        ends = direction > 0.0 and share + length >= 1.0
        length = 1.0 - share if ends else length
        if share + direction * length < FARTHEST_BACK or not np.isfinite(length):
            break
        left = 1.0 - share if direction > 0.0 else share - FARTHEST_BACK
        share += direction * length
        of_solution += direction * length
        part -= direction * length * away
        if ends:
            change = of_solution * solution
            return change + system.solve_again(kinks.load(crossed, part)[None])[0] if len(crossed) else change, True
        phi += direction * length * ahead
        beyond[plane] = ~beyond[plane]
        last = plane
        piece ^= int(names[plane])
        if piece in pieces:
            break
        pieces.add(piece)
        if plane not in crossed:
            if plane not in known:
                far[list(known)] = np.inf
                planes = _next(np.where(far < left, far, np.inf), plane)
                solutions = system.solve_again(kinks.load(planes, np.eye(len(planes))))
                known |= zip(planes.tolist(), kinks.rates(solutions), strict=True)
            count = len(crossed)
            if count == len(rates):
                more = (0, 1 + count)
                rates, between = np.pad(rates, (more, (0, 0))), np.pad(between, (more, more))
            crossed, part = np.append(crossed, plane), np.append(part, 0.0)
            rates[count] = known[plane]
            between[: count + 1, count] = rates[: count + 1, plane]
            between[count, :count] = known[plane][crossed[:-1]]
    return solution, False


def _how_far(phi: FloatArray, beyond: BoolArray, ahead: FloatArray, last: int) -> FloatArray:
    """Return how far (in s) the planes (p,) on the way are, but the `last` one: infinity where they are not."""
    nears = np.where(beyond, ahead < 0.0, ahead > 0.0)
    far = np.divide(-phi, ahead, out=np.full(len(phi), np.inf), where=nears)
    if last >= 0:
        far[last] = np.inf
    return np.maximum(far, 0.0, out=far)


def _next(far: FloatArray, plane: int) -> IntArray:
    """Return a plane and those that are next on the way, AT_ONCE at most in all."""
    order = np.argpartition(far, min(AT_ONCE, len(far) - 1))[:AT_ONCE]
    others = order[np.isfinite(far[order]) & (order != plane)]
    return np.append(plane, others[: AT_ONCE - 1])

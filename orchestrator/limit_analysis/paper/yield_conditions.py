"""What a joint can carry: the inequality rows of Eq. (1) and Eq. (2).

    n_start >= -T/2,  n_end >= -T/2,  |s| <= slope N + cohesion,     N = n_start + n_end     i.e.  C^T q + c >= 0
    n_start + T/2,  n_end + T/2  >=  (N + T)^2 / (2 (N_c + T))       where crushing is limited

T = f_t A is the tensile, N_c = f_c A the compressive strength of the joint. The last line is the moment-thrust limit of
rectangular (plastic) stress blocks, |M| <= (N + T)/2 (L - (N + T)/((f_c + f_t) t)), since |M| = |n_end - n_start| L/2.
It is replaced by chords of the parabola between N + T = (N_c + T) sin^2(i pi/(2 K)), i = 0 ... K: inside, because the
parabola is concave in N, so the multiplier is never above that of the parabola itself. The moment lost is at most
(pi/(2 K))^2 of the moment carried, 0.099 % for K = 50, at any N (Delta^2/(4 N_c N (1 - N/N_c)) for a chord over Delta;
with N = N_c sin^2 x it is the same for all chords). That fineness ends where N is the whole dead load W; from there one
chord leads to N_c. If W + T is less than the first chord spans, that one ends at W + T: it then costs
(W + T)/(N_c + T) at most. Joints for which even this is below NEGLIGIBLE do not crush.

Coulomb's law has slope mu. The flow rule of the linear program is normal to this cone: a sliding joint opens by
slope x |slip| (dilation). Eq. (2) therefore tilts the line to a slope of -alpha mu about the normal force the joint is
expected to carry, which nearly removes the dilation. Sources: Gilbert, Casapulla, Ahmed 2006; Szabó, Funari,
Lourenço 2023, Eq. (2) (docs/theory.md).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from orchestrator.basis.arrays import FloatArray, IntArray, read_only
from orchestrator.masonry.block_properties import block_weights
from orchestrator.masonry.joints import Assemblage

CHORDS = 50
"""K: chords of the crushing parabola at each end of a joint"""
CORNERS = np.sin(np.linspace(0.0, 0.5 * np.pi, CHORDS + 1)) ** 2
"""N + T at the corners of the chords, (K+1,), as parts of N_c + T"""
NEGLIGIBLE = 1e-9
"""Part of the moment that crushing may take away unseen: what linear programs do not resolve."""


@dataclass(frozen=True, eq=False, slots=True)
class YieldConditions:
    """Friction lines of k joints: slope (k,) and cohesion (k,) in N; tensile and compressive strength (k,) in N.

    One number stands for all joints; by default there is no tension and no crushing. carried (N): up to this normal
    force the chords of crushing are fine.
    """

    slope: FloatArray
    cohesion: FloatArray
    tension: FloatArray = field(default_factory=lambda: read_only(0.0))
    crushing: FloatArray = field(default_factory=lambda: read_only(np.inf))
    carried: float = np.inf

    def __post_init__(self) -> None:
        for name in ("tension", "crushing"):
            object.__setattr__(self, name, read_only(np.broadcast_to(getattr(self, name), self.slope.shape)))

    @property
    def crushes(self) -> npt.NDArray[np.bool_]:
        """Which joints (k,) have a finite compressive strength."""
        return np.isfinite(self.crushing)

    @property
    def fine_chords(self) -> IntArray:
        """Number of fine chords (c,) of each joint that crushes."""
        return np.maximum(1, np.count_nonzero(CORNERS[:-1] < self._reach[:, None], axis=1))

    @property
    def corners(self) -> FloatArray:
        """N + T at the corners of the chords (c, K+1) of each joint that crushes, as parts of N_c + T."""
        corners = np.tile(CORNERS, (len(self._reach), 1))
        corners[:, 1] = np.minimum(corners[:, 1], self._reach)
        return corners

    @property
    def _reach(self) -> FloatArray:
        """Largest N + T (c,) to be expected in each joint that crushes, as a part of N_c + T."""
        tension, crushing = self.tension[self.crushes], self.crushing[self.crushes]
        return (self.carried + tension) / (crushing + tension)

    @property
    def scales_with_load(self) -> bool:
        """Whether joints carry twice as much when they are pressed twice as hard: nothing but friction."""
        return not (self.cohesion.any() or self.tension.any() or self.crushes.any())

    def of_joints(self, chosen: npt.NDArray[np.bool_]) -> YieldConditions:
        """Return the conditions of the chosen (k,) joints only."""
        return replace(
            self,
            slope=read_only(self.slope[chosen]),
            cohesion=read_only(self.cohesion[chosen]),
            tension=read_only(self.tension[chosen]),
            crushing=read_only(self.crushing[chosen]),
        )

    def excess(self, joint_forces: FloatArray) -> float:
        """Largest violation in N by joint forces (k, 3): tension, crushing or shear beyond the line; 0 when none."""
        normal, shear = joint_forces[:, :2] + 0.5 * self.tension[:, None], joint_forces[:, 2]
        sliding = np.abs(shear) - self.slope * joint_forces[:, :2].sum(axis=1) - self.cohesion
        crushing = normal.sum(axis=1) ** 2 / (2.0 * (self.crushing + self.tension)) - normal.min(axis=1)
        return float(max(0.0, crushing.max(), sliding.max()))

    def dissipation(self, joint_forces: FloatArray, rates: FloatArray, dilatancy: FloatArray) -> float:
        """Power (W) that joints take in at rates (k, 3) in m/s if they resist with all they have.

        Sliding joints that open by dilatancy (k,) times |slip| resist with (c + (mu - dilatancy) N) |slip| at the
        normal force they carry; what else they open or close meets the tensile strength and crushing.
        """
        slip = np.abs(rates[:, 2])
        sliding = (self.cohesion + (self.slope - dilatancy) * joint_forces[:, :2].sum(axis=1)) * slip
        opening = rates[:, :2] - (dilatancy * slip)[:, None]
        resisted = 0.5 * self.tension[:, None] * np.where(self.crushes[:, None], opening, np.maximum(opening, 0.0))
        lower = 0.5 * self.corners**2  # normal force + T/2 at the end that crushes less
        higher = self.corners - lower
        closing = -opening[self.crushes, :, None]
        pushed = np.maximum(
            closing[:, 0] * lower + closing[:, 1] * higher, closing[:, 0] * higher + closing[:, 1] * lower
        )
        left_out = np.arange(CHORDS) > self.fine_chords[:, None]
        pushed[:, :-1][left_out] = 0.0
        crushed = (self.crushing + self.tension)[self.crushes] * pushed.max(axis=1)
        return float(sliding.sum() + resisted.sum() + crushed.sum())


def coulomb(assemblage: Assemblage, carried: float | None = None) -> YieldConditions:
    """|s| <= mu N + c: slope mu, cohesion and strengths (N/m2) over the joint's area; crushing where it matters.

    carried is the whole dead load in N (none given: the weight of the free blocks).
    """
    joints, area = assemblage.joints, assemblage.joints.area
    free = [not block.fixed for block in assemblage.wall.blocks]
    carried = block_weights(assemblage.wall)[free].sum() if carried is None else carried
    tension, crushing = joints.tensile_strength * area, joints.compressive_strength * area
    return YieldConditions(
        slope=read_only(joints.friction),
        cohesion=read_only(joints.cohesion * area),
        tension=read_only(tension),
        crushing=read_only(np.where(NEGLIGIBLE * (crushing + tension) < carried + tension, crushing, np.inf)),
        carried=carried,
    )


def falling_line(
    coulomb: YieldConditions, expected_normal: FloatArray, slope_fraction: float, seed: float
) -> YieldConditions:
    """Eq. (2): |s| <= c_j - alpha mu N with c_j = c + (1 + alpha) mu N_expected, which meets Coulomb at N_expected.

    expected_normal (k,) in N, slope_fraction is alpha. The slope is -alpha: Eq. (2) read with +alpha puts walls 1 and 2
    above their associative optimum. `seed` (N) is a small cohesion on top: a joint whose N was 0 could never carry
    force again (10 % of the joints of wall 6).
    """
    mu = coulomb.slope
    c_j = coulomb.cohesion + seed + (1.0 + slope_fraction) * mu * expected_normal
    return replace(coulomb, slope=-slope_fraction * mu, cohesion=c_j)


def relaxed_normal(last: FloatArray, before: FloatArray, relaxation: float) -> FloatArray:
    """Expected normal force beta N_{j-1} + (1 - beta) N_{j-2} of Eq. (2), (k,) in N; relaxation is beta."""
    return relaxation * last + (1.0 - relaxation) * before


def chords(conditions: YieldConditions) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return joint, and the corners (parts of N_c + T) before and after, of every chord (each (c,))."""
    joint, fine = np.flatnonzero(conditions.crushes), conditions.fine_chords
    which, chord = np.nonzero(np.arange(CHORDS) < fine[:, None])
    coarse = np.flatnonzero(fine < CHORDS)
    corners = conditions.corners
    before = np.concatenate([corners[which, chord], corners[coarse, fine[coarse]]])
    after = np.concatenate([corners[which, chord + 1], np.ones(len(coarse))])
    return np.concatenate([joint[which], joint[coarse]]), before, after


def yield_matrix(conditions: YieldConditions) -> sp.csc_matrix:
    """C^T of C^T q + c >= 0: all rows n_start + T/2, all n_end + T/2, all slope N + c - s, all slope N + c + s (4k).

    Then the chords of the joints that crush, at their starts and again at their ends.
    """
    slope, every = conditions.slope, np.arange(len(conditions.slope))
    one, nothing = np.ones_like(slope), np.zeros_like(slope)
    joint, before, after = chords(conditions)
    part = 0.5 * (before + after)
    coefficients = (
        (one, nothing, nothing),
        (nothing, one, nothing),
        (slope, slope, -one),
        (slope, slope, one),
        (1.0 - part, -part, 0.0 * part),
        (-part, 1.0 - part, 0.0 * part),
    )
    values = np.concatenate([np.column_stack(row) for row in coefficients])
    columns = 3 * np.concatenate([every, every, every, every, joint, joint])[:, None] + np.arange(3)
    row_ends = np.arange(0, values.size + 1, 3)
    matrix = sp.csr_matrix((values.ravel(), columns.ravel(), row_ends), shape=(len(values), 3 * len(slope))).tocsc()
    matrix.eliminate_zeros()
    return matrix


def yield_offset(conditions: YieldConditions) -> FloatArray:
    """c of C^T q + c >= 0, rows as in `yield_matrix`."""
    half, cohesion = 0.5 * conditions.tension, conditions.cohesion
    joint, before, after = chords(conditions)
    T, N_c = conditions.tension[joint], conditions.crushing[joint]
    crushing = 0.5 * before * after * (N_c + T) + 0.5 * T * (1.0 - before - after)
    return np.concatenate([half, half, cohesion, cohesion, crushing, crushing])


def cohesion_rows(joints: int) -> slice:
    """Which rows of `yield_offset` are the cohesion of so many joints, twice."""
    return slice(2 * joints, 4 * joints)

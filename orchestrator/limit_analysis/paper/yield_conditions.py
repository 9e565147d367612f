"""What a joint can carry: the inequality rows of Eq. (1) and Eq. (2).

    n_start >= -T/2,  n_end >= -T/2,  |s| <= slope N + cohesion,     N = n_start + n_end     i.e.  C^T q + c >= 0
    n_start + T/2,  n_end + T/2  >=  (N + T)^2 / (2 (N_c + T))       where crushing is limited

T = f_t A is the tensile, N_c = f_c A the compressive strength of the joint. The last line is the moment-thrust limit of
rectangular (plastic) stress blocks, |M| <= (N + T)/2 (L - (N + T)/((f_c + f_t) t)), since |M| = |n_end - n_start| L/2.
It is replaced by K chords with corners at fixed parts p of N_c + T: inside, because the parabola is concave in N, so
the multiplier is never above that of the parabola itself, and a stronger joint never bears less. Between corners a and
b (p - a) (b - p) / (p (1 - p)) of the moment is lost. With corners at sin^2(i pi/100), i = 0 ... 50, that is at most
(pi/100)^2 = 0.099 % for every chord, at any N. Corners at 1e-9, 1e-8 ... 1e-4 come before the first of these: there at
most 5 p is lost (1e-9 below p = 1e-9), crushing itself takes p, so that strength without end is the wall without.

At one N one chord counts, so few of them are rows: a program begins with the last, which ends at N_c, and is solved
again with those that its forces exceed until they exceed none (`with_chords_at`). That is the optimum under all chords:
fewer rows are an upper bound, and its forces respect the others.

Coulomb's law has slope mu. The flow rule of the linear program is normal to this cone: a sliding joint opens by
slope x |slip| (dilation). Eq. (2) therefore tilts the line to a slope of -alpha mu about the normal force the joint is
expected to carry, which nearly removes the dilation. Sources: Gilbert, Casapulla, Ahmed 2006; Szabó, Funari,
Lourenço 2023, Eq. (2) (docs/theory.md).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import scipy.sparse as sp

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, read_only
from orchestrator.masonry.joints import Assemblage

CORNERS = np.concatenate([[0.0], 10.0 ** np.arange(-9.0, -3.0), np.sin(np.linspace(0.0, 0.5 * np.pi, 51))[1:] ** 2])
"""N + T at the corners of the chords, (K+1,), as parts of N_c + T"""
CHORDS = len(CORNERS) - 1
"""K: chords of the crushing parabola at each end of a joint"""
LAST_CHORD = np.arange(CHORDS) == CHORDS - 1
"""(K,) the one that ends at N_c: with it no joint carries without end."""


@dataclass(frozen=True, eq=False, slots=True)
class YieldConditions:
    """Friction lines of k joints: slope (k,) and cohesion (k,) in N; tensile and compressive strength (k,) in N.

    One number stands for all joints; by default there is no tension and no crushing. chords (k, K): which
    of those of crushing are rows of linear programs; whatever is said of forces goes by all of them.
    """

    slope: FloatArray
    cohesion: FloatArray
    tension: FloatArray = field(default_factory=lambda: read_only(0.0))
    crushing: FloatArray = field(default_factory=lambda: read_only(np.inf))
    chords: BoolArray = field(default_factory=lambda: read_only(LAST_CHORD, np.bool_))

    def __post_init__(self) -> None:
        for name in ("tension", "crushing"):
            object.__setattr__(self, name, read_only(np.broadcast_to(getattr(self, name), self.slope.shape)))
        chords = np.broadcast_to(self.chords, (len(self.slope), CHORDS))
        object.__setattr__(self, "chords", read_only(chords, np.bool_))

    @property
    def crushes(self) -> BoolArray:
        """Which joints (k,) have a finite compressive strength."""
        return np.isfinite(self.crushing)

    @property
    def without_shear(self) -> BoolArray:
        """Which joints (k,) carry no shear, whatever presses them: ties, which have neither friction nor cohesion."""
        return (self.slope == 0.0) & (self.cohesion == 0.0)

    @property
    def are_ties(self) -> BoolArray:
        """Which joints (k,) are ties (masonry/ties.py): without shear, and crushed by no more than they pull with."""
        return self.without_shear & (self.crushing <= self.tension)

    @property
    def crushes_joints(self) -> bool:
        """Whether any joint crushes that is no tie."""
        return bool((self.crushes & ~self.are_ties).any())

    @property
    def hard(self) -> YieldConditions:
        """The same for joints that do not crush."""
        return replace(self, crushing=read_only(np.where(self.are_ties, self.crushing, np.inf)))

    @property
    def scales_with_load(self) -> bool:
        """Whether joints carry twice as much when they are pressed twice as hard: nothing but friction."""
        return not (self.cohesion.any() or self.tension.any() or self.crushes.any())

    def of_joints(self, chosen: BoolArray) -> YieldConditions:
        """Return the conditions of the chosen (k,) joints only."""
        return replace(
            self,
            slope=read_only(self.slope[chosen]),
            cohesion=read_only(self.cohesion[chosen]),
            tension=read_only(self.tension[chosen]),
            crushing=read_only(self.crushing[chosen]),
            chords=read_only(self.chords[chosen], np.bool_),
        )

    def with_chords_at(self, joint_forces: FloatArray) -> YieldConditions:
        """Return conditions with the chords that joint forces (k, 3) exceed and those beside them, self where none."""
        joint = np.flatnonzero(self.crushes)
        T, both = self.tension[joint], (self.crushing + self.tension)[joint]
        pressed = joint_forces[joint, :2] + 0.5 * T[:, None]
        part = pressed.sum(axis=1) / both
        chord = np.clip(np.searchsorted(CORNERS, part, side="right") - 1, 0, CHORDS - 1)
        before, after = CORNERS[chord], CORNERS[chord + 1]
        least = 0.5 * ((before + after) * part - before * after) * both
        beyond = (pressed.min(axis=1) < least) & ~self.chords[joint, chord]
        if not beyond.any():
            return self
        chords = self.chords.copy()
        beside = np.clip(chord[beyond, None] + [-1, 0, 1], 0, CHORDS - 1)
        chords[joint[beyond, None], beside] = True
        return replace(self, chords=read_only(chords, np.bool_))

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
        lower = 0.5 * CORNERS**2  # normal force + T/2 at the end that crushes less
        higher = CORNERS - lower
        closing = -opening[self.crushes, :, None]
        pushed = np.maximum(
            closing[:, 0] * lower + closing[:, 1] * higher, closing[:, 0] * higher + closing[:, 1] * lower
        )
        crushed = (self.crushing + self.tension)[self.crushes] * pushed.max(axis=1)
        return float(sliding.sum() + resisted.sum() + crushed.sum())


def coulomb(assemblage: Assemblage) -> YieldConditions:
    """|s| <= mu N + c: slope mu, cohesion and strengths (N/m2) over the joint's area."""
    joints, area = assemblage.joints, assemblage.joints.area
    return YieldConditions(
        slope=read_only(joints.friction),
        cohesion=read_only(joints.cohesion * area),
        tension=read_only(joints.tensile_strength * area),
        crushing=read_only(joints.compressive_strength * area),
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
    """Return joint, and the corners (parts of N_c + T) before and after, of every chord that is a row (each (c,))."""
    joint, chord = np.nonzero(conditions.chords & conditions.crushes[:, None])
    return joint, CORNERS[chord], CORNERS[chord + 1]


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

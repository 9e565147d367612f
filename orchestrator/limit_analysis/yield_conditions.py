"""What a joint can carry: the inequality rows of Eq. (1), Eq. (2), and the dilation shift.

    n_start >= -T/2,  n_end >= -T/2,  |s| <= slope N + cohesion,     N = n_start + n_end     i.e.  C^T q + c >= 0
    n_start + T/2,  n_end + T/2  >=  (N + T)^2 / (2 (N_c + T))       where crushing is limited

T = f_t A is the tensile, N_c = f_c A the compressive strength of the joint. The last line is the moment-thrust limit of
rectangular (plastic) stress blocks, |M| <= (N + T)/2 (L - (N + T)/((f_c + f_t) t)), since |M| = |n_end - n_start| L/2.
It is replaced by chords of the parabola between N + T = (N_c + T) sin^2(i pi/(2 K)), i = 0 ... K: always on the safe
side, and the moment lost is at most (pi/(2 K))^2 of the moment carried, 0.099 % for K = 50, at any N (Delta^2/(4 N_c N
(1 - N/N_c)) for a chord over Delta; with N = N_c sin^2 x it is the same for all chords).

Coulomb's law has slope mu. The flow rule of the linear program is normal to this cone: a sliding joint opens by
slope x |slip| (dilation). Eq. (2) therefore tilts the line to a slope of -alpha mu about the normal force the joint is
expected to carry, which nearly removes the dilation; the dilation shift leaves Coulomb's cone and takes the dilation
out of the objective instead. Sources: Gilbert, Casapulla, Ahmed 2006; Szabó, Funari, Lourenço 2023, Eq. (2); Acary,
Cadoux, Lemaréchal, Malick 2011 (formulation.md, section 1).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from orchestrator.joints import Assemblage
from orchestrator.masonry.geometry import block_weights
from orchestrator.masonry.wall import FloatArray, read_only

CHORDS = 50
"""K: chords of the crushing parabola at each end of a joint"""
CORNERS = np.sin(np.linspace(0.0, 0.5 * np.pi, CHORDS + 1)) ** 2
"""N + T at the corners of the chords, (K+1,), as parts of N_c + T"""
NORMALS_AT_CORNERS = 0.5 * CORNERS**2, CORNERS - 0.5 * CORNERS**2
"""normal force + T/2 there at the end that crushes less and at the one that crushes more, as parts of N_c + T"""


NEVER_CRUSHES = 1e4
"""Joints stronger than so many times the weight of the wall do not crush: even at ten times that weight they would lose
a thousandth of their moment, as much as a chord; strengths of 1e12 Pa spoil the scaling of the linear program."""


@dataclass(frozen=True, eq=False, slots=True)
class YieldConditions:
    """Friction lines of k joints: slope (k,) and cohesion (k,) in N; tensile and compressive strength (k,) in N.

    One number stands for all joints; by default there is no tension and no crushing.
    """

    slope: FloatArray
    cohesion: FloatArray
    tension: FloatArray = field(default_factory=lambda: read_only(0.0))
    crushing: FloatArray = field(default_factory=lambda: read_only(np.inf))

    def __post_init__(self) -> None:
        for name in ("tension", "crushing"):
            object.__setattr__(self, name, read_only(np.broadcast_to(getattr(self, name), self.slope.shape)))

    @property
    def crushes(self) -> npt.NDArray[np.bool_]:
        """Which joints (k,) have a finite compressive strength."""
        return np.isfinite(self.crushing)

    @property
    def scales_with_load(self) -> bool:
        """Whether joints carry twice as much when they are pressed twice as hard: nothing but friction."""
        return not (self.cohesion.any() or self.tension.any() or self.crushes.any())

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
        lower, higher = NORMALS_AT_CORNERS
        closing = -opening[self.crushes, :, None]
        pushed = np.maximum(
            closing[:, 0] * lower + closing[:, 1] * higher, closing[:, 0] * higher + closing[:, 1] * lower
        ).max(axis=1)
        crushed = (self.crushing + self.tension)[self.crushes] * pushed
        return float(sliding.sum() + resisted.sum() + crushed.sum())


def coulomb(assemblage: Assemblage) -> YieldConditions:
    """|s| <= mu N + c: slope mu, cohesion and strengths (N/m2) over the joint's area; crushing where it matters."""
    area = assemblage.length * assemblage.wall.thickness
    crushing = assemblage.compressive_strength * area
    matters = crushing <= NEVER_CRUSHES * block_weights(assemblage.wall).sum()
    return YieldConditions(
        slope=read_only(assemblage.friction),
        cohesion=read_only(assemblage.cohesion * area),
        tension=read_only(assemblage.tensile_strength * area),
        crushing=read_only(np.where(matters, crushing, np.inf)),
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


def relaxed_shift(shift: FloatArray, friction: FloatArray, slip: FloatArray, relaxation: float) -> FloatArray:
    """d <- (1 - omega) d + omega mu |slip|: the dilation (k,) in m/s to be taken out of the next mechanism."""
    return (1.0 - relaxation) * shift + relaxation * friction * np.abs(slip)


def yield_matrix(conditions: YieldConditions) -> sp.csc_matrix:
    """C^T of C^T q + c >= 0: all rows n_start + T/2, all n_end + T/2, all slope N + c - s, all slope N + c + s (4k).

    Then, chord by chord, those of the joints that crush: at all their starts, at all their ends.
    """
    slope = conditions.slope
    one, nothing = np.ones_like(slope), np.zeros_like(slope)
    rows = [(one, nothing, nothing), (nothing, one, nothing), (slope, slope, -one), (slope, slope, one)]
    blocks = [sp.hstack([sp.diags(values) for values in row]) for row in rows]
    crushes = sp.identity(len(slope), format="csr")[conditions.crushes]
    for part in 0.5 * (CORNERS[1:] + CORNERS[:-1]):
        blocks.append(sp.hstack([(1.0 - part) * crushes, -part * crushes, 0.0 * crushes]))
        blocks.append(sp.hstack([-part * crushes, (1.0 - part) * crushes, 0.0 * crushes]))
    by_joint = np.arange(3 * len(slope)).reshape(3, -1).T.ravel()
    matrix = sp.vstack(blocks).tocsc()[:, by_joint]
    matrix.eliminate_zeros()
    return matrix


def yield_offset(conditions: YieldConditions) -> FloatArray:
    """c of C^T q + c >= 0, rows as in `yield_matrix`."""
    half, cohesion = 0.5 * conditions.tension, conditions.cohesion
    T, strength = conditions.tension[conditions.crushes], (conditions.tension + conditions.crushing)[conditions.crushes]
    before, after = CORNERS[:-1, None], CORNERS[1:, None]
    chords = 0.5 * before * after * strength + 0.5 * T * (1.0 - before - after)
    return np.concatenate([half, half, cohesion, cohesion, np.repeat(chords, 2, axis=0).ravel()])

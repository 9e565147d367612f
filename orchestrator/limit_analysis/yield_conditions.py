"""What a joint can carry: the inequality rows of Eq. (1), Eq. (2), and the dilation shift.

    n_start >= 0,  n_end >= 0,  |s| <= slope N + cohesion,     N = n_start + n_end          i.e.  C^T q + c >= 0

Coulomb's law has slope mu. The flow rule of the linear program is normal to this cone: a sliding joint opens by
slope x |slip| (dilation). Eq. (2) therefore tilts the line to a slope of -alpha mu about the normal force the joint is
expected to carry, which nearly removes the dilation; the dilation shift leaves Coulomb's cone and takes the dilation
out of the objective instead. Sources: Gilbert, Casapulla, Ahmed 2006; Szabó, Funari, Lourenço 2023, Eq. (2); Acary,
Cadoux, Lemaréchal, Malick 2011 (formulation.md, section 1).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from orchestrator.joints import Assemblage
from orchestrator.masonry.wall import FloatArray, read_only


@dataclass(frozen=True, eq=False, slots=True)
class YieldConditions:
    """Friction lines of k joints: slope (k,) and cohesion (k,) in N. Without tension, without crushing."""

    slope: FloatArray
    cohesion: FloatArray

    def excess(self, joint_forces: FloatArray) -> float:
        """Largest violation in N by joint forces (k, 3): tension or shear beyond the line; 0 when none."""
        normal, shear = joint_forces[:, :2], joint_forces[:, 2]
        sliding = np.abs(shear) - self.slope * normal.sum(axis=1) - self.cohesion
        return float(max(0.0, -normal.min(), sliding.max()))


def coulomb(assemblage: Assemblage) -> YieldConditions:
    """|s| <= mu N + c: slope mu, cohesion (N/m2) over the joint's area."""
    area = assemblage.length * assemblage.wall.thickness
    return YieldConditions(read_only(assemblage.friction), read_only(assemblage.cohesion * area))


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
    return YieldConditions(-slope_fraction * mu, c_j)


def relaxed_normal(last: FloatArray, before: FloatArray, relaxation: float) -> FloatArray:
    """Expected normal force beta N_{j-1} + (1 - beta) N_{j-2} of Eq. (2), (k,) in N; relaxation is beta."""
    return relaxation * last + (1.0 - relaxation) * before


def relaxed_shift(shift: FloatArray, friction: FloatArray, slip: FloatArray, relaxation: float) -> FloatArray:
    """d <- (1 - omega) d + omega mu |slip|: the dilation (k,) in m/s to be taken out of the next mechanism."""
    return (1.0 - relaxation) * shift + relaxation * friction * np.abs(slip)


def yield_matrix(slope: FloatArray) -> sp.csc_matrix:
    """C^T (4k, 3k) of C^T q + c >= 0: all rows n_start, all n_end, all slope N - s, all slope N + s."""
    one, nothing = np.ones_like(slope), np.zeros_like(slope)
    rows = ((one, nothing, nothing), (nothing, one, nothing), (slope, slope, -one), (slope, slope, one))
    blocks = [sp.hstack([sp.diags(values) for values in row]) for row in rows]
    by_joint = np.arange(3 * len(slope)).reshape(3, -1).T.ravel()
    matrix = sp.vstack(blocks).tocsc()[:, by_joint]
    matrix.eliminate_zeros()
    return matrix


def yield_offset(cohesion: FloatArray) -> FloatArray:
    """c (4k,) of C^T q + c >= 0, rows as in `yield_matrix`."""
    return np.concatenate([np.zeros(2 * len(cohesion)), cohesion, cohesion])

"""Settings of the FE pushover, declared beside the mechanics that use them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Le, Lt

from orchestrator.basis.checked import Checked
from orchestrator.basis.units import Unit
from orchestrator.masonry.block_properties import ELASTIC_MODULUS, ElasticModulus
from orchestrator.masonry.interfaces import SOFTENING


@dataclass(frozen=True, slots=True)
class ElasticSettings(Checked):
    """Isotropic linear elasticity of every stone."""

    elastic_modulus: ElasticModulus = ELASTIC_MODULUS
    """Young's modulus of the stones; joints add what their stiffness (joints.classes) and contact.slip_tolerance say.
    The peak of limit analysis in large displacements depends on it, its state in small ones does not"""
    poisson_ratio: Annotated[float, Ge(0), Lt(0.5)] = 0.2
    """lateral contraction over axial strain"""
    element_order: Annotated[int, Ge(1), Le(2)] = 1
    """1: 4-node tetrahedra, a few per cent too stiff on coarse meshes; 2: 10-node ones with straight outline edges"""


@dataclass(frozen=True, slots=True)
class ContactSettings(Checked):
    """Friction is a penalty that reaches Coulomb's limit at an elastic slip of `slip_tolerance`.

    The initial stiffness feels it: every joint is as soft as tolerance over friction x force. So does the peak where
    stones are keyed into one another and the tolerance is larger than what they are strained by: friction then leaves
    to the keys what it would bear (a joggled arch bears 0.243, 0.244, 0.285 and 0.322 at 0.00001, 0.001, 0.01, 0.1 mm).
    Macroblocks, with fewer joints, seem stiffer for it (docs/runs.md).
    """

    slip_tolerance: Annotated[float, Ge(1e-12), Le(1), Unit("m")] | None = None
    """elastic slip at which friction reaches Coulomb's limit, but in joints with a shear stiffness (joints.classes);
    smaller is stiffer before the peak, and slower. Left out: a third of what a stone of mean size is shortened by under
    half of the wall's weight"""
    softening_displacement: Annotated[float, Gt(0), Le(1e-3), Unit("m")] = SOFTENING
    """opening or slip at which tension and cohesion of a joint (joints.classes) have gone, linearly: its fracture
    energies are half of this times its strengths"""


@dataclass(frozen=True, slots=True)
class NewtonSettings(Checked):
    """When an increment is solved, and when it is given up."""

    residual: Annotated[float, Gt(0), Lt(1e-3)] = 1e-8
    """largest out-of-balance force over the weight (Euclidean norms)"""
    gap: Annotated[float, Gt(0), Lt(1e-6)] = 1e-12
    """largest gap of a closed contact over the height of what moves"""
    iterations: Annotated[int, Ge(3), Le(200)] = 20
    """Newton iterations at most; then the increment is made smaller, or the wall moves"""
    acceptable: Annotated[float, Ge(1), Le(1e4)] = 100.0
    """an iteration that goes no further is accepted when it is within so many tolerances"""
    distribute_above: Annotated[int, Ge(0)] = 50_000
    """unknowns above which all ranks share one linear system; below, one rank is faster and the others wait"""


@dataclass(frozen=True, slots=True)
class SteppingSettings(Checked):
    """Gravity, load control, displacement control: how the load path is followed."""

    gravity_increments: Annotated[int, Ge(1), Le(1000)] = 5
    """equal parts in which the weight is put on"""
    load_increment: Annotated[float, Gt(0), Le(1)] = 1 / 30
    """largest increment of the load multiplier, as a share of the multiplier that limit analysis expects"""
    proximal_share: Annotated[float, Gt(0), Le(1e-3)] = 5e-5
    """a body that moves by the largest increment is held back by this share of its weight: keeps loose blocks"""
    out_of_balance: Annotated[float, Gt(0), Lt(0.1)] = 1e-3
    """an increment is static when no body is out of balance by more than this share of its weight, under load control
    of its live load"""
    local_share: Annotated[float, Ge(0), Lt(1)] = 0.05
    """a part that moves is a local failure below this share of the wall's dead load and of its live load: it falls, and
    the wall goes on"""
    displacement_increment: Annotated[float, Gt(0), Le(1)] = 1 / 40
    """largest increment of the mean displacement along the live load, weighted by it, over the final displacement; a
    part inside the wall goes farther while neither the top nor the multiplier moves by its largest increment, and where
    the base shear falls along a straight curve it goes up to four times as far"""
    final_displacement: Annotated[float, Gt(0), Unit("m")] | None = None
    """the curve ends at this displacement of the top since gravity, along the load or against it. Left out: a thirtieth
    of the height of what moves"""
    final_drop: Annotated[float, Gt(0), Le(1)] = 0.2
    """the curve ends when the base shear has fallen by this share of its peak"""
    large_displacement: bool = True
    """bodies turn, contacts are found anew and loads move with the wall (P-delta); else small displacements"""
    largest_increments: Annotated[int, Ge(1)] = 2000
    """the curve ends after so many increments"""

    def end_of(self, height: float) -> float:
        """Return the displacement of the top in m with which the curve of a wall of this height in m ends."""
        return height / 30 if self.final_displacement is None else self.final_displacement

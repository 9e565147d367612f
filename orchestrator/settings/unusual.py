"""Values that are possible but unusual: mostly one taken for another unit.

The ranges are wide and are this program's own. What they were widened from: unit weights of building stones and timber,
3.5 to 31 kN/m3 (EN 1991-1-1, tables A.2 and A.3); friction 0.4 of bed joints (EN 1996-1-1, 3.6.2); seismicity below
a_g = 0.39 m/s2 counts as very low (EN 1998-1, 3.2.1(5)). Sizes are compared with the wall, not with lengths.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from orchestrator.assessment.seismic.settings import LIKE, limit_states
from orchestrator.basis.printed import counted
from orchestrator.masonry.block_properties import block_areas
from orchestrator.masonry.wall import Wall
from orchestrator.pushover.settings import SteppingSettings
from orchestrator.settings.case import Case
from orchestrator.settings.inventory import JointSums, LoadSums, MaterialSums

LEAST_LOAD = 1e-3
"""part of the wall's weight below which an extra dead load is probably given in another unit"""
SLENDEREST = 1 / 100
"""least usual thickness of a wall over the larger of its height and length"""
THICKEST = 0.5
"""largest usual one (drawn in cm and read in mm, a facade of 5 m has 0.6)"""
LARGEST_DRIFT = 0.03
"""largest usual drift of a pier, part of its height: 0.8 % of EN 1998-3 and three times more for slender ones"""
LEAST_END = 1e-5
"""least usual displacement of a curve's end over the height: elastic ones of stiff walls are of that size"""


@dataclass(frozen=True, slots=True)
class Usual:
    """The usual range of a quantity in a unit; `factor`: SI over that unit. `meant`: other readings of a number in SI,
    as it was typed, each with its value in SI."""

    low: float
    high: float
    unit: str
    factor: float = 1.0
    meant: tuple[tuple[str, Callable[[float], float]], ...] = ()

    def complaint(self, name: str, value: float) -> str | None:
        """Return what is unusual about a value in SI, or None."""
        if self._holds(value):
            return None
        shown = f"{value / self.factor:.4g} {self.unit}".strip()
        usual = f"{self.low:g} to {self.high:g} {self.unit}".strip()
        read = [
            text.format(f"{value:g}", f"{value / self.factor:g}") for text, f in self.meant if self._holds(f(value))
        ]
        question = f"; is {' or '.join(read)} meant?" if read else ""
        return f"UNUSUAL: {name} {shown}, usual are {usual}{question}"

    def _holds(self, value: float) -> bool:
        return self.low <= value / self.factor <= self.high


UNIT_WEIGHT = Usual(3.0, 32.0, "kN/m3", 1e3, (("{0} kN/m3", lambda x: 1e3 * x), ("{1} N/m3", lambda x: 1e-3 * x)))
"""from softwood to basalt"""
FRICTION = Usual(0.2, 1.5, "", 1.0, (("an angle of {0} degrees", lambda x: math.tan(math.radians(x))),))
"""coefficient of friction"""
STRESSES = (("{0} MPa", lambda x: 1e6 * x), ("{0} GPa", lambda x: 1e9 * x), ("{0} kPa", lambda x: 1e3 * x))
"""other readings of a number that was meant as a stress"""
ELASTIC_MODULUS = Usual(0.05, 220.0, "GPa", 1e9, STRESSES[:2])
"""from earth to steel"""
BOND = Usual(1e-3, 10.0, "MPa", 1e6, STRESSES)
"""cohesion and tensile strength of joints"""
CRUSHING = Usual(0.1, 400.0, "MPa", 1e6, STRESSES)
"""compressive strength of joints, from earth mortar to granite"""
JOINT_STIFFNESS = Usual(1e-2, 1e4, "N/mm3", 1e9, (("{0} N/mm3", lambda x: 1e9 * x), ("{0} MN/m3", lambda x: 1e6 * x)))
"""normal and shear stiffness of mortar joints"""
GROUND_ACCELERATION = Usual(0.39, 9.81, "m/s2", 1.0, (("{0} g", lambda x: 9.81 * x),))
"""from 0.04 g, below which EN 1998-1 3.2.1(5) asks for nothing, to 1 g"""


def unusual(
    case: Case, wall: Wall, loads: list[LoadSums], materials: list[MaterialSums], joints: list[JointSums]
) -> list[str]:
    """Return what is unusual about a case, in sentences that begin with UNUSUAL."""
    said = [
        *_of_materials(materials),
        *_of_joints(joints),
        *_of_sizes(case, wall),
        *(text for one in loads for text in unusual_loads(one)),
        *_of_earthquake(case),
    ]
    return list(dict.fromkeys(said))


def unusual_material(unit_weights: Iterable[float], frictions: Iterable[float]) -> list[str]:
    """Return what is unusual about the unit weights and coefficients of friction of an imported wall, in sentences
    that begin with UNUSUAL."""
    said = [UNIT_WEIGHT.complaint("unit weight", value) for value in dict.fromkeys(unit_weights)]
    said += [FRICTION.complaint("friction", value) for value in dict.fromkeys(frictions)]
    return [text for text in said if text]


def _of_materials(materials: list[MaterialSums]) -> Iterator[str]:
    for one in materials:
        name = f" of {one.name}" if one.name else ""
        for usual, text, values in (
            (UNIT_WEIGHT, "unit weight", one.unit_weight),
            (ELASTIC_MODULUS, "elastic modulus", one.elastic_modulus),
        ):
            yield from filter(None, (usual.complaint(f"{text}{name}", value) for value in dict.fromkeys(values)))
    alike = defaultdict[tuple[tuple[float, ...], tuple[float, ...]], list[str]](list)
    for one in reversed(materials):
        alike[one.unit_weight, one.elastic_modulus].append(one.name or "blocks without a material")
    for (weight, modulus), names in alike.items():
        if len(names) > 1:
            yield (
                f"UNUSUAL: {', '.join(names[:-1])} and {names[-1]} have the same unit weight and elastic modulus "
                f"({weight[0] / 1e3:g} kN/m3, {modulus[0] / 1e9:g} GPa); [[wall.classes]] gives a material its own"
            )


def _of_joints(joints: list[JointSums]) -> Iterator[str]:
    for usual, name, without in (
        (FRICTION, "friction", None),
        (BOND, "cohesion", 0.0),
        (BOND, "tensile_strength", 0.0),
        (CRUSHING, "compressive_strength", math.inf),
        (JOINT_STIFFNESS, "normal_stiffness", math.inf),
        (JOINT_STIFFNESS, "shear_stiffness", math.inf),
    ):
        many: Counter[float] = Counter()
        for one in joints:
            values = getattr(one, name)
            many.update(dict.fromkeys(values if isinstance(values, tuple) else (values,), one.joints))
        for value, count in many.items():
            if value != without and (
                said := usual.complaint(f"{name.replace('_', ' ')} of {counted(count, 'joint')}", value)
            ):
                yield said


def _of_sizes(case: Case, wall: Wall) -> Iterator[str]:
    free = [block.polygon for block in wall.blocks if not block.fixed]
    length, height = np.ptp(np.vstack(free), axis=0)
    size = float(max(length, height))
    if not SLENDEREST * size <= wall.thickness <= THICKEST * size:
        usual = f"usual are {SLENDEREST * size:.3g} to {THICKEST * size:.3g} m"
        yield f"UNUSUAL: thickness {wall.thickness:g} m of a wall of {length:.3g} x {height:.3g} m, {usual}"
    if case.mesh.size is not None and case.mesh.size > size:
        yield f"UNUSUAL: mesh.size {case.mesh.size:g} m is larger than the wall; is {case.mesh.size:g} mm meant?"
    slip = case.contact.slip_tolerance
    stone = float(np.sqrt(block_areas(wall)[[not block.fixed for block in wall.blocks]].mean()))
    if slip is not None and slip > stone:
        stones = f"larger than a stone of mean size, {stone:.3g} m"
        yield f"UNUSUAL: contact.slip_tolerance {slip:g} m is {stones}; is {slip:g} mm meant?"
    moved = case.stepping.final_displacement
    if moved is not None and moved < LEAST_END * height:
        end = SteppingSettings().end_of(height)
        usual = f"a wall of {height:.3g} m; leave it out, and it is {1e3 * end:.3g} mm"
        yield f"UNUSUAL: stepping.final_displacement {moved:g} m is too little to load {usual}"
    if moved is not None and moved > height:
        yield f"UNUSUAL: stepping.final_displacement {moved:g} m is more than the wall's height; is {moved:g} mm meant?"


def unusual_loads(loads: LoadSums) -> Iterator[str]:
    """Yield what is unusual about extra dead loads, in the plane or in space."""
    for one in loads.extra:
        if one.resultant < LEAST_LOAD * loads.weight:
            share = f"{one.resultant:.3g} N in all, {one.resultant / loads.weight:.1g} of the wall's weight"
            yield f"UNUSUAL: extra dead load {one.name}: {share}; is kN meant?"


def _of_earthquake(case: Case) -> Iterator[str]:
    for state in limit_states(case.seismic):
        name = f"ground acceleration a_g of {state.name}"
        if said := GROUND_ACCELERATION.complaint(name, state.peak_ground_acceleration):
            yield said
    for mild, severe in pairwise(limit_states(case.seismic)):
        of_one_code = (mild.name in LIKE) == (severe.name in LIKE)
        if of_one_code and mild.peak_ground_acceleration >= severe.peak_ground_acceleration:
            yield f"UNUSUAL: a_g of {mild.name} is not below that of {severe.name}; are they interchanged?"
    for number, state in enumerate(case.seismic.limit_states):
        alone = [name for name in ("amplification", "reference_period") if getattr(state, name) is None]
        if case.seismic.spectrum == "ntc2018" and alone and len(limit_states(case.seismic)) > 1:
            own = f"has no own {' and '.join(alone)}, which depend on the return period"
            yield f"UNUSUAL: seismic.limit_states.{number} ({state.name}) {own}: that of [seismic] is taken"
    if (drift := case.seismic.largest_drift) is not None and drift > LARGEST_DRIFT:
        yield f"UNUSUAL: seismic.largest_drift {drift:g}, usual are up to {LARGEST_DRIFT:g}; is {drift:g} % meant?"

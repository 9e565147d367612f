"""What a pushover will need, before it is begun: unknowns and memory, against what the machine has, and time.

Unknowns follow from outlines, element size and layers; memory from how much MUMPS stores for them, which grows with
the power 4/3 of the unknowns of a solid (nested dissection: A. George, SIAM J. Numer. Anal. 10 (1973) 345-363) once
the factors outgrow everything else. Measured on micro-FE of wall 1 of Ferris and Tin-Loi (peak memory of the process):

    unknowns       1,817    9,845   19,689   46,437
    MB               163      217      328      603

Time is Newton iterations times what one costs. Walls of one layer of elements are nearly plane: one iteration costs
2.7 to 3.7 microseconds an unknown from 1,800 to 120,000 of them (benchmarks/scaling.csv); solids of many layers grow
faster. How many iterations a curve takes is known afterwards: 199 to 443 on benchmark 1 (benchmarks/walls.csv). So a
time is right within a factor of UNCERTAIN, on a processor core of its own. All of these were measured before nodes
behind the middle of the thickness ceased to be unknowns (front.py); unknowns are counted without them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from orchestrator.basis.errors import CaseError
from orchestrator.basis.printed import millimetres
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.pushover.meshing import MeshSettings
from orchestrator.pushover.toes import element_ends

BASE = 150e6
"""bytes of the program and its libraries"""
PER_UNKNOWN = 10e3
"""bytes of one unknown in a system of up to LARGE unknowns"""
LARGE = 5e4
"""unknowns above which memory grows faster than they do"""
PER_ITERATION = 3.2e-6
"""s of one Newton iteration and unknown"""
ITERATIONS = 500
"""Newton iterations of a whole curve, failed attempts included"""
UNCERTAIN = 5.0
"""factor by which a time may be less or more"""
GRADED = 3.0
"""triangles over edges of an outline whose elements grow from its toes (measured, about 3); inside of a large one are
1 / growth more for each edge (2.1 to 4.3 with 0.7, up to 5.7 with 0.3)"""
SECOND_ORDER = 6.0
"""unknowns of 10-node tetrahedra over those of 4-node ones"""
WARNED = 0.5
"""share of the free memory beyond which a run says that it is large"""
MEMORY = Path("/proc/meminfo")
"""what the machine has"""
CONTROL_GROUP = Path("/sys/fs/cgroup")
"""of a container, if there is one"""
LIMIT = "memory.max"
"""file of a control group with the most it may use, bytes"""
USED = "memory.current"
"""file of a control group with what it uses, bytes"""


@dataclass(frozen=True, slots=True)
class Estimate:
    """Expected unknowns of the linear system and memory in bytes: right within a factor of 2; largest element, m."""

    unknowns: int
    memory: float
    element: float

    @property
    def seconds(self) -> tuple[float, float]:
        """Return between which times (s) the whole curve is computed, on one core."""
        likely = ITERATIONS * PER_ITERATION * self.unknowns
        return likely / UNCERTAIN, likely * UNCERTAIN

    def __str__(self) -> str:
        elements = f"elements of {millimetres(self.element)}"
        return f"about {self.unknowns:,} unknowns ({elements}), {self.memory / 1e9:.2g} GB"


def time_in_words(expected: Estimate) -> str:
    """Return the expected time, with its uncertainty."""
    return f"it takes {' to '.join(_readable(seconds) for seconds in expected.seconds)} on a core of its own"


def _readable(seconds: float) -> str:
    for unit, name in ((3600.0, "h"), (60.0, "min")):
        if seconds >= 1.5 * unit:
            return f"{seconds / unit:.2g} {name}"
    return f"{max(seconds, 1.0):.2g} s"


def estimate(bodies: Bodies, settings: MeshSettings, element_order: int = 1) -> Estimate:
    """Return what the finite elements of the moving bodies will need."""
    in_plane = on_outline = 0.0
    size = settings.size_of(bodies)
    ends = element_ends(bodies, size, settings.toe_offset)
    for body in bodies.bodies[: bodies.moving]:
        edges = np.concatenate(
            [np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1) for ring in (body.exterior, *body.holes)]
        )
        least = [1.0 + len(ends.get((body.number, k), ())) for k in range(len(edges))]
        boundary = float(np.maximum(np.ceil(edges / size), least).sum())
        graded = any((body.number, k) in ends for k in range(len(edges)))
        grown = (GRADED + 1.0 / settings.growth) * boundary if settings.growth else math.inf
        even = body.area / (math.sqrt(3) / 4 * size**2)
        triangles = max(min(even, grown), (GRADED if graded else 1.0) * boundary - 2)
        on_outline += boundary
        in_plane += max(boundary, 0.5 * (triangles + boundary) + 1)  # Euler: 2 vertices = triangles + boundary + 2
    levels = settings.layers + 1 if element_order == 2 else settings.layers // 2 + 1  # nodes in front are enough
    displacements = 3 * levels * in_plane * (SECOND_ORDER if element_order == 2 else 1.0)
    unknowns = displacements + levels * on_outline + 1
    memory = BASE + PER_UNKNOWN * unknowns * max(1.0, (unknowns / LARGE) ** (1 / 3))
    return Estimate(round(unknowns), memory, size)


def free_memory(machine: Path = MEMORY, group: Path = CONTROL_GROUP) -> float:
    """Return the bytes that this process may still take, of the machine or of its control group; inf if unknown.

    machine: file in the form of /proc/meminfo; group: folder in the form of a control group.
    """
    return min(_of_machine(machine), _of_group(group))


def _of_machine(file: Path) -> float:
    try:
        lines = file.read_text().splitlines()
    except OSError:  # not Linux
        return math.inf
    return next((1024.0 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable:")), math.inf)


def _of_group(folder: Path) -> float:
    try:
        limit, used = ((folder / name).read_text().strip() for name in (LIMIT, USED))
    except OSError:
        return math.inf
    return math.inf if limit == "max" else float(limit) - float(used)


def warning_of(expected: Estimate, free: float) -> str:
    """Return a warning about a run that takes much of the memory, or "". Raises CaseError where it takes too much."""
    if expected.memory > free:
        problem = f"needs {expected}, this machine has {free / 1e9:.2g} GB free"
        raise CaseError("mesh.size", problem, "choose larger elements; fewer bodies need less")
    return f"WARNING: large: {expected} of {free / 1e9:.2g} GB free" if expected.memory > WARNED * free else ""

"""Walls in space against LMGC90 (dynamic, exact Coulomb friction): peak base shear against the range of limit analysis.

    python -m venv build/lmgc90 && build/lmgc90/bin/pip install compas_lmgc90
    .venv/bin/python benchmarks/lmgc90.py build/lmgc90/bin/python [block groove U T L]

LMGC90 runs in a Python of its own (it is no dependency): this file calls itself there, also for lmgc90_plane.py.
Forces on all blocks grow with time, 4 s to 1.15 times the associative multiplier; the largest base shear over the
weight is compared with the range. Blocks move while they are pushed, so it is 1 to 3 % above the first state. Writes
benchmarks/lmgc90.csv.
"""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

GRAVITY = 9.81
HERE = Path(__file__).resolve().parent
SECONDS, STEP = 4.0, 2e-3


def walls() -> dict[str, tuple[Any, tuple[float, float, float]]]:
    """Return wall and load direction of every comparison."""
    from orchestrator.basis.arrays import read_only
    from orchestrator.geometry.polyhedra import box, prism
    from orchestrator.space.generators.shapes import Plan, Stones, l_wall, t_wall, u_wall
    from orchestrator.space.wall import UPRIGHT, SpaceBlock, SpaceWall

    def of(shapes: list[Any], supports: int, friction: float) -> Any:
        blocks = tuple(SpaceBlock(k, shape, k < supports) for k, shape in enumerate(shapes))
        return SpaceWall("", blocks, friction, read_only(UPRIGHT))

    half = np.sqrt(0.5)
    axes = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 4.0, 0.0]])
    long = axes * [[1.0], [1.0], [3.0]]
    sides = [
        prism(np.array([[0.0, 0.0], [s * half, half], [s * half, 0.0]]), np.array([0, -4.0, 0]), long) for s in (-1, 1)
    ]
    wedge = prism(np.array([[0.0, 0.0], [half, half], [-half, half]]), np.zeros(3), axes)
    ground, plan, stones = box((-2.0, -2.0, -0.5), (2.0, 2.0, 0.0)), Plan(4, 2, 8), Stones()
    return {
        "block": (of([ground, box((-0.1, -0.2, 0.0), (0.1, 0.2, 1.0))], 1, 0.6), (1.0, 0.0, 0.0)),
        "groove": (of([*sides, wedge], 2, 0.5), (0.0, 1.0, 0.0)),
        "U": (u_wall(plan, stones), (0.0, -1.0, 0.0)),
        "T": (t_wall(plan, stones), (0.0, -1.0, 0.0)),
        "L": (l_wall(plan, stones), (0.0, -1.0, 0.0)),
    }


def compared(name: str, python: str) -> dict[str, Any]:
    """Return a row: range of limit analysis, LMGC90's base shear over the weight, and whether it is within 5 %."""
    from orchestrator.space.analysis import analyse
    from orchestrator.space.contacts import find_joints
    from orchestrator.space.loads import SpaceLoadSettings, loads_on

    wall, direction = walls()[name]
    assemblage = find_joints(wall)
    analysis = analyse(assemblage, loads_on(wall, SpaceLoadSettings(direction=direction)))
    started = perf_counter()
    motion = simulated(python, name, wall, direction, 1.15 * analysis.associative.load_multiplier)
    peak = float(abs(motion["shear"]).max())
    low, high = analysis.range or (np.nan, np.nan)
    assert analysis.headline is not None
    return {
        "wall": name,
        "associative": round(analysis.associative.load_multiplier, 5),
        "headline": round(analysis.headline.load_multiplier, 5),
        "lowest": round(low, 5),
        "highest": round(high, 5),
        "lmgc90": round(peak, 4),
        "within_5_percent": bool(0.95 * low <= peak <= 1.05 * high),
        "seconds": round(perf_counter() - started, 1),
    }


def simulated(
    python: str,
    name: str,
    wall: Any,
    direction: tuple[float, float, float],
    multiplier: float,
    seconds: float = SECONDS,
    rest: float = 0.0,
    until: float = np.inf,
) -> dict[str, np.ndarray]:
    """Run LMGC90 on a space wall: `rest` s under its weight, then a load that grows to `multiplier` in `seconds`.

    It ends before, when the centre of mass has moved by `until` m along the load. Returns the end of every step of
    STEP s: multiplier (s,), shear (s,): base shear along the load over the weight, and centre (s, b, 3): centres of
    the blocks in m.
    """
    given = {
        "vertices": [block.shape.vertices.tolist() for block in wall.blocks],
        "faces": [[list(face) for face in block.shape.faces] for block in wall.blocks],
        "fixed": wall.fixed.tolist(),
        "weights": wall.weights.tolist(),
        "direction": direction,
        "friction": wall.friction,
        "density": wall.blocks[0].unit_weight / GRAVITY,
        "multiplier": multiplier,
        "seconds": seconds,
        "rest": rest,
        "until": until,
    }
    path = HERE.parent / "build" / f"lmgc90_{name}.json"
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps(given))
    subprocess.run([python, __file__, "--simulate", str(path)], capture_output=True, check=True)
    return dict(np.load(path.with_suffix(".npz")))


def simulate(path: Path) -> None:
    """Run LMGC90 on what `simulated` wrote; write what it returns beside it."""
    from compas_lmgc90.solver import Solver

    given = json.loads(path.read_text())
    fixed, direction = given["fixed"], np.array(given["direction"])
    times = np.array([0.0, given["rest"], given["rest"] + given["seconds"], 1e3])[0 if given["rest"] else 1 :]
    shares = np.array([0.0, 0.0, 1.0, 1.0])[-len(times) :]
    solver = Solver(dt=STEP, density=given["density"])
    solver.geometry_from_v_f(
        [{"vertices": v, "faces": f} for v, f in zip(given["vertices"], given["faces"], strict=True)]
    )
    for k, held in enumerate(fixed):
        if held:
            solver.v_drvdof[k] = {component: np.zeros(6) for component in range(1, 7)}
            continue
        for axis, part in zip("xyz", direction, strict=True):
            if part:
                force = part * given["multiplier"] * given["weights"][k]
                solver.apply_force(k, f"F{axis}", np.array([times, force * shares]))
    solver.supports = fixed
    solver.contact_law("IQS_CLB", given["friction"])
    solver.preprocess()
    weight = sum(w for w, held in zip(given["weights"], fixed, strict=True) if not held)
    supports = {k + 1 for k, held in enumerate(fixed) if held}
    time = STEP * np.arange(1, round(times[-2] / STEP) + 1)
    shares_of_mass = np.where(fixed, 0.0, given["weights"]) / weight
    shears, centres = list[float](), list[np.ndarray]()
    for _ in time:
        result = solver.lmgc90.compute_one_step()
        shear = np.zeros(3)
        for bodies, force in zip(result.interaction_bodies, result.interaction_force_global, strict=True):
            if supports & set(bodies):
                shear += np.array(force) * (1.0 if bodies[0] in supports else -1.0)
        shears.append(shear @ direction / weight)
        centres.append(np.array([body[:3] for body in result.bodies]))
        if shares_of_mass @ (centres[-1] - centres[0]) @ direction > given["until"]:
            break
    multiplier = given["multiplier"] * np.interp(time[: len(shears)], times, shares)
    np.savez(path.with_suffix(".npz"), multiplier=multiplier, shear=shears, centre=centres)


def main() -> None:
    """Compare all walls named, or all."""
    if "--simulate" in sys.argv:
        simulate(Path(sys.argv[-1]))
        return
    rows = []
    for name in sys.argv[2:] or list(walls()):
        rows.append(compared(name, sys.argv[1]))
        print(rows[-1], flush=True)
        with (HERE / "lmgc90.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()

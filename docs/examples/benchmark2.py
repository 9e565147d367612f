"""Benchmark 2 from Python: a case file, two tolerances, increments looked at while they come.

A slender wall with one opening in irregular courses (this project's outline, see templates/benchmark2.toml). With
larger tolerances there are fewer macroblocks, and the wall is stiffer. Quick settings (1 mm of the top, one start of
the search for lower states): about 30 s.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from orchestrator import (
    PushoverCurve,
    analyse,
    find_joints,
    make_bodies,
    merged,
    mesh_bodies,
    pushover_increments,
    read_case,
    read_wall,
)

CASE = Path(__file__).parents[2] / "templates" / "benchmark2.toml"


def main(tolerances: Sequence[float] = (2.5e-7, 22.5e-6)) -> dict[int, PushoverCurve]:
    """Return the curve by number of macroblocks, for each tolerance tol_n."""
    case = read_case(CASE, ["stepping.final_displacement=1mm"])
    assemblage = find_joints(read_wall(case), case.joints)
    analysis = analyse(assemblage, case.limit_analysis)
    print(f"micro-LA: {analysis.headline.load_multiplier:.4f}")

    curves = {}
    for normal in tolerances:
        criteria = replace(case.macroblocks, scale="unit_power", tol_n=normal, tol_d=0.45)
        partition = merged(assemblage, analysis.headline.mechanism, criteria)
        bodies = make_bodies(assemblage, partition)
        meshes = mesh_bodies(bodies, case.mesh, cache=None)
        increments = []
        for increment in pushover_increments(bodies, meshes, case.elastic, stepping=case.stepping):
            increments.append(increment)
            if increment.number % 10 == 0:
                moved = 1e3 * increment.control_displacement
                print(f"{increment.number:4d} {increment.phase:12s} {moved:6.3f} mm {increment.load_multiplier:.4f}")
        curve = curves[partition.count] = PushoverCurve.from_increments(increments, "1 mm reached")
        print(f"tol_n {normal:g}: {partition.count} macroblocks, multiplier up to {curve.load_multiplier.max():.4f}")
    return curves


if __name__ == "__main__":
    main()

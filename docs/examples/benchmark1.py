"""Benchmark 1 from Python: limit analysis, macroblocks, pushover of wall 6 of Ferris and Tin-Loi (2001).

The limit multiplier is 0.348 with associative friction and 0.296 without dilation; the macroblocks come within 1 % of
the latter. Quick settings (5 mm of the top instead of 20): about 6 s.
"""

from pathlib import Path

from orchestrator import (
    Capacity,
    JointSettings,
    LimitAnalysis,
    MacroblockSettings,
    MeshSettings,
    SteppingSettings,
    analyse,
    check_assemblage,
    check_wall,
    find_joints,
    merged,
    push,
    read_blocks,
)

BLOCKS = Path(__file__).parents[2] / "meshes" / "ferris_tinloi_wall6.json"


def main() -> tuple[LimitAnalysis, Capacity]:
    """Run the chain stage by stage; every value can be looked at, changed (dataclasses.replace) and passed on."""
    wall = read_blocks(BLOCKS)
    check_wall(wall)
    assemblage = find_joints(wall, JointSettings())
    check_assemblage(assemblage)

    analysis = analyse(assemblage)
    print(f"associative {analysis.associative.load_multiplier:.4f}")
    print(f"without dilation {analysis.headline.load_multiplier:.4f}")

    partition = merged(assemblage, analysis.headline.mechanism, MacroblockSettings(tol_n=1e-3, tol_d=0.45))
    settings = {"mesh": MeshSettings(size=0.2), "stepping": SteppingSettings(final_displacement=0.005)}
    pushed = push(assemblage, analysis, partition, **settings)
    print(f"{partition.count} macroblocks, {pushed.summary.tetrahedra} tetrahedra")

    capacity = pushed.capacity
    peak = f"peak {capacity.peak_multiplier:.4f} = {capacity.peak_base_shear / 1e3:.3f} kN"
    print(f"{peak}; {pushed.curve.stopped_because}")
    return analysis, capacity


if __name__ == "__main__":
    main()

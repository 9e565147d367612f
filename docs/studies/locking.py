"""Which macroblock locks benchmark 2: with 27 bodies the wall is right, with 21 it is 20 % too strong.

    python docs/studies/locking.py

writes locking.md (locking_head.md with the tables put in) beside this file. Each of the 21 bodies that unites several
of the 27 is taken apart again, alone; then each stone of the body that matters. Multipliers are those of rigid bodies;
two partitions are pushed too (kept in results/tolerances).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from stored import markdown
from tolerances import FILES, FOLDER, PROJECT, pushed

from orchestrator import (
    Assemblage,
    JointSettings,
    MacroblockSettings,
    Partition,
    analyse,
    find_joints,
    merged,
    partition_of,
    read_blocks,
)
from orchestrator.macroblocks.merged_blocks import merged_multiplier
from orchestrator.storage import write_text

FINE, COARSE = 2.5e-7, 1e-6
"""tol_n, unit_power, at tol_D = 450 mm"""


def multipliers(assemblage: Assemblage, partition: Partition) -> list[str]:
    """Return number of bodies and both multipliers of them as rigid ones."""
    found = [merged_multiplier(assemblage, partition.body_of_block, rule) for rule in ("associative", "sequence")]
    return [str(partition.count), *("not settled" if value is None else f"{value:.4f}" for value in found)]


def apart(assemblage: Assemblage, fine: Partition, coarse: Partition) -> Iterator[tuple[str, Partition]]:
    """Yield what is taken apart, and the partition: single bodies, then single stones of the first of them."""
    stones = [block.id for block in assemblage.wall.blocks]
    for body in range(coarse.count):
        inside = coarse.body_of_block == body
        parts = [np.flatnonzero(fine.body_of_block == part) for part in np.unique(fine.body_of_block[inside])]
        if len(parts) == 1:
            continue
        small = sorted(parts, key=len)[:-1]
        said = " and ".join(", ".join(str(stones[k]) for k in part) for part in small)
        group = np.where(inside, len(stones) + fine.body_of_block, coarse.body_of_block)
        yield f"body of {inside.sum()} stones, without {said}", partition_of(assemblage, group)
        if inside.sum() == largest(coarse, fine):
            for part in small:
                alone = np.where(np.isin(np.arange(len(stones)), part), len(stones), coarse.body_of_block)
                name = ", ".join(str(stones[k]) for k in part)
                yield f"the same, without {name} alone", partition_of(assemblage, alone)


def largest(coarse: Partition, fine: Partition) -> int:
    """Return the stones of the largest body of `coarse` that unites several of `fine`."""
    pairs = {(c, f) for c, f in zip(coarse.body_of_block, fine.body_of_block, strict=True) if c < coarse.count}
    united = [body for body in range(coarse.count) if sum(c == body for c, _ in pairs) > 1]
    return max(int(np.sum(coarse.body_of_block == body)) for body in united)


def main() -> None:
    """Write the page."""
    assemblage = find_joints(read_blocks(PROJECT / FILES["benchmark 2"]), JointSettings())
    analysis = analyse(assemblage)
    fine, coarse = (
        merged(assemblage, analysis.headline.mechanism, MacroblockSettings(scale="unit_power", tol_n=normal))
        for normal in (FINE, COARSE)
    )
    split = list(apart(assemblage, fine, coarse))
    rows = [
        [f"tol_n {FINE:g}", *multipliers(assemblage, fine)],
        [f"tol_n {COARSE:g}", *multipliers(assemblage, coarse)],
    ]
    rows += [[name, *multipliers(assemblage, partition)] for name, partition in split]
    pushes = [
        [name, str(partition.count), f"{pushed(assemblage, partition)['peak_N'] / analysis.weight:.4f}"]
        for name, partition in ((f"tol_n {FINE:g}", fine), (f"tol_n {COARSE:g}", coarse), split[0])
    ]
    page = (FOLDER / "locking_head.md").read_text()
    page = page.replace("{{rigid}}", markdown(["taken apart", "bodies", "associative", "sequence"], rows))
    write_text(FOLDER / "locking.md", page.replace("{{pushed}}", markdown(["bodies of", "bodies", "FE peak"], pushes)))


if __name__ == "__main__":
    main()

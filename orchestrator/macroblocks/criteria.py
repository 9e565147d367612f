"""Macroblocks: blocks that move as one body in the collapse mechanism, merged by criteria (3) and (4).

With t the displacement of block i or j evaluated at their joint and C their centres of rotation, both merge when

    (3)  |t_n,i - t_n,j| <= tol_n,   |t_s,i - t_s,j| <= tol_s,   |t_r,i - t_r,j| <= tol_r
    (4)  |C_i - C_j| <= tol_D

Distances of criterion (4) where a centre is not a point, defined once:

    two blocks at rest: 0;  one at rest, one moving: infinite;
    two in translations of one velocity: 0;  of different velocities, of one direction too: infinite;
    one in translation, one rotating: infinite.

At rest means slower than 1e-6 of the fastest block; in translation means that the centre is more than 1e6 wall lengths
away (limit_analysis.centres_of_rotation). Szabo, Funari and Lourenco 2023, Eq. (3) and (4).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Gt, Le

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, read_only
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.basis.graphs import connected_groups
from orchestrator.basis.units import Unit
from orchestrator.limit_analysis import Mechanism, centres_of_rotation
from orchestrator.limit_analysis.paper.limit_state import Scale
from orchestrator.masonry.block_properties import block_centroids
from orchestrator.masonry.joints import Assemblage, fingerprint_of_places

PROGRAM_NOISE = 1e-9
"""relative displacements below this part of the largest displacement are noise of the linear program"""
SAME_VELOCITY = 1e-3
"""difference of two translations, part of the faster, that counts as none: courses that slide over each other at
different speeds have one centre at infinity, but are no body"""


RelativeTolerance = Annotated[float, Ge(0), Unit("", may_be_infinite=True)]
"""largest difference of displacements, or of rotations, that counts as none"""
CentreDistance = Annotated[float, Ge(0), Unit("m", may_be_infinite=True)]
"""largest distance of two centres of rotation that count as one"""
TOLERANCES = ("tol_n", "tol_s", "tol_r", "tol_d")
"""settings of criteria (3) and (4)"""


@dataclass(frozen=True, slots=True)
class MacroblockSettings(Checked):
    """Tolerances of criteria (3) and (4); `inf` means no condition. Velocities are the mechanism's in `scale`."""

    choose: Literal["tolerances", "automatic"] = "automatic"
    """automatic: fewest bodies found that keep micro-LA's headline; a case that names a tolerance means tolerances"""
    margin: Annotated[float, Gt(0), Le(1)] = 0.01
    """of the automatic choice: how far the multipliers of the rigid macroblocks may be from micro-LA's, part of them"""
    scale: Scale = "unit_displacement"
    """of the mechanism: its largest displacement is 1, or "unit_power", as the linear program returns it (N and m)"""
    evaluate_at: Literal["midpoint", "ends"] = "midpoint"
    """where a joint's opening is compared with tol_n: mean of both ends, or the larger one"""
    tol_n: RelativeTolerance = 1e-3
    """largest relative normal displacement at the joint"""
    tol_s: RelativeTolerance = inf
    """largest relative tangential displacement at the joint"""
    tol_r: RelativeTolerance = inf
    """largest relative rotation"""
    tol_d: CentreDistance = 0.45
    """tol_D of the paper: largest distance between the centres of rotation"""


@dataclass(frozen=True, eq=False, slots=True)
class Partition:
    """Which body each block belongs to.

    body_of_block (n,): moving bodies are numbered 0 ... count-1 in the order of their first block; supports follow,
    one body each (count, count+1, ...), never merged.
    vanished_joints (v,): joints inside a body; of these, `transitive_joints` exceed a tolerance themselves: their
    blocks are joined through others. `tolerances` is None for partitions that come from no mechanism. places: of which
    blocks and joints it is (`fingerprint_of_places`), "" where that is not known.
    """

    body_of_block: IntArray
    count: int
    vanished_joints: IntArray
    transitive_joints: IntArray
    tolerances: MacroblockSettings | None
    remarks: tuple[str, ...] = ()
    places: str = ""


def refuse_other_partition(assemblage: Assemblage, partition: Partition) -> None:
    """Raise CaseError for a partition of other blocks, or of others that meet, than those of the wall given."""
    another = len(partition.body_of_block) != len(assemblage.wall.blocks)
    if another or partition.places not in ("", fingerprint_of_places(assemblage)):
        problem = "is not of this wall: other blocks, or other joints between them"
        raise CaseError("partition", problem, "make it of the assemblage that is given, as by macroblocks_of")


def stones_of(assemblage: Assemblage) -> int:
    """Return the number of blocks that are no support."""
    return sum(not block.fixed for block in assemblage.wall.blocks)


def one_body_per_block(assemblage: Assemblage) -> Partition:
    """Return the partition in which every stone is a body (micro-FE)."""
    return _partition(assemblage, np.zeros(assemblage.joints.count, bool), None)


def one_body(assemblage: Assemblage) -> Partition:
    """Return the trivial partition: all stones that are connected without the supports are one body."""
    return _partition(assemblage, np.ones(assemblage.joints.count, bool), None)


def partition_of(assemblage: Assemblage, group: IntArray) -> Partition:
    """Return the partition in which neighbouring blocks of one group (n,) are one body."""
    return _partition(assemblage, group[assemblage.joints.i] == group[assemblage.joints.j], None)


def merged(assemblage: Assemblage, mechanism: Mechanism, settings: MacroblockSettings) -> Partition:
    """Return the partition by criteria (3) and (4).

    Raises CaseError for a mechanism of another wall, and for a tolerance below the mechanism's noise.
    """
    size = len(assemblage.wall.blocks), assemblage.joints.count
    if (len(mechanism.velocities), len(mechanism.opening)) != size:
        problem = f"has {len(mechanism.velocities)} blocks and {len(mechanism.opening)} joints, the wall {size[0]} and"
        remedy = "give a mechanism of this wall, as analyse(assemblage).headline.mechanism"
        raise CaseError("mechanism", f"{problem} {size[1]}", remedy)
    scaled = mechanism.scaled(settings.scale)
    _refuse_noise(settings, scaled)
    within = _within_criterion_3(assemblage, scaled, settings) & _within_criterion_4(
        assemblage, scaled.velocities, settings.tol_d
    )
    return _partition(assemblage, within, settings)


def _within_criterion_3(assemblage: Assemblage, mechanism: Mechanism, settings: MacroblockSettings) -> BoolArray:
    """Return (k,): whether normal, tangential and rotational differences are within their tolerances."""
    opening = np.abs(mechanism.opening.mean(axis=1))
    if settings.evaluate_at == "ends":
        opening = np.abs(mechanism.opening).max(axis=1)
    rotation = mechanism.velocities[:, 2]
    turned = np.abs(rotation[assemblage.joints.i] - rotation[assemblage.joints.j])
    slip = np.abs(mechanism.slip)
    return (opening <= settings.tol_n) & (slip <= settings.tol_s) & (turned <= settings.tol_r)


def _within_criterion_4(assemblage: Assemblage, velocities: FloatArray, largest: float) -> BoolArray:
    """Return (k,): whether the centres of rotation of both blocks are within `largest` (m)."""
    centres = centres_of_rotation(velocities, block_centroids(assemblage.wall))
    i, j = assemblage.joints.i, assemblage.joints.j
    resting, translating = np.isnan(centres).any(axis=1), np.isinf(centres).any(axis=1)
    with np.errstate(invalid="ignore"):  # centres at infinity are dealt with below, centres of resting blocks are nan
        near = np.linalg.norm(centres[i] - centres[j], axis=1) <= largest
    same_point = near & ~translating[i] & ~translating[j]
    both_at_rest = resting[i] & resting[j]
    both_translate = translating[i] & translating[j] & _alike(velocities[i, :2], velocities[j, :2])
    return same_point | both_at_rest | both_translate | np.isinf(largest)


def _alike(first: FloatArray, second: FloatArray) -> BoolArray:
    """Return where two translations (k, 2) have one velocity, to `SAME_VELOCITY`."""
    faster = np.maximum(np.linalg.norm(first, axis=1), np.linalg.norm(second, axis=1))
    same: BoolArray = np.linalg.norm(first - second, axis=1) <= SAME_VELOCITY * faster
    return same


def _refuse_noise(settings: MacroblockSettings, mechanism: Mechanism) -> None:
    noise = PROGRAM_NOISE * mechanism.largest_displacement
    for name in ("tol_n", "tol_s", "tol_r"):
        if 0 < getattr(settings, name) < noise:
            problem = f"{getattr(settings, name):g} is below the mechanism's numerical noise"
            raise CaseError(f"macroblocks.{name}", problem, f"use at least {noise:.1e} (scale {settings.scale})")


def _partition(assemblage: Assemblage, within: BoolArray, settings: MacroblockSettings | None) -> Partition:
    """Return connected components of the joints `within` (k,) tolerance that touch no support."""
    fixed = np.array([block.fixed for block in assemblage.wall.blocks])
    i, j = assemblage.joints.i, assemblage.joints.j
    merges = within & ~fixed[i] & ~fixed[j]
    group = connected_groups(len(fixed), i[merges], j[merges])
    body_of_block = np.zeros(len(fixed), np.int64)
    _, first, component = np.unique(group[~fixed], return_index=True, return_inverse=True)
    body_of_block[~fixed] = np.argsort(np.argsort(first))[component]
    count = len(first)
    body_of_block[fixed] = count + np.arange(fixed.sum())
    vanished = np.flatnonzero(body_of_block[i] == body_of_block[j])
    return Partition(
        body_of_block=read_only(body_of_block, np.int64),
        count=count,
        vanished_joints=read_only(vanished, np.int64),
        transitive_joints=read_only(vanished[~within[vanished]], np.int64),
        tolerances=settings,
        remarks=_remarks(count, int(np.sum(~fixed)), int(np.sum(~within[vanished])), settings),
        places=fingerprint_of_places(assemblage),
    )


def _remarks(count: int, blocks: int, transitive: int, settings: MacroblockSettings | None) -> tuple[str, ...]:
    remarks = []
    if count == 1 and blocks > 1:
        remarks.append("all blocks are one macroblock: it can only slide or overturn on its support")
    if transitive and settings is not None:
        remarks.append(
            f"{transitive} joints inside macroblocks exceed a tolerance; their blocks are joined through others"
        )
    return tuple(remarks)

"""Macroblocks pushed, and finer ones until these bear the same: macroblocks/refinement.py says when, and why.

    partition, pushed = push_and_refine(assemblage, analysis, macroblocks_of(assemblage, analysis), push_partition)

with `push_partition` a function of the partition, e.g. lambda p: push(assemblage, analysis, p, load).
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace

from orchestrator.app.pushed import Pushed
from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.macroblocks.criteria import MacroblockSettings, Partition, stones_of
from orchestrator.macroblocks.refinement import Borne, finer, is_enough, remarked
from orchestrator.masonry.joints import Assemblage

logger = logging.getLogger(__name__)


def push_and_refine(
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    partition: Partition,
    push_partition: Callable[[Partition], Pushed],
    margin: float = MacroblockSettings().margin,
) -> tuple[Partition, Pushed]:
    """Push macroblocks, and finer ones until finite elements, limit analysis and twice as many agree; return the last.

    margin: as in MacroblockSettings. The remarks of the partition say what was pushed before.
    """
    said, borne, stones = partition.remarks, list[Borne](), stones_of(assemblage)
    while True:
        done = push_partition(partition)
        peak, is_peak = done.capacity.peak_multiplier, done.capacity.peak_reached
        borne.append(Borne(partition.count, peak, is_peak, done.summary.valid))
        more = None if is_enough(analysis, margin, borne, stones) else finer(assemblage, analysis, partition)
        if more is None:
            return remarked(analysis, margin, replace(partition, remarks=said), borne), done
        logger.info("%d macroblocks bear %.4f: %d are pushed", partition.count, peak, more.count)
        partition = more

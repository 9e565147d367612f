"""More macroblocks, where more may tell another peak.

Joining stones only takes motions away from a wall. Bodies that fail as rigid ones where the stones do may still bear
another load in finite elements: without dilation states are not unique, and elastic bodies come to another one (6 and
12 bodies of 49 stones of an arch bear 0.404; every stone 0.4235, limit analysis 0.434). Which of two roads that should
agree is right more bodies tell, since in the end they are the stones. Each body is divided, so that there are twice as
many: of all ways to join its stones by the one that loses least energy (locking.py). Here 24 bodies bear 0.417.

It ends where finite elements and rigid blocks agree and, as with a mesh, twice as many bodies bear the same; where
twice as many are more than FEW, agreement alone is enough. Where what is left of rigid blocks as stones give way at
edges is less by more than twice the margin, there is much between the two (4 bodies of a thin arch of 24 voussoirs
0.0396 between 0.0364 and 0.0436, and every stone 0.0342): then twice as many have to bear the same in any case, and
again where these are FEW. It also ends where twice as many bear the same twice in a row, once they are more than FEW,
unless that is more than rigid blocks bear, whatever the interval: bodies that
interlock bear the same, too (3, 6 and 12 of 21 round stones 0.187, and every stone 0.136; 14 and 28 of 59 stones with a
window, 1.5 % above rigid blocks, 11 % more than every stone). Nor where it is FAR_BELOW what rigid blocks on springs as
soft as the stones bear in large displacements: bodies may be in another state, the same one however many they are (6
and 12 of 47 stones of rubble 0.206, as a column at their edge leans away, and every stone 0.363). At last it ends
with every stone, which are next where twice as many would be more than half of them, or before more than MOST bodies. A
curve that is not valid counts as no agreement. What is to be agreed with is what is like the curve: in large
displacements the peak of rigid blocks there, where it was passed, else the headline, down to what is left of it as
stones give way at edges; never an interval of states, between whose ends any number of bodies may bear something.
Bodies that supports hold, once they have moved, have no peak, and there is nothing to agree with.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

from orchestrator.basis.printed import as_lambda
from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.limit_analysis.search.loading_path import SAME_ANSWER
from orchestrator.macroblocks.automatic import ELSEWHERE, states_to_keep
from orchestrator.macroblocks.criteria import Partition, partition_of, stones_of
from orchestrator.macroblocks.locking import hierarchy
from orchestrator.masonry.joints import Assemblage

FEW = 0.2
"""bodies over stones up to which it is tried whether twice as many bear the same, which cost little, and up to which it
says nothing against limit analysis that they do"""

MOST = 200
"""bodies that are pushed at most in the place of fewer: more take minutes, and every stone is there to be asked for"""

FAR_BELOW = 0.05
"""part by which bodies may bear less than rigid blocks in large displacements for the same twice in a row to count"""

HELD = "supports hold these macroblocks: whether they hold every stone, run --model micro says"
"""what is said of macroblocks that no load brings down: stones may go where they cannot"""


@dataclass(frozen=True, slots=True)
class Borne:
    """What macroblocks bore in finite elements.

    multiplier: at the peak of the base shear; is_peak: whether the curve shows that it is one, else they bear at least
    as much; is_valid: whether the curve passed its checks, to its end; in_large: whether in large displacements;
    is_held: whether it ended as supports hold the wall.
    """

    bodies: int
    multiplier: float
    is_peak: bool
    is_valid: bool
    in_large: bool = True
    is_held: bool = False

    @property
    def words(self) -> str:
        """How many bodies bear which multiplier."""
        return f"{self.bodies} bear {as_lambda(self.multiplier)}{'' if self.is_valid else ' (not valid)'}"


def more_bodies(bodies: int, stones: int) -> int | None:
    """Return how many bodies are pushed after so many: twice as many, or every stone where these are more than half of
    all stones, which save little; None where they are that, or more than MOST."""
    count = 2 * bodies if 4 * bodies <= stones else stones
    return None if count == bodies or count > MOST else count


def finer(assemblage: Assemblage, analysis: LimitAnalysis, partition: Partition) -> Partition | None:
    """Return more bodies (`more_bodies`), each a part of one of `partition`; None where there are no more."""
    count = more_bodies(partition.count, stones_of(assemblage))
    if count is None:
        return None
    mechanisms = [state.mechanism for state in states_to_keep(analysis)]
    groups = hierarchy(assemblage, mechanisms, partition.body_of_block)[::-1]  # from these bodies to every stone
    return partition_of(assemblage, groups[count - partition.count])


def rigid_multiplier(analysis: LimitAnalysis, in_large: bool) -> float:
    """Return what rigid blocks bear, as far as bodies in large displacements (or not) are to bear the same."""
    drawn, moved = (analysis.drawn or analysis.headline).load_multiplier, analysis.rigid_peak
    return moved if in_large and moved is not None else drawn


def least_multiplier(analysis: LimitAnalysis, in_large: bool) -> float:
    """Return what is left of that as stones give way at edges that they turn about."""
    rigid, pressed = rigid_multiplier(analysis, in_large), analysis.pressed_peak
    return rigid if pressed is None or not in_large else min(rigid, pressed)


def off_limit_analysis(analysis: LimitAnalysis, multiplier: float) -> float:
    """Return by what part a multiplier lies above all that stones may bear (> 0) or below it (< 0)."""
    known = [rigid_multiplier(analysis, False), rigid_multiplier(analysis, True), least_multiplier(analysis, True)]
    known += analysis.interval or ()
    most, least = max(known), min(known)
    if multiplier > most:
        return multiplier / most - 1.0
    return min(multiplier / least - 1.0, 0.0) if least > 0.0 else 0.0


def alike(margin: float) -> float:
    """Return by what part what macroblocks bear may differ."""
    return max(margin, SAME_ANSWER)


def may_be_last(analysis: LimitAnalysis, margin: float, multiplier: float) -> bool:
    """Return whether bodies that bear a multiplier may be the last: not if rigid blocks bear less."""
    rigid = max(rigid_multiplier(analysis, in_large) for in_large in (False, True))
    return multiplier <= (1.0 + alike(margin)) * rigid


def is_enough(analysis: LimitAnalysis, margin: float, borne: list[Borne], stones: int) -> bool:
    """Return whether the last of the macroblocks that were pushed, each finer than those before, need no others.

    stones: blocks that are no support.
    """
    last, off = borne[-1], off_limit_analysis(analysis, borne[-1].multiplier)
    if not last.is_valid:
        return False
    if last.is_held or (off < 0.0 and not last.is_peak):
        return True
    changes = [abs(fine.multiplier / coarse.multiplier - 1.0) for coarse, fine in pairwise(borne)]
    same = [change <= alike(margin) for change in changes]
    most, least = (of(analysis, last.in_large) for of in (rigid_multiplier, least_multiplier))
    if (1.0 - alike(margin)) * least <= last.multiplier <= (1.0 + alike(margin)) * most:
        if (1.0 - alike(margin)) * most <= (1.0 + alike(margin)) * least:
            return same[-1:] == [True] or 2 * last.bodies > FEW * stones
        return same[-2:] == [True, True] or (same[-1:] == [True] and last.bodies > FEW * stones)
    known = last.in_large and analysis.rigid_peak is not None
    near = last.multiplier <= (1.0 + alike(margin)) * most and not (known and off < -FAR_BELOW)
    return near and same[-2:] == [True, True] and last.bodies > FEW * stones


def remarked(
    analysis: LimitAnalysis, margin: float, partition: Partition, borne: list[Borne], stones: int
) -> Partition:
    """Return the partition pushed last with what is to be said of it: those before, and whether it agrees."""
    last = borne[-1]
    off, said = off_limit_analysis(analysis, last.multiplier), list(partition.remarks)
    if len(borne) > 1:
        said = [remark for remark in said if remark != ELSEWHERE]  # that was of the first
        pushed = ", ".join(one.words for one in borne)
        rigid = as_lambda(rigid_multiplier(analysis, last.in_large))
        said.append(f"refined: in finite elements {pushed} (rigid blocks {rigid})")
    if last.is_held:
        said += [HELD] if last.bodies < stones else []
    elif abs(off) > alike(margin) and (off > 0.0 or last.is_peak):
        apart = f"bear {abs(off):.1%} {'more' if off > 0.0 else 'less'} in finite elements than in limit analysis"
        are_stones = last.bodies == stones
        said.append(
            f"all stones {apart}" if are_stones else f"these macroblocks {apart}: compare with run --model micro"
        )
    return replace(partition, remarks=tuple(said))

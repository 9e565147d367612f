"""Which failures are local: one rule for limit analysis and finite elements.

What moves, or falls, before the wall comes to rest again is one failure. It is local while it is less than
`local_share` of the dead load and no more than MOST_LOCAL has fallen in all. Else it is the wall that fails.
"""

from __future__ import annotations

MOST_LOCAL = 0.5
"""share of the dead load that may fall in local failures, all together: of less than half a wall no multiplier is its
own"""


def is_local(share: float, gone: float, local_share: float) -> bool:
    """Return whether a failure of a share of the dead load is local, where a share `gone` has fallen before."""
    return share < local_share and gone + share <= MOST_LOCAL

"""What the page says of ties: their forces under gravity, at the peak and at the end, and where they yield."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from orchestrator import storage
from orchestrator.masonry.ties import Tie
from orchestrator.present.tie_states import state_of
from orchestrator.storage.stored_run import StoredModel


def tie_rows(model: StoredModel, ties: Sequence[Tie]) -> list[dict[str, Any]]:
    """Return a row for each tie of a model: blocks, forces in N, what it does at the end, and the load multiplier and
    displacement (m) of the first state in which it yields, None for none."""
    if not ties:
        return []
    curve, stored = model.curve, storage.read_ties(model.store.folder)
    pull = np.array([stored[step] for step in curve.step.tolist()])
    peak = int(np.argmax(np.where(curve.moving == 0, curve.base_shear_N, -np.inf)))
    moved = curve.control_displacement_m - curve.control_displacement_m[0]
    rows = []
    for number, (tie, force) in enumerate(zip(ties, pull.T.tolist(), strict=True), 1):
        states = [state_of(one, tie.strength) for one in force]
        first = states.index("yields") if "yields" in states else None
        forces = {"gravity": force[0], "peak": force[peak], "end": force[-1], "strength": tie.strength}
        yields = None if first is None else (float(curve.load_multiplier[first]), float(moved[first]))
        rows.append(forces | {"number": number, "blocks": tie.blocks, "state": states[-1], "yields": yields})
    return rows

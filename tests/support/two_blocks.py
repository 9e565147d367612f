"""A block file of two blocks on the ground, as a record to be spoilt."""

from __future__ import annotations

from copy import deepcopy

GROUND = {"id": 0, "polygon": [[-1, -1], [3, -1], [3, 0], [-1, 0]], "fixed": True}
LEFT = {"id": 1, "polygon": [[0, 0], [1, 0], [1, 1], [0, 1]]}
RIGHT = {"id": 2, "polygon": [[1, 0], [2, 0], [2, 1], [1, 1]]}
WALL = {
    "name": "two blocks",
    "units": {"length": "m", "unit_weight": "kN/m3"},
    "thickness": 0.5,
    "unit_weight": 20.0,
    "friction": 0.6,
    "blocks": [GROUND, LEFT, RIGHT],
}


def changed(path, value):
    """Return WALL with the value at `path` replaced, or removed where the value is None."""
    record = deepcopy(WALL)
    target = record
    for key in path[:-1]:
        target = target[key]
    if value is None:
        del target[path[-1]]
    else:
        target[path[-1]] = value
    return record

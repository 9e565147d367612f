"""A stone with one leaning side: 0.6 m wide below, 0.3 m above, 0.9 m high, upright on the left, and its load cases."""

from __future__ import annotations

CASE = """
[wall]
blocks = "{blocks}.json"
[load]
{common}
[[load.cases]]
name = "+x mass"
[[load.cases]]
name = "-x mass"
direction = "-x"
[stepping]
final_displacement = "3 mm"
[run]
models = ["macro"]
"""


def stone(mirror):
    turned = [(-x, y) for x, y in reversed(SHAPE)] if mirror else SHAPE
    ground = [(-2, -0.2), (2, -0.2), (2, 0), (-2, 0)]
    return {
        "units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.1, "unit_weight": 25, "friction": 1.5,
        "blocks": [{"id": 0, "polygon": ground, "fixed": True}, {"id": 1, "polygon": turned}],
    }  # fmt: skip


SHAPE = [(0, 0), (0.6, 0), (0.3, 0.9), (0, 0.9)]

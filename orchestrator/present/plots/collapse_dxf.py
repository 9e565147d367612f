"""DXF of a collapse state: stones, supports, thrust and mechanism as polylines on layers of their own, in m (ezdxf)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from io import StringIO
from typing import TYPE_CHECKING

import numpy as np

from orchestrator.limit_analysis import LimitState
from orchestrator.masonry.joints import Assemblage
from orchestrator.present.plots.thrust import thrust
from orchestrator.present.plots.wall_pictures import DRAWN_DISPLACEMENT, displaced_blocks

if TYPE_CHECKING:
    from ezdxf.document import Drawing

LAYERS = {"blocks": 8, "supports": 9, "mechanism": 5, "thrust": 1, "numbers": 8}
"""layer -> colour of AutoCAD's index"""
METRES = 6
"""$INSUNITS"""


def mechanism_dxf(assemblage: Assemblage, state: LimitState) -> str:
    """Return a drawing of a state: the wall as it stands with its thrust, and the mechanism, its largest displacement
    drawn as DRAWN_DISPLACEMENT of the height. Equal states give equal drawings, in every process."""
    import ezdxf

    with _without_times():
        document = ezdxf.new("R2010", setup=False)
        _draw(document, assemblage, state)
        for name in sorted(document.entitydb.dxf_types_in_use()):  # `write` lists them as a set has them
            document.classes.add_class(name)
        stream = StringIO()
        document.write(stream)
    return stream.getvalue()


def _draw(document: Drawing, assemblage: Assemblage, state: LimitState) -> None:
    document.header["$INSUNITS"] = METRES
    for name, colour in LAYERS.items():
        document.layers.add(name, color=colour)
    space, wall = document.modelspace(), assemblage.wall
    moved = displaced_blocks(assemblage, state.mechanism, DRAWN_DISPLACEMENT)
    for block, displaced in zip(wall.blocks, moved, strict=True):
        layer = "supports" if block.fixed else "blocks"
        space.add_lwpolyline(block.polygon.tolist(), close=True, dxfattribs={"layer": layer})
        if block.fixed:
            continue
        space.add_lwpolyline(displaced.tolist(), close=True, dxfattribs={"layer": "mechanism"})
        height = 0.2 * float(np.ptp(block.polygon, axis=0).min())
        text = space.add_text(str(block.id), height=height, dxfattribs={"layer": "numbers"})
        text.set_placement(tuple(block.polygon.mean(axis=0)))
    for start, end in thrust(assemblage, state.joint_forces).segments.tolist():
        space.add_line(start, end, dxfattribs={"layer": "thrust"})


@contextmanager
def _without_times() -> Iterator[None]:
    """Let ezdxf make and write drawings without times and identities of their own."""
    from ezdxf import options

    before, options.write_fixed_meta_data_for_testing = options.write_fixed_meta_data_for_testing, True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before

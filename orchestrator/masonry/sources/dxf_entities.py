"""Entities of a DXF drawing as they are seen: on which layer, and whether they are shown (ezdxf).

Block references are written out. What they hold on layer 0 is on the layer of the reference; what is on a layer that is
off or frozen, or is invisible itself, is hidden, and so is all that a reference holds that is hidden or frozen (DXF
reference, TABLES and BLOCKS sections).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from orchestrator.masonry.sources.closed_outlines import Layers, is_chosen

DRAWN = ("LINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "LWPOLYLINE", "POLYLINE")
FILLED = ("SOLID", "TRACE", "3DFACE", "HATCH", "MPOLYGON")
"""areas whose outline is read where it is the only drawing of a stone"""
WITHOUT_OUTLINE = (
    "TEXT", "MTEXT", "ATTRIB", "ATTDEF", "DIMENSION", "ARC_DIMENSION", "LARGE_RADIAL_DIMENSION", "LEADER",
    "MULTILEADER", "TOLERANCE", "POINT", "RAY", "XLINE", "SHAPE",
)  # fmt: skip
"""what is beside the stones of a drawing; anything else that is not read may be a stone"""
OWN_LAYER = "0"
"""the layer whose content takes that of the block reference"""


@dataclass(frozen=True, eq=False, slots=True)
class Seen:
    """An entity, which is no block reference that can be written out, the layer it is on, and whether it is hidden."""

    entity: Any
    layer: str
    hidden: bool

    @property
    def kind(self) -> str:
        """Return its type as DXF names it."""
        return str(self.entity.dxftype())


def entities_of(document: Any) -> Iterator[Seen]:
    """Yield all entities of the model space, block references (arrays, nested ones) written out."""
    shown = _Shown(document)
    yield from shown.written_out(document.modelspace(), OWN_LAYER, False)


class _Shown:
    """What the layers of a drawing show."""

    def __init__(self, document: Any) -> None:
        self._blocks = document.blocks
        self._off = {str(layer.dxf.name).lower() for layer in document.layers if layer.is_off() or layer.is_frozen()}
        self._frozen = {str(layer.dxf.name).lower() for layer in document.layers if layer.is_frozen()}

    def written_out(self, entities: Iterable[Any], around: str, hidden: bool) -> Iterator[Seen]:
        """Yield entities of a block whose reference is on the layer `around`, all of them hidden or not."""
        for entity in entities:
            kind = entity.dxftype()
            own = str(entity.dxf.get("layer", OWN_LAYER))
            layer = around if own == OWN_LAYER else own
            unseen = hidden or bool(entity.dxf.get("invisible", 0))
            if kind == "INSERT" and self._is_known(entity.dxf.name):
                yield from self._reference(entity, layer, unseen or layer.lower() in self._frozen)
            elif kind == "MLINE":
                yield from self.written_out(entity.virtual_entities(), layer, unseen)
            else:
                yield Seen(entity, layer, unseen or layer.lower() in self._off)

    def _reference(self, reference: Any, layer: str, hidden: bool) -> Iterator[Seen]:
        lost: list[Any] = []
        for one in reference.multi_insert() if reference.mcount > 1 else (reference,):
            yield from self.written_out(one.attribs, layer, hidden)
            content = one.virtual_entities(skipped_entity_callback=lambda entity, _: lost.append(entity))
            yield from self.written_out(content, layer, hidden)
        yield from self.written_out((entity for entity in lost if entity.dxftype() != "INSERT"), layer, hidden)

    def _is_known(self, name: str) -> bool:
        block = self._blocks.get(name)
        return block is not None and not block.block.is_xref


def said_passed_over(left: Iterable[Seen], layers: Layers) -> list[str]:
    """Return one line for each chosen layer on which things were not read, how many of each kind; a warning where a
    stone may be among them."""
    patterns = (layers.blocks, layers.supports, layers.openings)
    count: dict[str, Counter[str]] = {}
    doubtful = set[str]()
    for one in left:
        if any(is_chosen(one.layer, each) for each in patterns):
            count.setdefault(one.layer, Counter())["hidden " * one.hidden + one.kind] += 1
            if not one.hidden and one.kind not in (*DRAWN, *FILLED, *WITHOUT_OUTLINE):
                doubtful.add(one.layer)
    said = []
    for layer, kinds in sorted(count.items()):
        listed = ", ".join(f"{number} {kind}" for kind, number in sorted(kinds.items()))
        warning = ("WARNING: ", "; draw as closed polylines what is a stone") if layer in doubtful else ("", "")
        said.append(f"{warning[0]}passed over on layer {layer!r}: {listed}{warning[1]}")
    return said

"""Block classes: blocks of one material and what they have besides their shape."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Annotated

from annotated_types import Ge, Lt, MinLen

from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.masonry.block_properties import ElasticModulus
from orchestrator.masonry.wall import Friction, Thickness, UnitWeight, Wall

PROPERTIES = ("unit_weight", "thickness", "friction", "elastic_modulus", "poisson_ratio")


@dataclass(frozen=True, slots=True)
class BlockClass(Checked):
    """Blocks of one material (of the block file); a value that is left out stays the wall's, or that of [elastic]."""

    material: Annotated[str, MinLen(1)]
    """name of the material"""
    unit_weight: UnitWeight | None = None
    """instead of the block file's"""
    thickness: Thickness | None = None
    """out of the wall's plane; a joint is as wide as the thinner of its two blocks. The finite elements spread weight
    and stiffness of a thinner block over the wall's thickness"""
    friction: Friction | None = None
    """coefficient of friction of all its joints, of two blocks the lower one; [joints] may change it"""
    elastic_modulus: ElasticModulus | None = None
    """Young's modulus; a macroblock has the mean of its blocks by volume"""
    poisson_ratio: Annotated[float, Ge(0), Lt(0.5)] | None = None
    """lateral contraction over axial strain"""


def with_classes(wall: Wall, classes: Iterable[BlockClass]) -> Wall:
    """Return the wall with the values of block classes, one after the other. Raises CaseError for no known material."""
    for number, block_class in enumerate(classes):
        known = sorted({block.material for block in wall.blocks} - {""})
        if block_class.material not in known:
            listed = ", ".join(known) or 'none yet: give blocks a "material" in the block file'
            raise CaseError(
                f"wall.classes.{number}.material", f"no block is of {block_class.material!r}", f"materials are {listed}"
            )
        changed = {name: value for name in PROPERTIES if (value := getattr(block_class, name)) is not None}
        blocks = (replace(b, **changed) if b.material == block_class.material else b for b in wall.blocks)
        wall = replace(wall, blocks=tuple(blocks))
    return wall

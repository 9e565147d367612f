"""Walls in space from numbers: those at the ends of what is allowed are walls, too."""

from __future__ import annotations

import pytest

from orchestrator.space.generators.shapes import Plan, Stones
from orchestrator.space.generators.vaults import Barrel, VaultMaterial, barrel_vault
from orchestrator.space.generators.walls import Openings, wall_with_openings
from orchestrator.space.wall import check_wall


@pytest.mark.parametrize("stone", [0.3, 0.9, 1.9, 2.0, 3.8, 4.0, 5.0])
def test_a_barrel_vault_is_as_long_as_it_was_to_be(stone):
    """Rows begin with half a stone in turn where that leaves a quarter of one at the end."""
    wall = barrel_vault(Barrel(length=2.0, stone=stone), VaultMaterial())
    check_wall(wall)
    along = [block.shape.vertices[:, 1] for block in wall.blocks]
    assert (min(one.min() for one in along), max(one.max() for one in along)) == pytest.approx((0.0, 2.0))
    assert min(one.max() - one.min() for one in along) > 0.249 * min(stone, 2.0)


def test_a_facade_that_is_all_corners_has_none_between_them():
    """Two returns, one thickness each, and no room for a stone of the facade in every other course."""
    stones = Stones(length=0.4, thickness=0.4)
    wall = wall_with_openings(Plan(facade=2, returns=2, courses=8), Openings(openings=0), stones)
    check_wall(wall)
    assert max(block.shape.vertices[:, 0].max() for block in wall.blocks if not block.fixed) == pytest.approx(0.8)

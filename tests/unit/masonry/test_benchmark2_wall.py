"""The shipped wall of benchmark 2 has the figures that the paper gives and the outline that this project chose."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from orchestrator.app import driver
from orchestrator.limit_analysis.paper.equilibrium import block_weights
from orchestrator.settings import case as cases
from tests.support.paths import PROJECT

TEMPLATE = PROJECT / "templates" / "benchmark2.toml"


@pytest.fixture(scope="module")
def assemblage():
    return driver.check(cases.read(TEMPLATE))


def test_outline_opening_and_weight(assemblage):
    wall = assemblage.wall
    free = [shapely.Polygon(block.polygon) for block in wall.blocks if not block.fixed]
    outline = shapely.box(0, 0, 1.4, 2.8) - shapely.box(0.475, 1.05, 0.925, 1.75)
    assert shapely.union_all(free).symmetric_difference(outline).area < 1e-9
    assert (wall.thickness, wall.friction) == (0.3, 0.75)
    moving = [not block.fixed for block in wall.blocks]
    assert block_weights(wall)[moving].sum() == pytest.approx(19.4e3 * 0.3 * (1.4 * 2.8 - 0.45 * 0.7))


def test_stones_are_of_the_paper_s_sizes_but_for_lintel_and_closers(assemblage):
    corners = np.array([block.polygon for block in assemblage.wall.blocks if not block.fixed])
    width, height = np.ptp(corners[:, :, 0], axis=1), np.ptp(corners[:, :, 1], axis=1)
    assert height.min() > 0.09 - 0.005
    assert height.max() < 0.13 + 0.005, "stretched by at most a few millimetres to end at the opening"
    assert np.count_nonzero(width > 0.26 + 1e-4) == 1, "the lintel"
    assert np.mean(width < 0.12 - 1e-4) < 0.1, "few closers"


def test_elastic_constants_are_the_paper_s():
    elastic = cases.read(TEMPLATE).elastic
    assert (elastic.elastic_modulus, elastic.poisson_ratio) == (3.5e9, 0.2)

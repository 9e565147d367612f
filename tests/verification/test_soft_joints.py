"""A block on mortar that is soft: what it bears once it leans, in closed form, rigid blocks and finite elements.

The base presses with k per area and has no tension (Winkler). Beyond the middle third the weight W, at a distance e
from the middle, presses on 3 c = 3 (b/2 - e) and turns the base by 2 W / (9 k t c^2). The block of height h that leans
by as much bears

    lambda = 2 e / h - 2 W / (9 k t c^2),    most where c^3 = 2 W h / (9 k t)

A rigid base would bear b / h = 0.25.
"""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator import LoadSettings, analyse, find_joints, loads_on, one_body_per_block, push
from orchestrator.masonry.joints import JointClass, JointSettings
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.settings import ElasticSettings, SteppingSettings
from tests.support.limit_analysis_cases import FLOOR, box

WIDTH, HEIGHT, WEIGHT = 0.5, 2.0, 20e3
STIFF = 3.5e13


def bears(stiffness):
    """Return the largest load multiplier of the block on mortar of this stiffness in N/m3; 1 m thick."""
    pressed = (2.0 * WEIGHT * HEIGHT / (9.0 * stiffness)) ** (1 / 3)
    assert pressed < WIDTH / 3, "the weight leaves the middle third"
    return (WIDTH - 2.0 * pressed) / HEIGHT - 2.0 * WEIGHT / (9.0 * stiffness * pressed**2)


def block_on_mortar(stiffness):
    blocks = (Block(0, np.array(FLOOR), True, 20e3), Block(1, np.array(box(0.0, 0.0, WIDTH, HEIGHT)), False, 20e3))
    mortar = JointClass(normal_stiffness=stiffness, shear_stiffness=0.4 * stiffness)
    return find_joints(Wall("block", blocks, 1.0, 0.7), JointSettings(classes=(mortar,)))


@pytest.mark.parametrize("direction", ["+x", "-x"])
@pytest.mark.parametrize("stiffness", [1e7, 3e7, 1e8, 3e8, 1e9, 1e10])
def test_rigid_blocks_bear_what_they_bear_as_they_lean(stiffness, direction):
    assemblage = block_on_mortar(stiffness)
    load = LoadSettings(direction)
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load), elastic_modulus=STIFF)
    assert analysis.rigid_peak == pytest.approx(bears(stiffness), rel=0.025)


@pytest.mark.parametrize("stiffness", [1e7, 1e8, 1e9, 1e10])
def test_finite_elements_of_the_default_size_too(stiffness):
    """Half a mean stone is 0.5 m here, and the stiffest mortar is pressed over 26 mm when the block bears most."""
    assemblage = block_on_mortar(stiffness)
    analysis = analyse(assemblage, elastic_modulus=STIFF)
    stepping = SteppingSettings(final_displacement=0.2)  # the softest leans by 96 mm at its peak
    elastic = ElasticSettings(elastic_modulus=STIFF)
    pushed = push(assemblage, analysis, one_body_per_block(assemblage), stepping=stepping, elastic=elastic)
    assert pushed.summary.valid
    assert pushed.capacity.peak_multiplier == pytest.approx(bears(stiffness), rel=0.02)

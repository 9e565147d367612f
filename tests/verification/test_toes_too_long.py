"""What toes carry too much on long elements, over the moment of the live load, whatever load that is."""

from __future__ import annotations

import pytest

from orchestrator.app.pushed import push
from orchestrator.limit_analysis import analyse
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.loads.block_loads import LiveLoad
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.masonry.joints import JointClass
from orchestrator.pushover.meshing import MeshSettings
from orchestrator.pushover.settings import SteppingSettings
from tests.support.pushover_chain import assemblage_of, stack

WIDTH, HEIGHT, UNIT_WEIGHT, TOE = 0.4, 0.5, 25e3, 0.1
"""of each of two stones, the upper on the lower, in m and N/m3; of the bed, what crushes under both"""
STRENGTH = 2.0 * UNIT_WEIGHT * HEIGHT / TOE


def pushed(load):
    wall = stack((WIDTH, HEIGHT), (WIDTH, HEIGHT), friction=2.0)
    assemblage = assemblage_of(wall, JointClass(compressive_strength=STRENGTH))
    analysis, stones = analyse(assemblage, loads=loads_on(wall, load)), one_body_per_block(assemblage)
    mesh, stepping = MeshSettings(size=0.2, toe_offset=0.5), SteppingSettings(final_displacement=5e-3)
    return push(assemblage, analysis, stones, load=load, mesh=mesh, stepping=stepping).summary


LOADS = {
    "of weight": LoadSettings(),
    "of both signs": LoadSettings(distribution="per_block", live=(LiveLoad((2,), 1e3), LiveLoad((1,), -800.0))),
    "the other way": LoadSettings(direction="-x", distribution="mass_height"),
}


@pytest.mark.parametrize("load", LOADS)
def test_it_is_a_part_of_the_moment_of_whatever_load_turns_the_stones_about_the_bed(load):
    """At the peak that moment is W b / 2, and the bed bears W at its edge, where a toe has it W / (2 f_c t) from there.
    The moment of loads of both signs was added up without them."""
    assert pushed(LOADS[load]).toe_error == pytest.approx(TOE, rel=0.02)

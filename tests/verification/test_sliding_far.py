"""A block slides off its shelf while the top of the wall stands still: the curve follows what moves.

The block slides at the coefficient of friction, 0.4, until its weight and the live load, at half its height of 0.5 m,
meet the edge of the shelf: 1.0 m - 0.4 x 0.25 m = 0.9 m from where it stood, forty-five times the final displacement of
the top, which stands still. From there on it overturns. The column beside it would need 0.625.
"""

from __future__ import annotations

import pytest
from mpi4py import MPI

from orchestrator import JointSettings, LoadSettings, analyse, find_joints, one_body_per_block, push
from orchestrator.loads import DeadLoad, loads_on
from orchestrator.masonry.patterns import running_bond
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import NewtonSettings, SteppingSettings
from orchestrator.pushover.solve.linear_system import LinearSystem
from tests.support.paths import DATA
from tests.support.pushover_chain import model_of, rectangle

FRICTION, AT_THE_EDGE = 0.4, 0.9


def shelf() -> Wall:
    """A column behind a step, and a block of a quarter of the wall's mass on a shelf beside it."""
    blocks = (
        Block(0, rectangle(-1.0, -0.5, 3.0, 0.5), True, 25e3),
        Block(1, rectangle(1.0, 0.0, 1.0, 0.4), True, 25e3),
        Block(2, rectangle(0.0, 0.0, 1.0, 1.6), False, 25e3),
        Block(3, rectangle(3.0, -0.5, 2.0, 0.5), True, 25e3),
        Block(4, rectangle(3.5, 0.0, 1.0, 0.5), False, 25e3),
    )
    return Wall("shelf", blocks, 0.3, FRICTION)


@pytest.mark.parametrize("mesh_size", [0.5, 0.25])
def test_a_block_slides_off_its_shelf_though_the_top_stands_still(mesh_size):
    """Nodes of its bed leave the shelf one by one, with their forces: friction on the way is 0.4 W x all the same."""
    model = model_of(shelf(), mesh_size=mesh_size, large_displacement=True)
    of_block = model.meshes.body_of_node == 1
    with LinearSystem(model, MPI.COMM_SELF) as system:
        rows = list(Pushover(model, system, NewtonSettings(), SteppingSettings(final_displacement=0.02)).increments())
    driven = [row for row in rows if row.phase == "displacement" and not row.moving]
    gone = [float(row.displacement[: len(of_block)][of_block, 0].mean()) for row in driven]
    on_shelf = [row for row, x in zip(driven, gone, strict=True) if x < AT_THE_EDGE]
    assert [row.load_multiplier for row in on_shelf] == pytest.approx([FRICTION] * len(on_shelf), rel=5e-3)
    assert max(gone[: len(on_shelf)]) == pytest.approx(AT_THE_EDGE, abs=0.02)
    assert len(on_shelf) < 60
    weight = float(model.body_weight[1])
    assert on_shelf[-1].dissipated_energy == pytest.approx(FRICTION * weight * gone[len(on_shelf) - 1], rel=1e-4)
    assert rows[-1].base_shear < 0.8 * rows[-1].largest_base_shear
    assert not rows[-1].moving


@pytest.mark.long
def test_a_course_of_which_each_stone_can_go_alone_slides_off_in_few_increments():
    """Twelve courses under a load by mass and height, of which the last has 11.5 / 72 and bears 0.35 times its weight:
    0.35 x 72 / (12 x 11.5). At every tenth of a millimetre it was asked whether a stone moves alone: 682 increments."""
    wall, load = running_bond(6, 12, 0.6, 0.3, 0.3, 20e3, 0.35), LoadSettings(distribution="mass_height")
    assemblage = find_joints(wall, JointSettings())
    analysis = analyse(assemblage, loads=loads_on(wall, load))
    stepping = SteppingSettings(final_displacement=0.03)
    done = push(assemblage, analysis, one_body_per_block(assemblage), load, stepping=stepping)
    assert not done.complaints
    assert done.capacity.peak_multiplier == pytest.approx(0.35 * 72 / (12 * 11.5), rel=1e-3)
    assert done.summary.steps < 200


@pytest.mark.long
def test_a_stone_that_slides_in_its_pocket_does_not_hold_the_curve_up():
    """At its coefficient of friction, 0.6, after the wall has lost 19 %: increments of the elastic slip, up to 2,000 of
    them, in which nothing else moved. Then the wall takes up load again, up to 0.70."""
    load = LoadSettings("-x", dead=(DeadLoad(level=2.4, line_load=10e3),))
    wall = read_blocks(DATA / "facade_46_stones.json")
    assemblage = find_joints(wall, JointSettings())
    analysis = analyse(assemblage, loads=loads_on(wall, load))
    stepping = SteppingSettings(largest_increments=200)
    done = push(assemblage, analysis, one_body_per_block(assemblage), load, stepping=stepping)
    assert done.summary.stopped_because == "base shear 20 % below its peak"
    assert done.capacity.peak_multiplier == pytest.approx(analysis.rigid_peak, rel=0.03)

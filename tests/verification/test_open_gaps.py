"""Stones that stand beside each other with a gap: no force crosses it before it has closed.

Two towers of two stones each, b wide and h high, overturn one by one at b/h; if they touched, one would lean on the
other. A portal of two piers with a slit between them and a stone across bears what rigid blocks do.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from mpi4py import MPI

from orchestrator import JointSettings, MeshSettings, SteppingSettings, analyse, find_joints, one_body_per_block, push
from orchestrator.loads import LiveLoad, LoadSettings, loads_on
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.path.body_overlap import DisplacedOutlines
from orchestrator.pushover.path.curve_checks import APART
from orchestrator.pushover.path.increment_record import at_rest, of_all_nodes, scattered
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import NewtonSettings
from orchestrator.pushover.solve.linear_system import LinearSystem
from tests.support.pushover_chain import bodies_of, model_of, rectangle

WIDTH, HEIGHT = 0.4, 0.8
FAR = 0.004
"""m: displacement with which the peak is passed and no gap has closed"""


def wall_of(*stones, friction):
    ground = Block(0, rectangle(-0.5, -0.2, 4.0, 0.2), True, 20e3)
    blocks = (ground, *(Block(k, rectangle(*stone), False, 20e3) for k, stone in enumerate(stones, 1)))
    return Wall("gap", blocks, 0.3, friction)


def towers(gap):
    return wall_of(*((x, y, WIDTH, HEIGHT) for x in (0.0, WIDTH + gap) for y in (0.0, HEIGHT)), friction=0.7)


def peaks_of(wall):
    """Push a wall, every stone a body; return its peak and that of rigid blocks."""
    assemblage = find_joints(wall, JointSettings())
    analysis = analyse(assemblage)
    stepping, corners = SteppingSettings(final_displacement=FAR), MeshSettings(toe_offset=0.5)  # as rigid ones turn
    done = push(assemblage, analysis, one_body_per_block(assemblage), mesh=corners, stepping=stepping)
    assert not done.complaints
    return done.capacity.peak_multiplier, analysis.headline.load_multiplier


@pytest.mark.parametrize("gap", [0.005, 0.02, 0.05])
def test_towers_with_a_gap_between_them_overturn_one_by_one(gap):
    peak, rigid = peaks_of(towers(gap))
    assert rigid == pytest.approx(WIDTH / (2 * HEIGHT), rel=1e-6)
    assert peak == pytest.approx(WIDTH / (2 * HEIGHT), rel=5e-3)


@pytest.mark.parametrize("slit", [0.01, 0.02])
def test_a_portal_with_a_slit_between_its_piers(slit):
    pier = 1.0 - slit / 2
    stones = [(0.0, 0.0, pier, 1.5), (1.0 + slit / 2, 0.0, pier, 1.5), (0.0, 1.5, 2.0, 0.5)]
    peak, rigid = peaks_of(wall_of(*stones, friction=0.75))
    assert peak == pytest.approx(rigid, rel=5e-3)


def pressed_gap(model, state):
    """Return the largest gap across which stones of `towers` press each other, over the size of the smaller one."""
    outlines = DisplacedOutlines(bodies_of(towers(0.005)), model.meshes)
    here = (state.displacement, state.fallen, model.pairs, state.normal_force, model.body_weight)
    return outlines.largest_pressed_gap(*here).share


def test_nothing_presses_across_a_gap():
    model = model_of(towers(0.005), mesh_size=0.4, large_displacement=True)
    slave, master = model.pairs
    across = (np.minimum(slave, master) < 2) & np.isin(np.maximum(slave, master), (2, 3))
    assert across.any(), "they are contacts, only not closed ones"
    with LinearSystem(model, MPI.COMM_SELF) as system:
        rows = list(Pushover(model, system, NewtonSettings(), SteppingSettings(final_displacement=FAR)).increments())
    assert rows[-1].phase == "displacement"
    assert pressed_gap(model, rows[-1]) < 1e-6
    assert max(np.abs(row.normal_force[across]).max() for row in rows) == 0.0


def test_the_check_of_a_curve_finds_contacts_that_start_closed_across_a_gap():
    """A start in which every gap is taken for closed, as it once was: the towers lean on each other from afar."""
    gap = 0.005
    model = model_of(towers(gap), mesh_size=0.4, large_displacement=True)
    start = at_rest(model)
    start = replace(start, overlap=scattered(start.overlap, model.rows, model.gap_offset))
    with LinearSystem(model, MPI.COMM_SELF) as system:
        path = Pushover(model, system, NewtonSettings(), SteppingSettings(final_displacement=FAR))
        leans = next(row for row in path.increments(of_all_nodes(model, start)) if pressed_gap(model, row) > APART)
    assert pressed_gap(model, leans) == pytest.approx(gap / np.sqrt(WIDTH * HEIGHT), rel=0.1)


@pytest.mark.parametrize("gap", [0.01, 0.02, 0.04])
@pytest.mark.parametrize("size", [1.0, 0.1])
def test_a_stone_that_closes_a_gap_pushes_the_next_one_along(gap, size):
    """Two stones of 0.6 m x 0.3 m, of which one is pushed: it bears mu W until it meets the other, 2 mu W from then."""
    stones = [(0.0, 0.0, 0.6, 0.3), (0.6 + gap, 0.0, 0.6, 0.3)]
    ground = Block(0, size * rectangle(-0.5, -0.2, 4.0, 0.2), True, 20e3)
    blocks = (ground, *(Block(k, size * rectangle(*stone), False, 20e3) for k, stone in enumerate(stones, 1)))
    assemblage = find_joints(Wall("gap", blocks, 0.3 * size, 0.4), JointSettings())
    weight = 20e3 * 0.6 * 0.3 * 0.3 * size**3
    load = LoadSettings(distribution="per_block", live=(LiveLoad((1,), force=weight),))
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    stepping = SteppingSettings(final_displacement=2.0 * gap * size, final_drop=0.9)
    done = push(assemblage, analysis, one_body_per_block(assemblage), load, stepping=stepping)
    assert not done.complaints
    assert done.curve.base_shear_N.max() == pytest.approx(0.8 * weight, rel=2e-3)

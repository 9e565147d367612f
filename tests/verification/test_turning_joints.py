"""Elements where stones turn about the end of a joint: lengths by a closed form, peaks as of fine elements."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator import MeshSettings, SteppingSettings, one_body_per_block, push
from orchestrator.basis.errors import ConvergenceError
from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.limit_analysis.turning_joints import pressed_at_hinges
from orchestrator.loads import DeadLoad, LiveLoad, LoadSettings, loads_on
from orchestrator.masonry.joints import JointClass, JointSettings, find_joints
from orchestrator.masonry.patterns import Arch, arch_on_piers
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import Block, Wall
from tests.support.limit_analysis_cases import assemblage_of, box
from tests.support.paths import PROJECT

WIDTH, HEIGHT, DEEP, TOP, MODULUS = 0.5, 2.0, 0.5, 200e3, 2e9
ALONE = LimitAnalysisSettings(search_blocks=1, sequence_blocks=1)


def column(size=1.0, direction="+x"):
    """A stone without weight worth the name under a floor, and its limit analysis; lengths and modulus times `size`."""
    blocks = (
        Block(0, size * np.array(box(-1.0, -0.2, 3.0, 0.2)), True, 1.0),
        Block(1, size * np.array(box(0.0, 0.0, WIDTH, HEIGHT)), False, 1.0),
    )
    assemblage = find_joints(Wall("column", blocks, DEEP, 0.9), JointSettings())
    floor = DeadLoad((1,), force=TOP * size**2, at=(0.5 * WIDTH * size, HEIGHT * size), inertia=True)
    load = LoadSettings(direction, dead=(floor,))
    return assemblage, analyse(assemblage, ALONE, loads_on(assemblage.wall, load), MODULUS * size)


@pytest.mark.parametrize(("direction", "right"), [("+x", True), ("-x", False)])
def test_a_column_is_pressed_over_the_length_of_its_closed_form(direction, right):
    """It bears N (b / 2 - h r - x / 3) at a turn r, x = 3 N / (pi E t r): most where x / 3 is h r."""
    assemblage, found = column(direction=direction)
    expected = 3.0 * np.sqrt(TOP * HEIGHT / (np.pi * MODULUS * DEEP))
    pressed = pressed_at_hinges(assemblage, found)
    ends = (assemblage.joints.start, assemblage.joints.end)
    at = [end[0, 0] for end, length in zip(ends, pressed[0], strict=True) if length]
    assert at == [WIDTH if right else 0.0]
    assert pressed.max() == pytest.approx(expected, rel=0.25), "the curve is known at some displacements"
    turn = expected / (3.0 * HEIGHT)
    assert found.pressed_peak == pytest.approx(0.5 * WIDTH / HEIGHT - 2.0 * turn, rel=0.01)


@pytest.mark.parametrize("inclination", [-90.0, -80.0])
def test_a_stiff_stone_that_a_weight_beyond_its_support_overturns_loses_nothing_at_its_edge(inclination):
    """A stone of 20 kN with its centroid 0.25 m within the edge, and 1 kN on it 0.5 m beyond the edge, 1.1 m above."""
    blocks = (
        Block(0, np.array(box(-0.5, -0.2, 1.0, 0.2)), True, 20e3),
        Block(1, np.array(box(-0.75, 0.0, 2.0, 1.0)), False, 20e3),
        Block(2, np.array(box(0.9, 1.0, 0.2, 0.2)), False, 1.0),
    )
    assemblage, way = find_joints(Wall("seesaw", blocks, 0.5, 0.9), JointSettings()), np.radians(inclination)
    load = LoadSettings(inclination=way, distribution="per_block", live=(LiveLoad((2,), force=1e3),))
    expected = 20.0 * 0.25 / (1.1 * np.cos(way) - 0.5 * np.sin(way))
    found = analyse(assemblage, ALONE, loads_on(assemblage.wall, load), 1e14)
    assert found.headline.load_multiplier == pytest.approx(expected, rel=1e-4)
    assert found.pressed_peak == pytest.approx(expected, rel=0.02)


def test_on_mortar_with_a_stiffness_the_curve_has_what_gives_way():
    assemblage, _ = column()
    mortar = find_joints(assemblage.wall, JointSettings(classes=(JointClass(normal_stiffness=2e9),)))
    floor = DeadLoad((1,), force=TOP, at=(0.5 * WIDTH, HEIGHT), inertia=True)
    found = analyse(mortar, ALONE, loads_on(mortar.wall, LoadSettings(dead=(floor,))), MODULUS)
    assert not pressed_at_hinges(mortar, found).any()
    assert found.pressed_peak == pytest.approx(found.rigid_peak)


def test_lengths_grow_with_the_wall():
    (one, found), (tenth, again) = column(), column(0.1)
    assert pressed_at_hinges(tenth, again) == pytest.approx(0.1 * pressed_at_hinges(one, found), rel=0.05, abs=1e-9)


def test_a_facade_that_snaps_at_the_peak_of_its_rigid_blocks_has_an_estimate_too():
    """Elements of half a mean stone have 0.3636, of 60 mm 0.3627; rigid blocks 0.3747, and nothing was said."""
    assemblage = find_joints(read_blocks(PROJECT / "tests/data/facade_82_stones.json"), JointSettings())
    assert analyse(assemblage).pressed_peak == pytest.approx(0.3627, rel=0.01)


def test_what_is_left_of_an_arch_is_what_it_bears_as_it_moves_past_where_rigid_blocks_snap():
    """Rigid blocks snap after 0.4 mm, and 0.440 was left there; micro-FE bears 0.4515 at 3 mm with `toe_offset` 0.0003,
    and 0.4537 by default."""
    assemblage = find_joints(read_blocks(PROJECT / "tests/data/semicircular_arch_50_stones.json"), JointSettings())
    found = analyse(assemblage, loads=loads_on(assemblage.wall, LoadSettings("-x")))
    assert found.pressed_peak == pytest.approx(0.4515, rel=0.01)


def test_an_arch_bears_what_it_bears_in_fine_elements():
    """0.4545 with elements of half a mean stone, 0.4454 of an eighth (run 50 of docs/studies/mesh_size.md)."""
    assemblage = find_joints(read_blocks(PROJECT / "tests/data/segmental_arch_49_stones.json"), JointSettings())
    found, stones = analyse(assemblage, ALONE), one_body_per_block(assemblage)
    mesh, stepping = MeshSettings(), SteppingSettings(final_displacement=0.02)
    done = push(assemblage, found, stones, mesh=mesh, stepping=stepping)
    assert done.summary.valid
    assert done.capacity.peak_multiplier == pytest.approx(0.4454, rel=5e-3)


def drums():
    """A column of eight drums that tapers, 3.45 m high."""
    widths, heights = (0.8, 0.66, 0.6, 0.58, 0.56, 0.54, 0.52, 0.9), (0.25, *[0.5] * 6, 0.2)
    beds = np.cumsum([0.0, *heights])
    outlines = [box(-0.5 * w, y, w, h) for w, y, h in zip(widths, beds[:-1], heights, strict=True)]
    return assemblage_of([box(-0.6, -0.2, 1.2, 0.2), *outlines], friction=0.7, thickness=0.6, unit_weight=25e3)


def ring():
    """A semicircular arch of twelve voussoirs on the ground."""
    return find_joints(arch_on_piers(Arch(12, 1.1, 0.2, friction=0.7, thickness=0.3)), JointSettings())


def portal():
    """Two uprights of 0.4 m x 1.6 m under a lintel."""
    stones = [box(0.0, 0.0, 0.4, 1.6), box(1.8, 0.0, 0.4, 1.6), box(0.0, 1.6, 2.2, 0.4)]
    return assemblage_of([box(-0.5, -0.2, 3.2, 0.2), *stones], friction=0.6, thickness=0.4)


def colonnade(count=9):
    """Uprights of 0.4 m x 1.6 m under lintels that do not meet."""
    left = [2.0 * k for k in range(count)]
    uprights = [box(x, 0.0, 0.4, 1.6) for x in left]
    lintels = [box(x + 0.21, 1.6, 1.98, 0.3) for x in left[:-1]]
    ground = box(-0.5, -0.2, left[-1] + 1.4, 0.2)
    return assemblage_of([ground, *uprights, *lintels], friction=0.6, thickness=0.4)


@pytest.mark.parametrize(("wall", "pressed"), [(drums, 0.025), (ring, 0.025), (portal, 0.02), (colonnade, 0.02)])
def test_few_stones_bear_by_default_what_edges_leave(wall, pressed):
    """Stones that turn about 0.3 to 2 % of a joint lose 1 to 2 % of their peak, in elements as by the formula."""
    assemblage = wall()
    found = analyse(assemblage)
    lengths = pressed_at_hinges(assemblage, found) / assemblage.joints.length[:, None]
    assert 0.0 < lengths.max() < pressed
    assert found.pressed_peak < 0.99 * found.rigid_peak
    done = push(assemblage, found, one_body_per_block(assemblage))
    assert done.summary.valid
    assert done.capacity.peak_multiplier == pytest.approx(found.pressed_peak, rel=5e-3)


def test_joints_that_are_alike_have_short_elements_all_or_none():
    """Nineteen beds take 0.03 % each, 0.6 % together, and no other joint more."""
    assemblage = colonnade(21)
    lengths = pressed_at_hinges(assemblage, analyse(assemblage)).max(axis=1)
    beds = lengths[assemblage.joints.i == 0]
    assert len(beds) == 21
    assert beds[1:-1] == pytest.approx(beds[1], rel=1e-4)
    assert beds[1] > 0.0


@pytest.mark.parametrize(("depth", "stands"), [(0.54, False), (0.56, True)])
def test_an_arch_of_which_edges_leave_nothing_falls_under_its_weight(depth, stands):
    """Rigid, a semicircular arch stands from a depth of 0.1075 of its radius on (Milankovitch 1907): here 0.108."""
    assemblage = find_joints(arch_on_piers(Arch(24, 5.0, depth, friction=0.8)), JointSettings())
    found, stones = analyse(assemblage), one_body_per_block(assemblage)
    assert found.headline.load_multiplier > 0.0
    assert (found.pressed_peak > 0.0) is stands
    if stands:
        assert push(assemblage, found, stones).capacity.peak_multiplier > 0.0
    else:
        assert found.pressed_peak == 0.0
        with pytest.raises(ConvergenceError, match="does not stand under its dead load"):
            push(assemblage, found, stones)

"""A wall at another size has the same joints, multipliers and curve: there is no absolute length in the mechanics.

Lengths, modulus and sizes of elements are scaled by s. Gravity stays, so stresses scale as lengths do, and
strains, rotations and multipliers are the same: strengths of joints scale as stresses do, their stiffness (N/m3) stays.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from mpi4py import MPI

from orchestrator.limit_analysis.analysis import analyse
from orchestrator.limit_analysis.paper.sequence import LimitAnalysisSettings
from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.masonry.block_properties import ELASTIC_MODULUS
from orchestrator.masonry.joints import JointClass, JointSettings, find_joints
from orchestrator.masonry.patterns import Rubble, rubble, running_bond
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies
from orchestrator.pushover.model import build_model
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings, SteppingSettings
from orchestrator.pushover.solve.linear_system import LinearSystem
from tests.support.paths import DATA
from tests.support.pushover_chain import model_of, run
from tests.support.walls import between

WALLS = {"bond": running_bond(2, 4), "rubble": rubble(Rubble(0.8, 0.8, stone=0.35, seed=1))}


def stepped(scale, step):
    """Courses of 0.4 x 0.3 m times the scale, each `step` (m, times it) less than half a stone from the one below: its
    last stone stands on the one before the last by so little."""
    blocks = [Block(0, scale * between(-0.5, -0.2, 3.0, 0.0), True, 20e3)]
    for course in range(5):
        left = 0.2 * course - step * (course % 2)
        outlines = [between(left + 0.4 * k, 0.0, left + 0.4 * k + 0.4, 0.3) for k in range(5 - course)]
        blocks += [
            Block(len(blocks) + k, scale * (one + [0.0, 0.3 * course]), False, 20e3) for k, one in enumerate(outlines)
        ]
    return find_joints(Wall("stepped", tuple(blocks), scale * 0.3, 0.6), JointSettings())


@pytest.mark.parametrize("step", [0.192, 0.1985, 0.15])
def test_a_wall_at_a_tenth_and_at_ten_times_its_size_has_the_same_joints_and_multipliers(step):
    """Bed joints of 8, 1.5 and 50 mm beside others of 0.39 m, the modulus scaled along: to 1e-6, as promised."""
    whole = stepped(1.0, step)
    expected = analyse(whole)
    for scale in (0.1, 10.0):
        scaled = stepped(scale, step)
        assert scaled.joints.length == pytest.approx(scale * whole.joints.length, rel=1e-9)
        found = analyse(scaled, elastic_modulus=scale * ELASTIC_MODULUS)
        assert found.associative.load_multiplier == pytest.approx(expected.associative.load_multiplier, rel=1e-6)
        assert found.headline.load_multiplier == pytest.approx(expected.headline.load_multiplier, rel=1e-6)


def battered(scale):
    """A pier of eight courses of 0.3 m times the scale, 1.2 m at its foot, 0.5 m at its top, one face battered."""
    outlines = [between(-0.3, -0.2, 1.5, 0.0)]
    for course in range(8):
        low, high, cut = 2.4 * course / 8, 2.4 * (course + 1) / 8, 0.35 if course % 2 else 0.22
        right = [(1.2 - (1.2 - 0.5) * y / 2.4, y) for y in (low, high)]
        if course < 7:
            outlines.append(between(0.0, low, cut, high))
        left = cut if course < 7 else 0.0
        outlines.append(np.array([(left, low), *right, (left, high)]))
    blocks = tuple(Block(k, scale * outline, k == 0, 20e3) for k, outline in enumerate(outlines))
    return find_joints(Wall("battered", blocks, scale * 0.4, 0.6), JointSettings())


@pytest.mark.parametrize("scale", [1.0, 0.1, 10.242])
def test_the_papers_sequence_confirms_a_wall_that_slides_at_any_size(scale):
    """At its friction, 0.6. Rounding stopped the program that confirms it short of 1e-12 at a tenth of the size."""
    found = analyse(battered(scale), LimitAnalysisSettings(path_blocks=0))
    assert found.sequence.load_multiplier == pytest.approx(0.6, rel=1e-6)


MORTAR = JointClass(normal_stiffness=5e9, shear_stiffness=2e9, compressive_strength=1.5e5)


def curve(wall, scale, mortar=None):
    """Return load multipliers and displacements over the scale, every stone pushed to 4 mm x scale."""
    blocks = tuple(replace(block, polygon=scale * block.polygon) for block in wall.blocks)
    scaled = mortar and replace(mortar, compressive_strength=scale * mortar.compressive_strength)
    classes = (scaled,) if scaled else ()
    joints = JointSettings(classes=classes)
    assemblage = find_joints(replace(wall, blocks=blocks, thickness=scale * wall.thickness), joints)
    whole = find_joints(wall, JointSettings())
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    meshes = mesh_bodies(make_bodies(whole, one_body_per_block(whole)), MeshSettings(0.2), None)
    meshes = replace(meshes, nodes=scale * meshes.nodes)  # gmsh rounds
    elastic = ElasticSettings()
    elastic = replace(elastic, elastic_modulus=scale * elastic.elastic_modulus)
    stepping = SteppingSettings(final_displacement=4e-3 * scale)
    model = build_model(bodies, meshes, elastic, ContactSettings(), True)
    with LinearSystem(model, MPI.COMM_SELF) as system:
        path = list(Pushover(model, system, NewtonSettings(), stepping).increments())
    return np.array([(i.load_multiplier, i.control_displacement / scale) for i in path])


@pytest.mark.parametrize("scale", [1 / 16, 16.0])
@pytest.mark.parametrize("name", WALLS)
def test_a_scaled_wall_has_the_same_curve(name, scale):
    original, scaled = curve(WALLS[name], 1.0), curve(WALLS[name], scale)
    assert np.array_equal(scaled, original)  # powers of two: not a single bit may differ


def test_a_tenth_of_wall_4_has_the_same_peak_with_every_setting_left_at_its_default():
    peaks = []
    for scale in (1.0, 0.1):
        wall = read_blocks(DATA / "ferris_tinloi_wall4.json")
        blocks = tuple(replace(block, polygon=scale * block.polygon) for block in wall.blocks)
        wall = replace(wall, blocks=blocks, thickness=scale * wall.thickness)
        elastic = ElasticSettings(elastic_modulus=scale * ElasticSettings().elastic_modulus)
        model = model_of(wall, large_displacement=True, elastic=elastic)
        peaks.append(run(model).peak)
    assert peaks[1] == pytest.approx(peaks[0], rel=5e-3)


@pytest.mark.parametrize("scale", [1 / 16, 16.0])
def test_a_scaled_wall_with_mortar_that_crushes_has_the_same_curve(scale):
    original, scaled = curve(WALLS["bond"], 1.0, MORTAR), curve(WALLS["bond"], scale, MORTAR)
    assert np.array_equal(scaled, original)
    assert not np.array_equal(original, curve(WALLS["bond"], 1.0)), "mortar must matter"


def test_a_tenth_of_a_wall_with_mortar_has_the_same_curve():
    """No power of two: rounding may differ, nothing else."""
    original, scaled = curve(WALLS["bond"], 1.0, MORTAR), curve(WALLS["bond"], 0.1, MORTAR)
    assert original[:, 0].max() == pytest.approx(scaled[:, 0].max(), rel=1e-3)
    together = np.linspace(0.0, 3.9e-3, 40)
    found, expected = (np.interp(together, path[:, 1], path[:, 0]) for path in (scaled, original))
    assert found == pytest.approx(expected, rel=5e-3, abs=1e-3)

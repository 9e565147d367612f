"""Pictures of a study: of walls that carry more than their weight, of elements with nodes between corners."""

from __future__ import annotations

import numpy as np

from orchestrator import ElasticSettings, SteppingSettings, analyse, one_body_per_block, push
from orchestrator.loads import DeadLoad, LoadSettings, loads_on
from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.present import plots
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies
from orchestrator.pushover.path.curve import pushover_increments
from tests.support.walls import of_file

SHORT = SteppingSettings(final_displacement=2e-3)


def test_the_curves_are_cut_above_what_the_wall_bears():
    """A tower of 16 kN under a mass of 60 kN."""
    assemblage = of_file("tower_5_blocks")
    top = max(assemblage.wall.blocks, key=lambda block: block.polygon[:, 1].max())
    load = LoadSettings(dead=(DeadLoad(blocks=(top.id,), force=60e3, inertia=True),))
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    pushed = push(assemblage, analysis, one_body_per_block(assemblage), load, stepping=SHORT)
    axes = plots.study_curves([(5, pushed.curve)], None, analysis, "tower").axes[0]
    assert axes.get_ylim()[1] > 1e-3 * pushed.capacity.peak_base_shear


def test_bodies_with_nodes_between_corners_are_drawn():
    assemblage = of_file("tower_5_blocks")
    partition = one_body_per_block(assemblage)
    bodies = make_bodies(assemblage, partition)
    meshes = mesh_bodies(bodies, MeshSettings(), None)
    *_, last = pushover_increments(bodies, meshes, ElasticSettings(element_order=2), stepping=SHORT)
    assert len(last.displacement) > len(meshes.nodes)
    panel = plots.deformed_panel(assemblage, partition, bodies, meshes, last)
    assert np.isfinite(np.vstack([path.vertices for path in panel.outlines])).all()

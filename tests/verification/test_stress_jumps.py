"""How much too stiff elements are, by their stresses: against bending that is known, and in a verification."""

from __future__ import annotations

import json

import numpy as np
import pytest

from orchestrator.app.cli import main
from orchestrator.pushover.solids.elastic_constants import ElasticConstants
from orchestrator.pushover.stress import element_stress
from orchestrator.pushover.stress_jumps import excess_stiffness
from tests.verification.test_quadratic_elements import HEIGHT, THICKNESS, bar

MODULUS, RATIO = 1e9, 0.2
CONSTANTS = ElasticConstants(np.array([MODULUS]), np.array([RATIO]))


def displaced(meshes, field):
    x, y, z = meshes.nodes.T
    return np.column_stack(field(x, y - HEIGHT / 2, z - THICKNESS / 2))


def bent(x, y, z):
    """Pure bending to a curvature of 1/m times 1e-4 (Saint-Venant)."""
    return 1e-4 * x * y, -0.5e-4 * (x**2 + RATIO * (y**2 - z**2)), -1e-4 * RATIO * y * z


@pytest.mark.parametrize("size", [0.1, 0.05, 0.025])
def test_a_bent_bar_is_too_stiff_by_about_what_its_stresses_are_wrong_by(size):
    """Its true stress is E times curvature times distance from the axis along it, and nothing else: the energy of the
    difference, by the means of squares in each element, over that of the bar."""
    meshes = bar(size)
    stress = element_stress(meshes, CONSTANTS, displaced(meshes, bent), large_displacement=False)
    corners = meshes.nodes[meshes.tetrahedra]
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0
    along = 1e-4 * MODULUS * (corners[:, :, 1] - HEIGHT / 2)
    squares = ((along**2).sum(axis=1) + along.sum(axis=1) ** 2) / 20.0
    other, trace = stress[:, 0, 0], np.trace(stress, axis1=1, axis2=2)
    of_elements = (1.0 + RATIO) * (stress**2).sum(axis=(1, 2)) - RATIO * trace**2
    wrong = volume @ (squares - 2.0 * along.mean(axis=1) * ((1.0 + RATIO) * other - RATIO * trace) + of_elements)
    assert excess_stiffness(meshes, CONSTANTS, stress) == pytest.approx(wrong / (volume @ of_elements), rel=0.4)


def test_uniform_stress_is_right():
    meshes = bar(0.1)
    stretched = displaced(meshes, lambda x, y, z: (1e-4 * x, 0.0 * y, 0.0 * z))
    stress = element_stress(meshes, CONSTANTS, stretched, large_displacement=False)
    assert excess_stiffness(meshes, CONSTANTS, stress) < 1e-20


def test_the_demand_on_a_pier_of_large_stones_is_said_to_depend_on_its_elements(tmp_path):
    """Three stones of 0.6 x 0.8 m: with elements of half a stone it is a third stiffer than with 50 mm."""
    ground = {"id": 0, "polygon": [[-2, -1], [3, -1], [3, 0], [-2, 0]], "fixed": True}
    stones = [
        {"id": k + 1, "polygon": [[0, 0.8 * k], [0.6, 0.8 * k], [0.6, 0.8 * (k + 1)], [0, 0.8 * (k + 1)]]}
        for k in range(3)
    ]
    record = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.3, "friction": 0.6, "unit_weight": 20}
    (tmp_path / "pier.json").write_text(json.dumps(record | {"name": "pier", "blocks": [ground, *stones]}))
    seismic = "[seismic]\npeak_ground_acceleration = '0.15 g'\nground = 'B'\n"
    (tmp_path / "case.toml").write_text(f"[wall]\nblocks = 'pier.json'\n{seismic}")
    found = {}
    for size in ("default", "50 mm"):
        more = [] if size == "default" else ["--set", f"mesh.size={size}"]
        asked = ["run", str(tmp_path / "case.toml"), "--model", "micro", "--quiet", "--output", str(tmp_path / size)]
        assert main([*asked, *more]) == 0
        found[size] = json.loads((tmp_path / size / "summary.json").read_text())["seismic"]
    coarse, fine = (found[size]["systems"][0] for size in ("default", "50 mm"))
    assert coarse["stiffness_N_per_m"] > 1.2 * fine["stiffness_N_per_m"]
    assert coarse["excess_stiffness_share"] > 4.0 * fine["excess_stiffness_share"]
    said = [any("elements make stones" in text for text in one["checks"][0]["remarks"]) for one in found.values()]
    assert said == [True, False]

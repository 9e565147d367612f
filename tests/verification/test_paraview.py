"""The files of a run open in VTK, which ParaView is made of, and draw a picture."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from orchestrator.app.cli import main

pytestmark = pytest.mark.usefixtures("without_pictures")

PROGRAM = """
import sys
import numpy as np
import pyvista

folder, picture, found = sys.argv[1:]
values = {}
for name in ("wall", "contacts"):
    reader = pyvista.get_reader(f"{folder}/{name}.xdmf")
    reader.set_active_time_point(reader.number_time_points - 1)
    grid = reader.read()
    grid = grid[0] if isinstance(grid, pyvista.MultiBlock) else grid
    values[f"{name}_times"] = reader.time_values
    values[f"{name}_size"] = [grid.n_points, grid.n_cells]
    values |= {f"{name}_{key}": grid.point_data[key] for key in grid.point_data}
    values |= {f"{name}_{key}": grid.cell_data[key] for key in grid.cell_data}
    if name == "contacts":
        values["contacts_moved"] = grid.warp_by_vector("displacement_m", factor=1.0).points - grid.points
    if name == "wall":
        values["size"] = [grid.n_points, grid.n_cells]
        warped = grid.warp_by_vector("displacement_m", factor=1.0)
mesh = pyvista.read(f"{folder}/mesh.vtu")
values["mesh_size"] = [mesh.n_points, mesh.n_cells]
plotter = pyvista.Plotter(off_screen=True, window_size=(400, 400))
plotter.add_mesh(warped, scalars="von_mises_Pa", show_edges=True)
plotter.view_xy()
plotter.screenshot(picture)
np.savez(found, **values)
"""
"""run apart: VTK brings an HDF5 library of its own"""


@pytest.mark.parametrize("order", [1, 2])
def test_files_open_and_draw(tmp_path, monkeypatch, order):
    """With 10-node tetrahedra the stored displacements are longer than the nodes: edges follow."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert main(["new", "two"]) == 0
    given = ["--set", f"elastic.element_order={order}", "--set", "stepping.final_displacement=1mm"]
    assert main(["run", "two.toml", "--output", "out", "--model", "micro", "--quiet", *given]) in (0, 3)
    folder = tmp_path / "out" / "micro"
    picture, found = tmp_path / "wall.png", tmp_path / "found.npz"
    subprocess.run([sys.executable, "-c", PROGRAM, str(folder), str(picture), str(found)], check=True, timeout=120)
    values = np.load(found)
    assert values["size"].tolist() == values["mesh_size"].tolist()
    assert values["wall_displacement_m"].shape == (values["size"][0], 3)
    assert 0.5e-3 < np.abs(values["wall_displacement_m"]).max() < 10e-3
    assert len(values["wall_times"]) == len(values["contacts_times"]) > 3
    assert set(values["wall_body"]) == set(range(values["wall_body"].max() + 1))
    for name in ("von_mises_Pa", "sigma_1_Pa", "sigma_2_Pa", "sigma_3_Pa"):
        assert values[f"wall_{name}"].shape == (values["size"][1],)
    assert np.all(values["wall_sigma_1_Pa"] >= values["wall_sigma_3_Pa"])
    assert values["wall_von_mises_Pa"].max() > 1e3
    tensor = values["wall_stress_Pa"].reshape(-1, 3, 3)
    np.testing.assert_allclose(tensor, tensor.transpose(0, 2, 1), atol=1e-3 * np.abs(tensor).max())
    principal = np.linalg.eigvalsh(tensor)[:, ::-1].T
    for found_here, name in zip(principal, ("sigma_1_Pa", "sigma_2_Pa", "sigma_3_Pa"), strict=True):
        np.testing.assert_allclose(found_here, values[f"wall_{name}"], atol=1e-4 * np.abs(tensor).max())
    last = np.genfromtxt(folder / "curve.csv", delimiter=",", names=True, comments="#")[-1]
    for name in ("load_multiplier", "base_shear_N", "control_displacement_m"):
        assert np.all(values[f"wall_{name}"] == np.float32(last[name])), name
    assert set(values["wall_material"]) == {0}
    assert "unnamed" in (folder / "wall.xdmf").read_text()
    assert np.abs(values["contacts_moved"]).max() > 0.5e-3
    normal, tangential = values["contacts_normal_force_N"], values["contacts_tangential_force_N"]
    np.testing.assert_allclose(
        np.linalg.norm(values["contacts_force_N"], axis=1), np.hypot(normal, tangential), rtol=1e-4
    )
    assert np.all(tangential <= 0.6 * normal + 1e-3)  # the friction of the two blocks
    assert tangential.max() > 1.0
    for name in ("pressure_Pa", "normal_force_N", "gap_m", "slip_m", "status", "damage"):
        assert values[f"contacts_{name}"].shape == (values["contacts_size"][0],)
    assert np.nanmax(values["contacts_pressure_Pa"]) > 1e3
    drawn = _picture(picture)
    assert drawn.shape[:2] == (400, 400)
    assert len(np.unique(drawn.reshape(-1, drawn.shape[2]), axis=0)) > 50


def _picture(path):
    from PIL import Image

    return np.array(Image.open(path))

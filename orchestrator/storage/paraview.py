"""ParaView: wall.xdmf (bodies) and contacts.xdmf (contact points), time = increment number.

Both refer to states.h5 for what changes, to wall.h5 for the mesh, and to derived.h5 for what follows from the states:
stress in the elements, pressure, force and displacement of the contacts, in single precision. Nothing is stored twice,
and the figures of the curve, which every element has alike, take no room. (As attributes of the grid meshio would not
read them. Its time series writer copies everything, and writes its .h5 into the current directory.)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.atomic_files import replacing, write_bytes
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.pushover.increments import Increment
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.pushover.stress import (
    barycentric_slopes,
    contact_forces,
    element_stress,
    in_fixed_axes,
    slave_areas,
    von_mises,
)
from orchestrator.storage.hdf5 import hdf5_file
from orchestrator.storage.stored_increments import StateStore

if TYPE_CHECKING:
    import h5py

    from orchestrator.pushover.model import ContactModel

NODE_FIELDS = (("displacement_m", "displacement"),)
CONTACT_FIELDS = (
    ("normal_force_N", "normal_force"), ("gap_m", "gap"), ("slip_m", "slip"),
    ("status", "status"), ("damage", "damage"),
)  # fmt: skip
"""name in ParaView, name in states.h5; status: 0 open, 1 stick, 2 slip; damage: of bonded joints, 0 to 1"""
CURVE_FIELDS = (
    ("load_multiplier", "load_multiplier"), ("base_shear_N", "base_shear"),
    ("control_displacement_m", "control_displacement"),
)  # fmt: skip
"""name in ParaView, field of an increment: the same for every element"""
ATTRIBUTE_TYPES = {1: "Scalar", 3: "Vector", 9: "Tensor"}
NUMBER_TYPES = {"f": "Float", "i": "Int", "u": "UInt"}


@dataclass(frozen=True, eq=False, slots=True)
class Derived:
    """What follows from an increment, by the name it has in ParaView: of elements (t, ...) and of contacts (c, ...)."""

    elements: Mapping[str, FloatArray]
    contacts: Mapping[str, FloatArray]


def stress_and_pressure(model: ContactModel, bodies: Bodies) -> Callable[[Increment], Derived]:
    """Return the function from an increment of `model` to its stresses and pressures in Pa, contact forces in N.

    Pressure is NaN where a corner touches: that is no area. The tensor is in the wall's axes, row by row.
    """
    area = slave_areas(model, bodies)
    slopes = barycentric_slopes(model.meshes.nodes[model.meshes.tetrahedra])

    def derive(increment: Increment) -> Derived:
        large = model.tracking is not None
        stress = element_stress(model.meshes, model.elastic, increment.displacement, large, slopes)
        names, principal = ("sigma_1_Pa", "sigma_2_Pa", "sigma_3_Pa"), np.linalg.eigvalsh(stress)
        elements = {"von_mises_Pa": von_mises(stress)}
        elements |= dict(zip(names, principal.T[::-1], strict=True))  # as usual, sigma_1 is the largest
        fixed = in_fixed_axes(model.meshes, stress, increment.displacement) if large else stress
        elements["stress_Pa"] = fixed.reshape(-1, 9)
        force = contact_forces(model, increment)
        tangential = np.sqrt(np.maximum(np.sum(force**2, axis=1) - increment.normal_force**2, 0.0))
        node = model.possible.slave_node
        moved = np.where((node >= 0)[:, None], increment.displacement[np.maximum(node, 0)], 0.0)
        pressure = np.divide(increment.normal_force, area, out=np.full(len(area), np.nan), where=area > 0.0)
        contacts = {
            "pressure_Pa": pressure,
            "tangential_force_N": tangential,
            "force_N": force,
            "displacement_m": moved,
        }
        return Derived(elements, contacts)

    return derive


def write_paraview(
    store: StateStore,
    meshes: BodyMeshes,
    contact_points: FloatArray | None = None,
    derive: Callable[[Increment], Derived] | None = None,
    materials: Sequence[str] = (),
    last: int | None = None,
) -> list[Path]:
    """Write the time series of a model's folder and return the .xdmf files; gathers states.h5 first.

    contact_points (c, 2) or (c, 3): positions of the contacts in m, in the order of Increment.gap. derive: see
    `stress_and_pressure`. materials: of each body, shown as numbers that wall.xdmf explains. last: number of the
    increment with which the curve ends; None: all are shown.
    """
    folder, wall, contacts = store.folder, store.folder / "wall.xdmf", store.folder / "contacts.xdmf"
    states = store.assemble()
    for stale in (wall, contacts):
        stale.unlink(missing_ok=True)
    content = BytesIO()
    with hdf5_file(content, "w") as file:
        _write_mesh(file, meshes, materials)
        if contact_points is not None:
            _write_points(file, contact_points)
    write_bytes(folder / "wall.h5", content.getvalue())
    with replacing(folder / "derived.h5") as temporary, hdf5_file(temporary, "w") as file:
        for increment in store.increments():
            if last is not None and increment.number > last:
                break
            group = file.create_group(f"{increment.number:06d}")
            _write_curve_fields(group, increment, len(meshes.tetrahedra))
            if derive is not None:
                _write_derived(group, derive(increment))
    written = folder / "wall.h5", states, folder / "derived.h5"
    with hdf5_file(written[0]) as mesh, hdf5_file(written[1]) as steps, hdf5_file(written[2]) as derived:
        constant = [_item(mesh[name], "Cell", name) for name in ("body", "material")]
        series = _series(mesh["bodies"], "Tetrahedron", steps, NODE_FIELDS, constant, derived, "elements", materials)
        write_bytes(wall, series)
        if contact_points is None:
            return [wall]
        series = _series(mesh["contacts"], "Polyvertex", steps, CONTACT_FIELDS, [], derived, "contacts")
        write_bytes(contacts, series)
    return [wall, contacts]


def _write_curve_fields(group: h5py.Group, increment: Increment, elements: int) -> None:
    """Write what the curve has of an increment, the same value in every element."""
    for shown, name in CURVE_FIELDS:
        value = getattr(increment, name)
        group.create_dataset(f"elements/{shown}", shape=(elements,), dtype=np.float32, fillvalue=value)


def _write_derived(group: h5py.Group, derived: Derived) -> None:
    for kind, values in (("elements", derived.elements), ("contacts", derived.contacts)):
        for name, value in values.items():
            group.create_dataset(f"{kind}/{name}", data=value, dtype=np.float32)


def _write_mesh(file: h5py.File, meshes: BodyMeshes, materials: Sequence[str]) -> None:
    file["bodies/points"] = meshes.nodes
    file["bodies/cells"] = meshes.tetrahedra
    file["body"] = meshes.body_of_tetrahedron
    number = np.unique(materials, return_inverse=True)[1] if materials else np.zeros(len(meshes.unit_weight), np.int64)
    file["material"] = number[meshes.body_of_tetrahedron]


def _write_points(file: h5py.File, points: FloatArray) -> None:
    """Write contact points as one vertex cell each; a missing z is 0."""
    file["contacts/points"] = np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])
    file["contacts/cells"] = np.arange(len(points))[:, None]


def _series(
    mesh: h5py.Group,
    cell_type: str,
    steps: h5py.File,
    names: Sequence[tuple[str, str]],
    constant: Sequence[ElementTree.Element],
    derived: h5py.File,
    kind: str,
    materials: Sequence[str] = (),
) -> bytes:
    """Return the XDMF text of a time series: one grid per increment on the same mesh."""
    root = ElementTree.Element("Xdmf", Version="3.0")
    domain = ElementTree.SubElement(root, "Domain")
    for number, material in enumerate(sorted(set(materials))):
        ElementTree.SubElement(domain, "Information", Name=f"material {number}", Value=material)
    series = ElementTree.SubElement(domain, "Grid", Name="wall", GridType="Collection", CollectionType="Temporal")
    increments = sorted(derived, key=int)
    alike = _attributes(mesh, steps[increments[0]], names, derived.get(f"{increments[0]}/{kind}", {}), kind)
    for name in increments:
        grid = ElementTree.SubElement(series, "Grid", Name=f"increment {int(name)}", GridType="Uniform")
        ElementTree.SubElement(grid, "Time", Value=str(int(name)))
        grid.extend(_mesh(mesh, cell_type))
        grid.extend(constant)
        grid.extend(_of_increment(attribute, increments[0], name) for attribute in alike)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)


def _attributes(
    mesh: h5py.Group,
    states: h5py.Group,
    names: Sequence[tuple[str, str]],
    derived: Mapping[str, h5py.Dataset],
    kind: str,
) -> list[ElementTree.Element]:
    """Return the attributes of an increment; those of all others differ in its name only."""
    points, centre = mesh["points"].shape[0], "Cell" if kind == "elements" else "Node"
    items = [_item(states[stored], "Node", shown, points) for shown, stored in names]
    return items + [_item(values, centre, shown) for shown, values in derived.items()]


def _of_increment(attribute: ElementTree.Element, first: str, name: str) -> ElementTree.Element:
    """Return an attribute of the increment `first` as that of the increment `name`."""
    copied = deepcopy(attribute)
    for item in copied.iter("DataItem"):
        item.text = (item.text or "").replace(f":/{first}/", f":/{name}/")
    return copied


def _mesh(mesh: h5py.Group, cell_type: str) -> list[ElementTree.Element]:
    points, cells = mesh["points"], mesh["cells"]
    topology = ElementTree.Element("Topology", TopologyType=cell_type, NumberOfElements=str(cells.shape[0]))
    topology.append(_data(cells))
    geometry = ElementTree.Element("Geometry", GeometryType="XYZ")
    geometry.append(_data(points))
    return [topology, geometry]


def _item(dataset: h5py.Dataset, center: str, name: str, rows: int | None = None) -> ElementTree.Element:
    """Return an attribute of the dataset, or of its first `rows` only (edges of 10-node tetrahedra follow)."""
    kind = ATTRIBUTE_TYPES[1 if dataset.ndim == 1 else dataset.shape[1]]
    attribute = ElementTree.Element("Attribute", Name=name, AttributeType=kind, Center=center)
    attribute.append(_data(dataset) if rows in (None, len(dataset)) else _first_rows(dataset, rows))
    return attribute


def _first_rows(dataset: h5py.Dataset, rows: int) -> ElementTree.Element:
    shape = (rows, *dataset.shape[1:])
    item = ElementTree.Element("DataItem", ItemType="HyperSlab", Dimensions=" ".join(map(str, shape)))
    rank = len(shape)
    begin = ElementTree.SubElement(item, "DataItem", Dimensions=f"3 {rank}", NumberType="Int", Format="XML")
    begin.text = " ".join(map(str, [0] * rank + [1] * rank + list(shape)))
    item.append(_data(dataset))
    return item


def _data(dataset: h5py.Dataset) -> ElementTree.Element:
    """Refer to a dataset by file and path; the type is taken from the dataset itself."""
    item = ElementTree.Element(
        "DataItem",
        Dimensions=" ".join(map(str, dataset.shape)),
        NumberType=NUMBER_TYPES[dataset.dtype.kind],
        Precision=str(dataset.dtype.itemsize),
        Format="HDF",
    )
    item.text = f"{Path(dataset.file.filename).name}:{dataset.name}"
    return item

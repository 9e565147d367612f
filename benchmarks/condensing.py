"""What one factorisation costs with bodies as they are, and condensed to the unknowns of their contacts.

    python benchmarks/condensing.py

Benchmark 1 in macroblocks and stone by stone, with elements of its mesh size, a half and a quarter of it. "whole": the
matrix of all unknowns, bodies and closed contacts. "condensed": the Schur complement of the unknowns in contact, which
is dense within a body; what condensing itself takes is left out, and only contacts of the undeformed wall are kept, as
few as there can be. Both are factorised and solved by MUMPS, the pattern analysed before. "operations" are those of its
elimination, which no other work on the machine changes. Writes condensing.csv beside this file.
"""

from __future__ import annotations

from pathlib import Path
from statistics import median
from time import process_time

import numpy as np
import scipy.sparse as sparse
from measure import write
from mpi4py import MPI
from petsc4py import PETSc

from orchestrator import MeshSettings, analyse, find_joints, macroblocks_of, one_body_per_block, read_case, read_wall
from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.pushover.meshing import mesh_bodies
from orchestrator.pushover.model import ContactModel, build_model
from orchestrator.pushover.solve.newton_matrix import PENALTY

TEMPLATE = Path(__file__).parents[1] / "templates" / "benchmark1.toml"
REPEATED = 9


def whole(model: ContactModel) -> sparse.csr_matrix:
    """Return stiffness (n, n) of bodies and of contacts, all of them closed."""
    along = sparse.diags(np.tile([PENALTY, 1.0, 1.0], len(model.contacts)) * model.contact_stiffness)
    return (model.stiffness + model.contact_columns @ along @ model.contact_rows).tocsr()


def condensed(model: ContactModel) -> sparse.csr_matrix:
    """Return the Schur complement of the unknowns of contacts."""
    matrix = whole(model).tocsc()
    nodes = np.zeros(len(model.body), bool)
    contacts = model.contacts
    nodes[contacts.slave_node[contacts.slave_node >= 0]] = True
    nodes[contacts.master_nodes[contacts.weights != 0.0]] = True
    kept = np.repeat(nodes, 3)
    inside = sparse.linalg.splu(matrix[~kept][:, ~kept])
    coupling = matrix[~kept][:, kept]
    reached = sparse.csc_matrix(inside.solve(coupling.toarray()))
    reached.data[np.abs(reached.data) < 1e-14] = 0.0
    reached.eliminate_zeros()
    return (matrix[kept][:, kept] - coupling.T @ reached).tocsr()


def cost(matrix: sparse.csr_matrix) -> dict[str, float]:
    """Return unknowns, entries, operations (millions) and CPU time (ms) of a factorisation and a solution."""
    matrix.sort_indices()
    given = PETSc.Mat().createAIJ(matrix.shape, csr=(matrix.indptr, matrix.indices, matrix.data), comm=MPI.COMM_SELF)
    solver = PETSc.KSP().create(MPI.COMM_SELF)
    solver.setOperators(given)
    solver.setType("preonly")
    solver.getPC().setType("lu")
    solver.getPC().setFactorSolverType("mumps")
    solution, right = given.createVecs()
    right.set(1.0)
    taken = []
    for _ in range(REPEATED):
        given.assemble()
        given.stateIncrease()
        began = process_time()
        solver.solve(right, solution)
        taken.append(1e3 * (process_time() - began))
    operations = solver.getPC().getFactorMatrix().getMumpsRinfog(3)
    return {
        "unknowns": matrix.shape[0],
        "entries": matrix.nnz,
        "operations_millions": 1e-6 * operations,
        "milliseconds": median(taken[1:]),
    }


def main() -> None:
    """Measure all and write the table."""
    case = read_case(TEMPLATE)
    assemblage = find_joints(read_wall(case), case.joints)
    partitions = {
        "macroblocks": macroblocks_of(assemblage, analyse(assemblage)),
        "micro-FE": one_body_per_block(assemblage),
    }
    rows = []
    for name, partition in partitions.items():
        bodies = make_bodies(assemblage, partition)
        for finer in (1, 2, 4):
            size = case.mesh.size_of(bodies) / finer
            meshes = mesh_bodies(bodies, MeshSettings(size), None)
            model = build_model(bodies, meshes, case.elastic, case.contact)
            for kind, matrix in (("whole", whole(model)), ("condensed", condensed(model))):
                rows.append({"benchmark 1": name, "mesh.size over": finer, "matrix": kind, **cost(matrix)})
    write("condensing.csv", rows)


if __name__ == "__main__":
    main()

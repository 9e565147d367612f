"""The Newton matrix of one increment, and the matrix that is factorised in its place (numpy only).

Unknowns x = (du, dlambda / kappa, dalpha), kappa = contact stiffness, which brings all entries to one magnitude:

    [ K + M/dt^2 + B_t^T T B_t   kappa (-B_n^T + B_t^T S)   -f_h ]
    [ kappa P B_n                kappa N                      0  ]
    [ kappa mean row | 0         0             0 | kappa         ]   displacement control | load prescribed

T (2, 2) = d tau / d slip, S (2,) = d tau / d lambda. Where a contact is active P = 1, N = kappa x (compliance of its
mortar, 0 without), elsewhere P = d (tension of an open contact) / d gap over kappa, which is 0 without bond, and N = 1
(1 + d tension / d gap x compliance in mortar that is bonded).

The multipliers are eliminated contact by contact after N has been replaced by Z, where active no less than 1 /
`PENALTY`: an augmented Lagrangian. What remains is as large as the bodies' own K, has no zeros on its diagonal, and
each contact adds to it one 3 x 3 matrix, weighted for each pair of its nodes (slave weight 1, master weights -w_j):

    weight_i weight_j (n, t, z) [ kappa P / Z                0 ] (n, t, z)^T
                                [ -kappa S P / Z             T ]

so that a wall that moves keeps its pattern, with new weights, until a contact comes, goes, or meets another triangle.
Each rank makes the rows of its own nodes only. linear_system.py corrects for the penalty by refinement.

M. Fortin, R. Glowinski, Augmented Lagrangian Methods, North-Holland 1983.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import scipy.sparse as sparse

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.pushover.contact.contact_search import Contacts
from orchestrator.pushover.model import ContactModel

PENALTY = 1e6
"""stiffness of an active contact in the factorised matrix over kappa, about what a refinement divides errors by (1e7
takes as many solutions of large systems, and 8 % more of small ones, whose elimination loses more to rounding)"""


@dataclass(frozen=True, eq=False, slots=True)
class Coefficients:
    """What changes from one Newton iteration to the next, for c contacts.

    slip_stiffness (c, 2, 2) in N/m = T, pressure_slope (c, 2) = S, gap_slope (c,) = P, softness (c,) = N; active (c,):
    contacts that are closed and do not crush. tie_stiffness (m,) in N/m: of ties, where they are elastic.
    """

    slip_stiffness: FloatArray
    pressure_slope: FloatArray
    gap_slope: FloatArray
    softness: FloatArray
    active: BoolArray
    displacement_control: bool
    tie_stiffness: FloatArray | None = None

    @property
    def compliance(self) -> FloatArray:
        """Z (c,): N, in active contacts no less than 1 / PENALTY."""
        return np.where(self.active, np.maximum(self.softness, 1.0 / PENALTY), self.softness)


@dataclass(frozen=True, eq=False, slots=True)
class Matrices:
    """What product() multiplies with, in one precision: stiffness, mass (n, n), contact_rows B (3 c, n) and B^T."""

    stiffness: sparse.bsr_matrix
    mass: sparse.csr_matrix
    contact_rows: sparse.csr_matrix
    contact_columns: sparse.csc_matrix

    @classmethod
    def of(cls, model: ContactModel, precision: npt.DTypeLike = float) -> Matrices:
        """Return those of a model."""
        stiffness, mass, rows = (
            matrix.astype(precision, copy=False) for matrix in (model.stiffness, model.mass, model.contact_rows)
        )
        return cls(stiffness, mass, rows, rows.T)


def product(
    model: ContactModel, matrices: Matrices, contact: Coefficients, time_step: float, x: FloatArray
) -> FloatArray:
    """Return the Newton matrix (the exact one) times x (unknowns,)."""
    n, kappa = len(model.gravity), model.contact_stiffness
    change, multiplier, alpha = x[:n], x[n:-1], x[-1]
    opening = (matrices.contact_rows @ change).reshape(-1, 3)
    pull = np.empty_like(opening)  # on the slaves, with the sign of the residual
    pull[:, 0] = -kappa * multiplier
    pull[:, 1:] = np.einsum("cij,cj->ci", contact.slip_stiffness, opening[:, 1:])
    pull[:, 1:] += kappa * contact.pressure_slope * multiplier[:, None]
    forces = matrices.stiffness @ change + matrices.contact_columns @ pull.ravel()
    forces += matrices.mass @ (change / np.square(time_step))
    if model.ties is not None and contact.tie_stiffness is not None:
        forces = forces + model.ties.rows.T @ (contact.tie_stiffness * (model.ties.rows @ change))
    gap = contact.gap_slope * opening[:, 0] + contact.softness * multiplier
    if contact.displacement_control:
        lateral = model.lateral / model.height
        return np.concatenate([forces - alpha * lateral, kappa * gap, [kappa * float(model.mean_row @ change)]])
    return np.concatenate([forces, kappa * gap, [kappa * alpha]])


def condensed_right(model: ContactModel, contact: Coefficients, right: FloatArray) -> FloatArray:
    """Return right-hand sides (..., n + 1) of the factorised matrix for those of all unknowns, (..., unknowns)."""
    n = len(model.gravity)
    pull = np.ones((len(contact.active), 3))
    pull[:, 1:] = -contact.pressure_slope
    pull = pull * (right[..., n:-1] / contact.compliance)[..., None]
    forces = right[..., :n] + (model.contact_columns @ pull.reshape(*right.shape[:-1], -1).T).T
    return np.concatenate([forces, right[..., -1:]], axis=-1)


def expanded(model: ContactModel, contact: Coefficients, right: FloatArray, solution: FloatArray) -> FloatArray:
    """Return all unknowns (..., unknowns) for the solutions (..., n + 1) of the factorised matrix."""
    n = len(model.gravity)
    opening = (model.normal_rows @ solution[..., :n].T).T
    force = right[..., n:-1] / model.contact_stiffness - contact.gap_slope * opening
    return np.concatenate([solution[..., :n], force / contact.compliance, solution[..., n:]], axis=-1)


@dataclass(frozen=True, eq=False, slots=True)
class Pattern:
    """CSR rows of the factorised matrix that belong to one rank's nodes (the last node's rank has alpha's).

    indptr, indices: int32, columns of the whole matrix. place (b, 9): where the entries of the b node blocks (3 x 3)
    stand among the values. border (k,), border_values (k,): places and values of the entries that are there under
    displacement control, corner: the one that is there else (empty on other ranks). elastic: numbers of the blocks
    of K that belong here; block_of_elastic: their place among the blocks. mass (b, 3) in kg, along each axis. pairs
    (p,): numbers contact x 16 + i x 4 + j of the pairs of nodes of contacts; touched (t,): the blocks they add to;
    weights (t, c): products of weights, in CSR form. tied (b, m): likewise of ties, for all blocks.
    """

    indptr: IntArray
    indices: IntArray
    place: IntArray
    border: IntArray
    border_values: FloatArray
    corner: IntArray
    elastic: slice
    block_of_elastic: IntArray
    mass: FloatArray
    pairs: IntArray
    touched: IntArray
    weights: sparse.csr_matrix
    tied: sparse.csr_matrix | None = None


def _nodes_and_weights(contacts: Contacts) -> tuple[IntArray, FloatArray]:
    """Return nodes and weights (c, 4) of each contact, slave first; -1 where there is none."""
    slave = contacts.slave_node >= 0
    master = contacts.weights.any(axis=1)
    nodes = np.where(
        np.column_stack([slave, master, master, master]),
        np.column_stack([contacts.slave_node, contacts.master_nodes]),
        -1,
    )
    weights = np.column_stack([np.ones(len(slave)), -contacts.weights])
    if not contacts.moving:  # what is zero stays zero
        nodes = np.where(weights == 0.0, -1, nodes)
    return nodes, weights


def _pair_weights(contacts: Contacts, pairs: IntArray) -> FloatArray:
    _, weights = _nodes_and_weights(contacts)
    return (weights[:, :, None] * weights[:, None, :]).ravel()[pairs]


def make_pattern(model: ContactModel, first: int, last: int) -> Pattern:
    """Build the rows of nodes first <= node < last; whoever has the last node has the load multiplier's row too."""
    count = len(model.body)
    elastic = model.stiffness
    nodes, _ = _nodes_and_weights(model.contacts)
    row, column = (np.broadcast_to(k, (len(nodes), 4, 4)).ravel() for k in (nodes[:, :, None], nodes[:, None, :]))
    pairs = np.flatnonzero((row >= first) & (row < last) & (column >= 0))
    blocks = slice(int(elastic.indptr[first]), int(elastic.indptr[last]))
    elastic_row = np.repeat(np.arange(first, last, dtype=np.int64), np.diff(elastic.indptr[first : last + 1]))
    key = np.concatenate([elastic_row * count + elastic.indices[blocks], row[pairs] * count + column[pairs]])
    tie, one, other, product = _pairs_of_ties(model, first, last)
    slots, slot = np.unique(np.concatenate([key, one * count + other]), return_inverse=True)
    elastic_slot, pair_slot, tie_slot = np.split(slot, [len(elastic_row), len(key)])
    layout = _layout(model, first, last, slots)
    mass = np.column_stack([_masses(model, first, last, axis, slots) for axis in range(3)])
    order = np.lexsort((pairs // 16, pair_slot))
    pairs, pair_slot = pairs[order], pair_slot[order]
    touched, begin = np.unique(pair_slot, return_index=True)
    return Pattern(
        **layout,
        elastic=blocks,
        block_of_elastic=elastic_slot,
        mass=mass,
        pairs=pairs,
        touched=touched,
        weights=sparse.csr_matrix(
            (
                _pair_weights(model.contacts, pairs),
                (pairs // 16).astype(np.int32),
                np.append(begin, len(pairs)).astype(np.int32),
            ),
            shape=(len(touched), len(model.contacts)),
        ),
        tied=sparse.csr_matrix((product, (tie_slot, tie)), (len(slots), len(model.ties))) if model.ties else None,
    )


def _masses(model: ContactModel, first: int, last: int, axis: int, slots: IntArray) -> FloatArray:
    """Return the mass (b,) in kg along an axis that stands in each node block (keys `slots`, in order)."""
    inertia = model.mass[3 * first + axis : 3 * last : 3, axis::3].tocoo()
    key = (inertia.row.astype(np.int64) + first) * len(model.body) + inertia.col
    slot = np.searchsorted(slots, key)
    assert np.array_equal(slots[slot], key), "masses stand where stiffness does"
    return np.bincount(slot, inertia.data, len(slots)).astype(float)


def _pairs_of_ties(model: ContactModel, first: int, last: int) -> tuple[IntArray, IntArray, IntArray, FloatArray]:
    """Return tie, both nodes and the product of their weights of all pairs of nodes of ties, the first in the rows."""
    found: list[tuple[IntArray, IntArray, IntArray, FloatArray]] = []
    for tie in range(len(model.ties or ())):
        assert model.ties is not None
        row = model.ties.weights[tie]
        nodes = row.indices.astype(np.int64)
        one, other = (k.ravel() for k in np.meshgrid(nodes, nodes, indexing="ij"))
        here = (one >= first) & (one < last)
        weight = np.outer(row.data, row.data).ravel()[here]
        found.append((np.full(len(weight), tie), one[here], other[here], weight))
    if not found:
        nothing = np.zeros(0, np.int64)
        return nothing, nothing, nothing, np.zeros(0)
    tie_, one_, other_, weight_ = (np.concatenate(part) for part in zip(*found, strict=True))
    return tie_, one_, other_, weight_


def _layout(model: ContactModel, first: int, last: int, slots: IntArray) -> dict[str, npt.NDArray]:
    """Return where in the CSR rows the entries of node blocks (keys `slots`, in order) and of the border stand."""
    count, alpha = len(model.body), len(model.gravity)
    node, other = slots // count, slots % count
    of_node = np.bincount(node - first, minlength=last - first)
    loaded = model.lateral != 0.0
    length = np.repeat(3 * of_node, 3) + loaded[3 * first : 3 * last]
    driven = np.flatnonzero(loaded) if last == count else np.zeros(0, np.int64)
    if last == count:
        length = np.append(length, len(driven) + 1)
    indptr = np.concatenate([[0], np.cumsum(length)])
    before = np.arange(len(slots)) - np.repeat(np.cumsum(of_node) - of_node, of_node)
    row = 3 * (node - first)[:, None] + np.arange(3)
    place = (indptr[row][:, :, None] + 3 * before[:, None, None] + np.arange(3)).ravel()
    indices = np.zeros(indptr[-1], np.int32)
    indices[place] = np.broadcast_to(3 * other[:, None, None] + np.arange(3), (len(slots), 3, 3)).ravel()
    own = np.flatnonzero(loaded[3 * first : 3 * last])
    column_place = indptr[own + 1] - 1
    indices[column_place] = alpha
    row_place = indptr[-1] - 1 - len(driven) + np.arange(len(driven))
    indices[row_place] = driven
    corner = np.array([indptr[-1] - 1] if last == count else [], np.int64)
    indices[corner] = alpha
    lateral = -model.lateral[3 * first + own] / model.height
    mean = model.contact_stiffness * model.mean_row[driven]
    return {
        "indptr": indptr.astype(np.int32),
        "indices": indices,
        "place": place.reshape(-1, 9),
        "border": np.concatenate([column_place, row_place]),
        "border_values": np.concatenate([lateral, mean]),
        "corner": corner,
    }


def with_values_of(pattern: Pattern, model: ContactModel) -> Pattern:
    """Return the pattern with the weights of a model whose contacts connect the same nodes."""
    old = pattern.weights
    weights = sparse.csr_matrix((_pair_weights(model.contacts, pattern.pairs), old.indices, old.indptr), old.shape)
    return replace(pattern, weights=weights)


def connect_alike(first: ContactModel, second: ContactModel) -> bool:
    """Return whether two states of a model have one pattern: the same contacts, on the same nodes, and loads."""
    same_nodes = np.array_equal(first.contacts.master_nodes, second.contacts.master_nodes)
    same_load = first.lateral is second.lateral and first.mean_row is second.mean_row
    return np.array_equal(first.rows, second.rows) and same_nodes and same_load


def values(
    pattern: Pattern, model: ContactModel, contact: Coefficients, time_step: float, bodies: FloatArray | None = None
) -> FloatArray:
    """Return the values of the pattern's entries; bodies: those of `values_of_bodies`, where they are known."""
    found = values_of_bodies(pattern, model, time_step) if bodies is None else bodies.copy()
    blocks = pattern.weights @ _contact_matrices(model, contact).reshape(-1, 9)
    found[pattern.place[pattern.touched]] += blocks
    if pattern.tied is not None and model.ties is not None and contact.tie_stiffness is not None:
        along = model.ties.along
        stretched = contact.tie_stiffness[:, None, None] * along[:, :, None] * along[:, None, :]
        in_plane = pattern.place.reshape(-1, 3, 3)[:, :2, :2].reshape(-1, 4)
        found[in_plane] += pattern.tied @ stretched.reshape(-1, 4)
    if contact.displacement_control:
        found[pattern.border] = pattern.border_values
    else:
        found[pattern.corner] = model.contact_stiffness
    return found


def values_of_bodies(pattern: Pattern, model: ContactModel, time_step: float) -> FloatArray:
    """Return what the bodies' stiffness and mass make of the values of the pattern's entries."""
    blocks = np.zeros((len(pattern.place), 3, 3))
    blocks[pattern.block_of_elastic] = model.stiffness.data[pattern.elastic]
    diagonal = np.arange(3)
    blocks[:, diagonal, diagonal] += pattern.mass / np.square(time_step)
    found = np.zeros(len(pattern.indices))
    found[pattern.place.ravel()] = blocks.ravel()
    return found


def _contact_matrices(model: ContactModel, contact: Coefficients) -> FloatArray:
    """Return the 3 x 3 matrix of each contact in the wall's axes, (c, 3, 3) in N/m."""
    axes = model.contacts.axes
    own = np.zeros_like(axes)
    own[:, 0, 0] = model.contact_stiffness * contact.gap_slope / contact.compliance
    own[:, 1:, 0] = -own[:, 0, 0, None] * contact.pressure_slope
    own[:, 1:, 1:] = contact.slip_stiffness
    return axes.transpose(0, 2, 1) @ own @ axes

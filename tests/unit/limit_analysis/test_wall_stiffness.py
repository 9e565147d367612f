"""B J B^T of a wall from the matrices of its joints, against the product of dense matrices."""

from __future__ import annotations

import ctypes
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse as sp

from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.search.wall_stiffness import (
    AFTERWARDS,
    ENTRIES,
    KEEPS,
    WallStiffness,
    joint_products,
    kept_memory,
)
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import running_bond
from tests.support.limit_analysis_cases import assemblage_of, box

WALLS = {
    "bond": lambda: find_joints(running_bond(4, 5), JointSettings()),
    "block": lambda: assemblage_of([box(-3, -1, 6, 1), box(0, 0, 1, 1)]),
    "loose": lambda: assemblage_of([box(-3, -1, 9, 1), box(0, 0, 1, 1), box(3, 0, 1, 1)]),
}


def dense(joints):
    """Return the block-diagonal matrix of all joints."""
    blocks = np.zeros((len(joints), 3, 3))
    blocks[:, *np.transpose(ENTRIES)] = joints
    return blocks, sp.block_diag(blocks).toarray()


@pytest.mark.parametrize("wall", sorted(WALLS))
@pytest.mark.parametrize("drag", [0.0, 3.0])
def test_linear_systems_are_those_of_the_dense_product(wall, drag):
    B = assemble_equilibrium(WALLS[wall]()).matrix
    stiffness, rng = WallStiffness(B), np.random.default_rng(1)
    for _ in range(3):  # the same pattern with ever new joints
        joints = rng.uniform(0.5, 2.0, (B.shape[1] // 3, len(ENTRIES)))
        matrix = B.toarray() @ dense(joints)[1] @ B.toarray().T + drag * np.identity(B.shape[0])
        load = rng.normal(size=B.shape[0])
        factors = stiffness.factorised(joints, drag)
        solved = factors.solve(load)
        assert np.abs(solved).max() > 0
        assert solved == pytest.approx(np.linalg.solve(matrix, load), rel=1e-9, abs=1e-12)
        assert factors.solve(np.stack([load, -2.0 * load])) == pytest.approx(np.stack([solved, -2.0 * solved]))


def test_a_block_that_no_joint_holds_has_a_singular_matrix():
    B = assemble_equilibrium(WALLS["block"]()).matrix
    with pytest.raises(RuntimeError, match="singular"):
        WallStiffness(B).factorised(np.zeros((B.shape[1] // 3, len(ENTRIES))))


def test_products_joint_by_joint():
    rng = np.random.default_rng(2)
    joints, vectors = rng.normal(size=(7, len(ENTRIES))), rng.normal(size=(7, 3))
    assert joint_products(joints, vectors) == pytest.approx(np.einsum("kij,kj->ki", dense(joints)[0], vectors))


def test_memory_is_kept_for_a_while(monkeypatch):
    """What the C library is told while factorising, and after it, also after an error."""
    told = {}

    def mallopt(threshold, least):
        told[threshold] = least
        return 1

    monkeypatch.setattr(ctypes, "CDLL", lambda _: SimpleNamespace(mallopt=mallopt))

    def factorise():
        with kept_memory():
            assert set(told.values()) == {KEEPS}
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        factorise()
    assert len(told) == 2
    assert set(told.values()) == {AFTERWARDS}


@pytest.mark.parametrize("least_refused", [0, KEEPS])
def test_what_a_c_library_refuses_is_not_insisted_on(monkeypatch, least_refused):
    """One that allows less is told less, for the time of the work too; one that refuses everything breaks nothing."""
    told = {}

    def mallopt(threshold, least):
        if least >= least_refused:
            return 0
        told[threshold] = least
        return 1

    monkeypatch.setattr(ctypes, "CDLL", lambda _: SimpleNamespace(mallopt=mallopt))
    with kept_memory():
        assert list(told.values()) == ([AFTERWARDS, AFTERWARDS] if least_refused else [])


def test_a_c_library_without_such_settings_is_left_alone(monkeypatch):
    monkeypatch.setattr(ctypes, "CDLL", lambda _: SimpleNamespace())
    with kept_memory():
        worked = True
    assert worked

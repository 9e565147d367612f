"""Bodies that meet in one point only: the corner of one against the corner of the other (numpy only).

Four stones that meet in a point are two pairs that have no face in common. Where one of such a pair slides on its
neighbours over the corner of the other, its own corner goes into it. A corner is outside another one, a convex one, as
long as it is in front of one of its two faces: of the two contacts only the one with the larger gap is any.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.geometry.rigid import cross
from orchestrator.pushover.contact.faces import Faces


def corners_in_common(
    faces: Faces, apart: float, turned: float, known: set[tuple[int, int]], moving: int
) -> list[tuple[int, int]]:
    """Return pairs of faces: one that ends in a corner of its body, and one of another body that the corner may meet.

    The corners lie within `apart` (m), and all of the first body at its corner is in front of both faces of the other
    one (but for `turned`, rad). Bodies that have faces in common, `known` with the smaller number first, are no such
    pair; nor are two supports (from number `moving` on).
    """
    stops = np.argsort(faces.stop)  # face that ends in the corner where another one begins
    before = stops[np.searchsorted(faces.stop[stops], faces.begin)]
    pairs = []
    for here, there in cKDTree(faces.start).query_pairs(apart, output_type="ndarray"):
        one, other = int(faces.body[here]), int(faces.body[there])
        if one == other or (min(one, other), max(one, other)) in known or min(one, other) >= moving:
            continue
        for a, b in ((here, there), (there, here)):
            if cross(faces.tangent[before[b]], faces.tangent[b]) <= 0.0:
                continue  # a notch, or a straight line
            sides = np.stack([faces.tangent[a], -faces.tangent[before[a]]])
            if (sides @ faces.normal[[before[b], b]].T).min() > -np.sin(turned):
                pairs += [(int(before[a]), int(face)) for face in (before[b], b)]
    return sorted(set(pairs))


def of_larger_gap(
    place: IntArray, height: FloatArray, known: npt.NDArray[np.bool_], depth: FloatArray
) -> npt.NDArray[np.bool_]:
    """Return which contacts of corners (c,) exist: at each place (c,), their number, that of the largest height (m).

    Where none of a place was `known` (c,) before, from a depth (c,) in m on.
    """
    count = int(place.max(initial=-1)) + 1
    largest = np.full(count, -np.inf)
    np.maximum.at(largest, place, height)
    were = np.zeros(count, bool)
    np.logical_or.at(were, place, known)
    return (height == largest[place]) & (were[place] | (height < -depth))

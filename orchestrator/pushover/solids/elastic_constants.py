"""Elastic constants of the bodies: of their stones' materials, or those of the case.

A body of several materials has Young's modulus E = sum E_p V_p / V, the mean of its parts by volume (Voigt's bound, the
stiffest), and Poisson's ratio likewise. A part thinner than the wall fills less of V: its stiffness is spread over the
wall's thickness, as its weight is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.macroblocks.bodies import Bodies, Body
from orchestrator.pushover.settings import ElasticSettings


@dataclass(frozen=True, eq=False, slots=True)
class ElasticConstants:
    """elastic_modulus (Pa) and poisson_ratio, both (bodies,), supports included."""

    elastic_modulus: FloatArray
    poisson_ratio: FloatArray


def constants_of(bodies: Bodies, elastic: ElasticSettings) -> ElasticConstants:
    """Return the constants of every body; stones that have none of their own have those of the case."""
    constants = np.array([_of_body(body, elastic) for body in bodies.bodies])
    return ElasticConstants(read_only(constants[:, 0]), read_only(constants[:, 1]))


def _of_body(body: Body, elastic: ElasticSettings) -> tuple[float, float]:
    shares = np.array([part.share for part in body.parts])
    modulus = [elastic.elastic_modulus if p.elastic_modulus is None else p.elastic_modulus for p in body.parts]
    ratio = [elastic.poisson_ratio if p.poisson_ratio is None else p.poisson_ratio for p in body.parts]
    if len(set(ratio)) == 1:
        return float(shares @ modulus), ratio[0]
    return float(shares @ modulus), float(shares @ ratio / shares.sum())

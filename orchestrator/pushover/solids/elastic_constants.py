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
from orchestrator.pushover.settings import ContactSettings, ElasticSettings

SLIP_SHARE = 1.0 / 3.0
"""elastic slip over what a mean stone is shortened by under half of the wall's weight: 0.9 micrometres in
benchmark 1, whose case file has 1. A joggled arch of 15 stones bears 0.2437 with it, 0.2432 with a thirtieth of it"""


@dataclass(frozen=True, eq=False, slots=True)
class ElasticConstants:
    """elastic_modulus (Pa) and poisson_ratio, both (bodies,), supports included."""

    elastic_modulus: FloatArray
    poisson_ratio: FloatArray


def constants_of(bodies: Bodies, elastic: ElasticSettings) -> ElasticConstants:
    """Return the constants of every body; stones that have none of their own have those of the case."""
    constants = np.array([_of_body(body, elastic) for body in bodies.bodies])
    return ElasticConstants(read_only(constants[:, 0]), read_only(constants[:, 1]))


def slip_tolerance_of(bodies: Bodies, elastic: ElasticSettings, contact: ContactSettings) -> float:
    """Return the elastic slip in m at which friction reaches Coulomb's limit: the given one, or one for the wall.

    It is the same for every stone and for macroblocks.
    """
    if contact.slip_tolerance is not None:
        return contact.slip_tolerance
    moving = bodies.bodies[: bodies.moving]
    area = np.array([body.area for body in moving])
    modulus = float(area @ constants_of(bodies, elastic).elastic_modulus[: bodies.moving] / area.sum())
    along = np.concatenate([body.exterior[:, 0] for body in moving])
    pressure = 0.5 * float(area @ [body.unit_weight for body in moving]) / float(np.ptp(along))
    return float(SLIP_SHARE * pressure * bodies.mean_stone / modulus)


def _of_body(body: Body, elastic: ElasticSettings) -> tuple[float, float]:
    shares = np.array([part.share for part in body.parts])
    modulus = [elastic.elastic_modulus if p.elastic_modulus is None else p.elastic_modulus for p in body.parts]
    ratio = [elastic.poisson_ratio if p.poisson_ratio is None else p.poisson_ratio for p in body.parts]
    if len(set(ratio)) == 1:
        return float(shares @ modulus), ratio[0]
    return float(shares @ modulus), float(shares @ ratio / shares.sum())

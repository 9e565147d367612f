"""Friction between two bodies: a penalty whose stiffness follows the pressure (numpy only).

With normal force lambda >= 0 (a nodal force, N), coefficient of friction mu and slip tolerance gamma (m):

    p   = q_n + B_t (u - u_n)                       trial elastic slip, m
    q   = p                      if |p| <= gamma    stick
          gamma p / |p|          otherwise          slip
    tau = mu lambda q / gamma                       so that |tau| <= mu lambda holds identically

Mortar of shear stiffness k (N/m of the contact) has gamma = mu lambda / k in the place of the tolerance: tau = k p
while it sticks, whatever the pressure. Else the return map does not depend on lambda. Tangents (both kept, which makes
the system unsymmetric):

    d tau / d p      = mu lambda D / gamma,   D = I (stick),  gamma/|p| (I - p p^T / |p|^2) (slip)
    d tau / d lambda = mu q / gamma   (0 in mortar that sticks; that of lambda > 0, of open contacts, too)

Source: the "stiffness method" with slip tolerance of general-purpose contact codes; P. Wriggers, Computational Contact
Mechanics, 2nd ed., Springer 2006, return mapping for friction.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray
from orchestrator.pushover.contact.cohesion import BondResponse

LEAST_TOLERANCE = 1e-3
"""elastic slip over the slip tolerance below which mortar shears no less, where it is hardly pressed"""


@dataclass(frozen=True, eq=False, slots=True)
class FrictionResponse:
    """traction (c, 2) in N, elastic_slip (c, 2) in m, sliding (c,), and the tangents.

    slip_stiffness (c, 2, 2) in N/m = d traction / d trial slip; pressure_slope (c, 2) = d traction / d normal force.
    limit (c,) in N: what the traction reaches, at an elastic slip of tolerance (c,) in m. elastic (c,): contacts whose
    shear stiffness is the mortar's while they stick, whatever the pressure.
    """

    traction: FloatArray
    elastic_slip: FloatArray
    sliding: BoolArray
    slip_stiffness: FloatArray
    pressure_slope: FloatArray
    limit: FloatArray
    tolerance: FloatArray
    elastic: BoolArray

    def damped(self, slip: FloatArray, viscosity: FloatArray) -> FrictionResponse:
        """Return the response with the viscous traction viscosity (c,) in N/m x slip (c, 2) in m added."""
        return replace(
            self,
            traction=self.traction + viscosity[:, None] * slip,
            slip_stiffness=self.slip_stiffness + viscosity[:, None, None] * np.eye(2),
        )

    def at_given_pressure(self) -> FrictionResponse:
        """Return the response for a normal force that is given, whatever that of the contact is."""
        return replace(self, pressure_slope=np.zeros_like(self.pressure_slope), elastic=np.zeros_like(self.elastic))

    def bonded(
        self, trial_slip: FloatArray, normal_force: FloatArray, friction: FloatArray, bond: BondResponse
    ) -> FrictionResponse:
        """Return the response whose limit is max(mu lambda + cohesion, 0), and softens with slip."""
        limit: FloatArray = np.where(bond.intact, np.maximum(friction * normal_force + bond.cohesion, 0.0), self.limit)
        length = np.linalg.norm(trial_slip, axis=1)
        share = self.elastic_slip / self.tolerance[:, None]
        direction = trial_slip / np.maximum(length, self.tolerance)[:, None]
        projector = np.eye(2) - self.sliding[:, None, None] * direction[:, :, None] * direction[:, None, :]
        shrink = limit / np.maximum(length, self.tolerance)
        softening = bond.cohesion_slope[:, None, None] * share[:, :, None] * direction[:, None, :]
        slope = np.where(bond.intact & (limit > 0.0), friction, 0.0)[:, None] * share
        return replace(
            self,
            traction=limit[:, None] * share,
            slip_stiffness=shrink[:, None, None] * projector + np.where((limit > 0.0)[:, None, None], softening, 0.0),
            pressure_slope=np.where(bond.intact[:, None], slope, self.pressure_slope),
            limit=limit,
        )


def friction_response(
    trial_slip: FloatArray,
    normal_force: FloatArray,
    friction: FloatArray,
    slip_tolerance: float,
    shear_stiffness: FloatArray | None,
) -> FrictionResponse:
    """Return tractions and tangents of c contacts: trial_slip (c, 2) in m, normal_force (c,) in N, friction (c,).

    shear_stiffness (c,) in N/m of the mortar, infinite where there is none; None: nowhere.
    """
    length = np.linalg.norm(trial_slip, axis=1)
    limit = friction * np.maximum(normal_force, 0.0)
    tolerance, elastic = tolerances(limit, slip_tolerance, shear_stiffness)
    sliding = length > tolerance
    shrink = np.where(sliding, tolerance / np.maximum(length, tolerance), 1.0)
    direction = np.where(sliding[:, None], trial_slip / np.maximum(length, tolerance)[:, None], 0.0)
    elastic_slip = shrink[:, None] * trial_slip
    follows = sliding | ~elastic
    pressure_slope = np.where(follows, friction, 0.0)[:, None] * elastic_slip / tolerance[:, None]
    projector = np.eye(2) - direction[:, :, None] * direction[:, None, :]
    return FrictionResponse(
        traction=limit[:, None] * elastic_slip / tolerance[:, None],
        elastic_slip=elastic_slip,
        sliding=sliding,
        slip_stiffness=(limit / tolerance * shrink)[:, None, None] * projector,
        pressure_slope=pressure_slope,
        limit=limit,
        tolerance=tolerance,
        elastic=elastic,
    )


def tolerances(
    limit: FloatArray, slip_tolerance: float, shear_stiffness: FloatArray | None
) -> tuple[FloatArray, BoolArray]:
    """Return the elastic slip (c,) in m at which the traction reaches its limit (c,) in N, and whether mortar sets it.

    That is limit / stiffness in mortar, but where hardly anything presses, `LEAST_TOLERANCE` of the slip tolerance.
    """
    if shear_stiffness is None:
        return np.full(len(limit), slip_tolerance), np.zeros(len(limit), bool)
    least = LEAST_TOLERANCE * slip_tolerance
    elastic = np.isfinite(shear_stiffness)
    of_mortar = np.divide(limit, shear_stiffness, out=np.zeros(len(limit)), where=elastic)
    return np.where(elastic, np.maximum(of_mortar, least), slip_tolerance), elastic & (of_mortar > least)

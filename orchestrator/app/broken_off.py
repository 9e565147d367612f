"""What a person is told of a pushover that broke off: where, what that means, and what may help."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from orchestrator.basis.errors import ConvergenceError
from orchestrator.basis.printed import as_lambda, as_place
from orchestrator.pushover.increments import Increment
from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings

if TYPE_CHECKING:
    from orchestrator.pushover.model import ContactModel

STIFF = 10.0
"""times the default from which the stones' modulus is named among what makes a pushover hard to follow"""
PHYSICAL = ("gravity",)
"""stages of complaints that say all themselves: no solver has failed"""


@dataclass(frozen=True, slots=True)
class SolverSettings:
    """What a solver may fail by."""

    elastic: ElasticSettings
    contact: ContactSettings
    newton: NewtonSettings
    large_displacement: bool


def located(
    model: str, error: ConvergenceError, last: Increment | None, contact_model: ContactModel, settings: SolverSettings
) -> ConvergenceError:
    """Return the error with the model, the last good increment, the place, and what may help in its text."""
    said = f"stopped {place(last)}: "
    if error.stage in PHYSICAL:
        pulled = contact_model.ties is not None and bool(contact_model.ties.pretension.any())
        tightened = "; its ties are tightened meanwhile (reinforcement.ties.pretension)" if pulled else ""
        return ConvergenceError(f"{model} FE", f"{said}{error}{tightened}", error.iterations)
    said += "no equilibrium is found for a next increment, however small, nor a motion that leads to one"
    if last is not None:
        said += f"; {_fastest(contact_model, last)} moves most; the curve is not valid"
    return ConvergenceError(f"{model} FE", f"{said}; try {_remedies(model, settings)} ({error})", error.iterations)


def place(last: Increment | None) -> str:
    """Return after which increment a pushover has stopped."""
    if last is None:
        return "before any increment"
    moved = f"{1e3 * last.control_displacement:.4g} mm, multiplier {as_lambda(last.load_multiplier)}"
    return f"after increment {last.number} ({last.phase}, {moved})"


def _fastest(contact_model: ContactModel, last: Increment) -> str:
    """Return the body that moves most in an increment, and where it lies."""
    meshes = contact_model.meshes
    body = int(meshes.body_of_node[np.linalg.norm(last.change[: len(meshes.nodes)], axis=1).argmax()])
    x, y = meshes.nodes[meshes.body_of_node == body, :2].mean(axis=0)
    return f"{contact_model.body_names[body]} at {as_place(x, y)} m"


def _remedies(model: str, settings: SolverSettings) -> str:
    """Return settings that may help: defaults instead of what is stricter, small displacements, the other model."""
    elastic, newton = ElasticSettings(), NewtonSettings()
    strict = []
    if settings.elastic.elastic_modulus > STIFF * elastic.elastic_modulus:
        strict.append(f"a smaller elastic.elastic_modulus (default {elastic.elastic_modulus / 1e9:g} GPa)")
    if settings.contact.slip_tolerance is not None:
        strict.append("contact.slip_tolerance left out, or larger")
    if settings.newton.residual < newton.residual:
        strict.append(f"a larger newton.residual (default {newton.residual:g})")
    if settings.newton.iterations < newton.iterations:
        strict.append(f"more newton.iterations (default {newton.iterations})")
    if settings.large_displacement:
        strict.append("stepping.large_displacement=false (small displacements)")
    return ", ".join([*strict, f"--model {'micro' if model == 'macro' else 'macro'}"])

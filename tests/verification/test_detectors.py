"""Test the detectors: a wrong program must turn the verification red.

Each mutation breaks the mechanics in one place; the closed form that guards it must notice.
"""

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.basis.errors import ConvergenceError
from orchestrator.pushover.contact.contact_law import friction_response
from orchestrator.pushover.solve import iterate
from tests.support.pushover_chain import model_of, run, stack
from tests.unit.pushover import test_linear_system
from tests.verification import test_nafems_cgs4, test_stacked_blocks


def wrong_friction(factor):
    def law(slip, force, friction, *rest):
        return friction_response(slip, force, factor * friction, *rest)

    return law


def test_friction_off_by_ten_percent_is_noticed(monkeypatch):
    monkeypatch.setattr(iterate, "friction_response", wrong_friction(1.1))
    with pytest.raises(AssertionError):
        test_stacked_blocks.test_block_slides_at_its_coefficient_of_friction(0.3, 1)
    with pytest.raises(AssertionError):
        test_nafems_cgs4.test_the_figure_nafems_prints()


def test_a_flipped_normal_is_noticed():
    """Contacts that pull instead of pushing: the block falls through its support."""
    model = model_of(stack((0.4, 0.6), friction=0.3))
    flipped = replace(model, normal_rows=-model.normal_rows)
    with pytest.raises((ConvergenceError, AssertionError)):
        assert run(flipped, final_displacement=1e-3).peak == pytest.approx(0.3, abs=1e-4)


def test_a_dropped_pressure_term_is_noticed(monkeypatch):
    """Without d tau / d lambda Newton still ends on the right state, more slowly: the matrix test sees it."""

    def law(*arguments):
        response = friction_response(*arguments)
        return replace(response, pressure_slope=np.zeros_like(response.pressure_slope))

    monkeypatch.setattr(iterate, "friction_response", law)
    with pytest.raises(AssertionError):
        test_linear_system.test_matrix_is_the_derivative_of_the_residual(None, None)

import numpy as np
import pytest

from orchestrator.pushover.contact.contact_law import friction_response

TOLERANCE = 1e-5


def response(slip, force, friction=0.5):
    return friction_response(np.array([slip]), np.array([force]), np.array([friction]), TOLERANCE, None)


def test_stick_is_elastic_up_to_the_tolerance():
    half = response([0.5 * TOLERANCE, 0.0], 100.0)
    assert not half.sliding[0]
    assert half.traction[0] == pytest.approx([25.0, 0.0])
    assert half.slip_stiffness[0] == pytest.approx(0.5 * 100.0 / TOLERANCE * np.eye(2))


def test_slip_keeps_coulombs_limit_in_the_direction_of_the_slip():
    slid = response([3 * TOLERANCE, 4 * TOLERANCE], 100.0)
    assert slid.sliding[0]
    assert slid.traction[0] == pytest.approx([30.0, 40.0])
    assert np.linalg.norm(slid.elastic_slip[0]) == pytest.approx(TOLERANCE)


def test_a_contact_in_tension_has_no_friction_and_the_slope_of_one_that_closes():
    pulled = response([3 * TOLERANCE, 0.0], -10.0)
    assert (pulled.traction == 0).all()
    assert (pulled.slip_stiffness == 0).all()
    assert (pulled.pressure_slope == response([3 * TOLERANCE, 0.0], 10.0).pressure_slope).all()


@pytest.mark.parametrize("slip", [[0.3, -0.4], [3.0, 1.0], [-0.2, 7.0]])
def test_tangents_are_the_derivatives_of_the_traction(slip):
    """Central differences; the exact tangent of a smooth branch leaves an error of the order of the step squared."""
    slip, force, step = np.array(slip) * TOLERANCE, 100.0, 1e-10
    exact = response(slip, force)
    for axis in range(2):
        shift = np.eye(2)[axis] * step
        slope = (response(slip + shift, force).traction - response(slip - shift, force).traction)[0] / (2 * step)
        assert exact.slip_stiffness[0][:, axis] == pytest.approx(slope, rel=1e-4, abs=1.0)
    slope = (response(slip, force + 1.0).traction - response(slip, force - 1.0).traction)[0] / 2.0
    assert exact.pressure_slope[0] == pytest.approx(slope, rel=1e-9)

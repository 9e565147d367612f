"""Rigid bodies in the plane and in space, by virtual work and by hand."""

import numpy as np
import pytest

from orchestrator.geometry.rigid import cross, polar_moment, velocity_of_points
from tests.support.walls import rectangle


@pytest.mark.parametrize(("dimensions", "freedoms"), [(2, 3), (3, 6)])
def test_power_of_a_force_is_that_of_its_resultant_and_moment(dimensions, freedoms):
    """f . v(r) = f . v + (r x f) . w: what ties equilibrium to kinematics."""
    rng = np.random.default_rng(3)
    velocities, arm, force = (
        rng.normal(size=(5, freedoms)),
        rng.normal(size=(5, dimensions)),
        rng.normal(size=(5, dimensions)),
    )
    at_point = np.sum(force * velocity_of_points(velocities, arm), axis=1)
    moment = cross(arm, force).reshape(5, -1)
    assert at_point == pytest.approx(np.sum(np.hstack([force, moment]) * velocities, axis=1), rel=1e-12)


def test_a_body_that_turns_counter_clockwise_moves_to_the_left_above_its_centroid():
    """At 2 rad/s a point 3 m above moves at 6 m/s along -x; one 3 m to the right moves up; in space about z alike."""
    assert velocity_of_points(np.array([1.0, 0.0, 2.0]), np.array([[0.0, 3.0], [3.0, 0.0]])).tolist() == [
        [-5, 0],
        [1, 6],
    ]
    about_z = velocity_of_points(np.array([1.0, 0.0, 0.0, 0.0, 0.0, 2.0]), np.array([[0.0, 3.0, 7.0]]))
    assert about_z.tolist() == [[-5, 0, 0]]


def test_polar_moment_of_a_rectangle():
    """b h (b^2 + h^2) / 12 about its centroid, and m d^2 more about another point."""
    centred = rectangle(-0.4, -0.1, 0.8, 0.2)
    expected = 0.8 * 0.2 * (0.8**2 + 0.2**2) / 12
    assert polar_moment(centred) == pytest.approx(expected, rel=1e-12)
    assert polar_moment(centred + [3.0, 4.0]) == pytest.approx(expected + 0.8 * 0.2 * 25.0, rel=1e-12)

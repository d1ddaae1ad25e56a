"""Manipulability and its gradient; the oracle is numerical differentiation."""

import numpy as np
import pytest

from bt_manip.kinematics import manipulability
from bt_manip.kinematics.manipulability import manipulability_gradient
from tests.measuring.kinematics import differentiate, refused


@pytest.mark.parametrize("jacobian", [3.0, np.zeros(6), np.zeros((0, 7)), np.full((6, 7), np.nan)])
def test_the_manipulability_is_that_of_a_matrix(jacobian):
    refused(lambda: manipulability(jacobian), "a Jacobian must be a matrix of finite numbers, got")


def test_the_manipulability_is_the_volume_and_its_gradient_is_its_derivative(model, rng):
    for _ in range(5):
        q = rng.uniform(model.limits.lower, model.limits.upper)
        jacobian = model.jacobian(q)
        volume = np.sqrt(np.linalg.det(jacobian @ jacobian.T))
        assert manipulability(jacobian) == pytest.approx(volume, rel=1e-9)
        expected = differentiate(lambda q: np.log(manipulability(model.jacobian(q))), q)
        assert manipulability_gradient(jacobian) == pytest.approx(expected, rel=1e-5, abs=1e-6)

"""References move within a step of an agent, within the limits of the joints."""

from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip_learn.agents.references import StepReference

STEPS, DT = 50, 1e-3
VELOCITY = np.array([1.0, 2.0])  # [rad/s]


def test_a_step_ends_at_its_target_or_as_far_as_the_velocity_limit_allows():
    limits = SimpleNamespace(lower=np.full(2, -2.0), upper=np.full(2, 2.0), velocity=VELOCITY)
    reference = StepReference(np.zeros(2), SimpleNamespace(limits=limits), STEPS, DT)
    reference.move_to(np.array([1.5, -0.05]), np.zeros(2))
    q, v = [], []
    for _ in range(STEPS):
        reference.advance(DT)
        q.append(reference.q.copy())
        v.append(reference.v.copy())
    assert q[-1] == pytest.approx([VELOCITY[0] * STEPS * DT, -0.05])
    np.testing.assert_allclose(np.gradient(np.array(q), DT, axis=0)[2:-2], v[2:-2], atol=5e-3)
    assert v[-1] == pytest.approx([VELOCITY[0], -1.5])  # the parabola through rest and target

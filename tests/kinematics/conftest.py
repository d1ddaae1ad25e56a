import pytest

from bt_manip.kinematics.compiled_problem import compile_problem


@pytest.fixture
def goal(model, rng):
    return rng.uniform(model.limits.lower + 0.1, model.limits.upper - 0.1)


@pytest.fixture
def compiled(model):
    """Give a function that compiles a problem for the arm at its home."""
    joints, inverse_speed = tuple(model.model.names)[1:], 1.0 / model.limits.velocity
    return lambda problem: compile_problem(model, joints, problem, model.home, inverse_speed)

import pytest


@pytest.fixture
def goal(model, rng):
    return rng.uniform(model.limits.lower + 0.1, model.limits.upper - 0.1)

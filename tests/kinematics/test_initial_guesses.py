"""Initial guesses: spread, and as many as are asked for."""

import numpy as np

from bt_manip.kinematics import IKProblem, PoseTarget, PositionTarget
from bt_manip.kinematics.initial_guesses import InitialGuesses


def test_initial_guesses_within_rounding_of_each_other_are_all_returned(model, compiled):
    span = model.limits.upper - model.limits.lower
    fixed = IKProblem(targets=PositionTarget("tool", np.ones(3)), margin=(0.5 - 1e-15) * span)
    assert len(list(InitialGuesses(model).spread(compiled(fixed), 400))) == 400


def test_initial_guesses_are_far_from_each_other(model, compiled, rng):
    guesses = InitialGuesses(model)
    T = model.pose(rng.uniform(model.limits.lower, model.limits.upper))
    problem = compiled(IKProblem(targets=PoseTarget("tool", T)))
    given = np.array(list(guesses.spread(problem, 90)))
    assert len(np.unique(given, axis=0)) == 90
    assert np.array_equal(given[0], guesses.nearest(problem, 1)[0])
    apart = [np.sqrt(((q - given[:i]) ** 2).mean(axis=1)).min() for i, q in enumerate(given) if i]
    assert min(apart[:5]) > 1.0 and min(apart) > 0.3

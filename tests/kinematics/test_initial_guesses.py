"""Initial guesses: spread, and as many as are asked for."""

import numpy as np
import pytest

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


@pytest.mark.parametrize("cone", [0.0, 0.4, None])
def test_guesses_for_a_free_axis_are_those_with_the_least_distance_and_tilt(model, compiled, cone):
    T, axis, pivot = model.pose(model.home), np.array([0.6, 0.0, 0.8]), np.array([0.1, 0.0, -0.2])
    free = {} if cone is None else {"free_axis": axis, "pivot": pivot, "cone": cone}
    target = PoseTarget("tool", T, **free)
    guesses = InitialGuesses(model)

    def residual(q):
        now = model.pose(q)
        tilt = np.arccos(np.clip((now.rotation @ axis) @ (T.rotation @ axis), -1.0, 1.0))
        offset = now.act(pivot) - T.act(pivot)
        if cone is None:
            offset, turn = now.translation - T.translation, T.rotation.T @ now.rotation
            return offset @ offset + 0.25 * (3.0 - np.trace(turn))
        return offset @ offset + np.sin(max(tilt - cone, 0.0) / 2.0) ** 2

    best = sorted(map(residual, guesses.stored))[:20]
    chosen = guesses.nearest(compiled(IKProblem(targets=target)), 20)
    assert [residual(q) for q in chosen] == pytest.approx(best, abs=1e-9)
    everything = guesses.nearest(compiled(IKProblem(targets=target, margin=0.5)), 3000)
    assert len(everything) == len(guesses.stored) and model.limits.contain(everything, -0.5)

"""Trees are environments of dm_env, with the same observations and actions."""

import dm_env
import numpy as np

from bt_manip_learn.envs import DmEnvironment


def test_steps_match_the_specs_and_end_at_the_time_limit(parts):
    env = DmEnvironment("pick_place", action="cartesian_deltas", time_limit=0.2, parts=parts)
    step, spec = env.reset(), env.action_spec()
    assert step.first() and env.task.episodes.episode == 0
    action = spec.generate_value()
    for _ in range(4):
        step = env.step(action)
        for name, one in env.observation_spec().items():
            one.validate(step.observation[name])
    assert step.step_type is dm_env.StepType.LAST and step.discount == 1.0
    assert env.step(action).first()
    assert env.task.episodes.episode == 1


def test_choices_are_discrete_and_an_episode_ends_after_a_minute_by_default(parts):
    env = DmEnvironment("pick_place", action="subtree_choice", parts=parts)
    env.reset()
    assert env.action_spec().num_values > 5
    env.task.episodes.steps = 1198  # of 1200 steps of 50 ms: by default 60 s
    assert env.step(np.int64(0)).mid()
    step = env.step(np.int64(0))
    assert step.last() and step.discount == 1.0

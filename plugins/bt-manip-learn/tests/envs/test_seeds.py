"""A reset is a function of its seed, whatever was before it."""

from dataclasses import replace

import gymnasium
import mujoco
import numpy as np
import pytest
from dm_control.composer.variation import distributions, noises

import bt_manip_learn.envs  # noqa: F401 (registers the ids)
from bt_manip.cell.randomization import Randomization
from bt_manip.plugins import load_plugins
from bt_manip_learn.envs import LearningTask
from bt_manip_learn.envs.vector_env import BatchEnvironment

TREE = """\
<root BTCPP_format="4">
  <BehaviorTree ID="Look" _goal="IsHolding robot={0} object={1}">
    <Sequence><Hover robot="{0}" object="{1}" height="0.3"/></Sequence>
  </BehaviorTree>
</root>
"""

IDLE = """\
<root BTCPP_format="4">
  <BehaviorTree ID="Idle" _goal="ObjectExists object=nothing"><AlwaysSuccess/></BehaviorTree>
</root>
"""

SCENES = [
    pytest.param(scene, marks=() if scene == "varied_pick" else pytest.mark.soak)
    for scene in load_plugins().parts.scenes
]

QUANTITIES = {
    "mass": distributions.Uniform(0.05, 1.0),
    "friction": distributions.Uniform(0.2, 1.0),
    "yaw": distributions.Uniform(-1.0, 1.0),
    "colour": distributions.Uniform((0.0,) * 3, (1.0,) * 3),
    "position": noises.Additive(distributions.Uniform((-0.02, -0.02, -5e-4), (0.02, 0.02, -4e-4))),
}
"""Variations of an object that lies half a millimetre deep in the table: contact from the start."""


def first_observation(task, seed):
    """Return what is observed after a reset, and the state of the physics."""
    task.reset(seed)
    observed = {name: values.tobytes() for name, values in task.observe().items()}
    return observed | {"physics": task.episodes.station.cell.state_bytes()}


@pytest.mark.parametrize(
    ("scene", "robot", "name"),
    [
        ("peg_in_hole", "arm", "peg"),
        pytest.param("hand_over", "left", "rod", marks=pytest.mark.soak),
    ],
)
def test_the_first_observation_is_a_function_of_the_seed(parts, tmp_path, scene, robot, name):
    """The tree moves in its first tick: nothing is simulated before."""
    tree = tmp_path / "look.xml"
    tree.write_text(TREE.format(robot, name))
    random = Randomization(objects={name: QUANTITIES})
    varied = replace(parts.scenes.create(scene), randomization=random)
    parts = replace(parts, scenes=parts.scenes.with_part("varied", lambda: varied))
    task, other = (LearningTask(str(tree), parts=parts, scene="varied", seed=s) for s in (0, 8))
    check_first_observation(task, other)
    cell, wrench = task.episodes.station.cell, f"{name}_contact_wrench"
    first = task.observe()[wrench]
    mujoco.mj_forward(cell.model, cell.data)  # with the sampled mass
    np.testing.assert_array_equal(task.observe()[wrench], first)
    assert first[2] > 0.0


@pytest.mark.parametrize("scene", SCENES)
def test_the_first_observation_in_a_registered_scene_is_a_function_of_the_seed(
    parts, tmp_path, scene
):
    path = tmp_path / "idle.xml"
    path.write_text(IDLE)
    task, other = (LearningTask(str(path), parts=parts, scene=scene, seed=seed) for seed in (0, 8))
    check_first_observation(task, other)


def check_first_observation(task, other):
    """Compare it in a task, after other episodes, and in another one."""
    expected = first_observation(task, 3)
    task.reset(85, 1)
    task.step(task.action.space.low)
    found = first_observation(task, 3), first_observation(other, 3)
    for name, values in expected.items():
        assert found[0][name] == values, f"'{name}' depends on the episodes before"
        assert found[1][name] == values, f"'{name}' depends on the seed of the environment"


def test_the_seed_of_make_is_that_of_its_episodes_which_are_numbered():
    env = gymnasium.make("bt_manip/PickPlace-v0", seed=3, disable_env_checker=True)
    first, second = env.reset(), env.reset()
    for number, (observation, info) in enumerate((first, second)):
        assert (info["seed"], info["episode_number"]) == (3, number)
        env.reset(seed=4)
        again, _ = env.reset(seed=3, options={"episode": number})
        assert all(np.array_equal(observation[name], again[name]) for name in again)
    batch = BatchEnvironment("pick_place", 2, seed=3)
    assert batch.reset()[1]["seed"].tolist() == [3, 4]

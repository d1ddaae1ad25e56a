"""Gymnasium's own wrappers and vector environments take the environments as they are."""

import copy
import pickle

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces, wrappers

import bt_manip_learn.envs  # noqa: F401 (registers the environments)
from bt_manip.exceptions import BtManipError
from bt_manip_learn.agents import Images
from bt_manip_learn.envs.gymnasium_env import GymnasiumEnvironment

ID = "bt_manip/PickPlace-v0"

pytestmark = pytest.mark.filterwarnings("ignore:.*WARN.*:UserWarning")


def make(**options):
    return gymnasium.make(ID, max_episode_steps=3, **options)


@pytest.fixture(scope="module")
def env():
    made = make()
    yield made
    made.close()


@pytest.mark.parametrize(
    "wrap",
    [
        wrappers.FlattenObservation,
        wrappers.NormalizeReward,
        wrappers.TimeAwareObservation,
        lambda env: wrappers.FilterObservation(env, ["cube_position", "robot_joint_positions"]),
        lambda env: wrappers.FrameStackObservation(wrappers.FlattenObservation(env), 2),
        lambda env: wrappers.NormalizeObservation(wrappers.FlattenObservation(env)),
        lambda env: wrappers.RescaleAction(env, -0.5, 0.5),
        wrappers.ClipAction,
        wrappers.Autoreset,
    ],
)
def test_wrappers_give_what_their_spaces_promise(env, wrap):
    wrapped = wrap(env)
    observation, _ = wrapped.reset(seed=0)
    for _ in range(2):
        assert wrapped.observation_space.contains(observation)
        observation, *_ = wrapped.step(wrapped.action_space.sample())


def test_info_has_no_key_of_gymnasiums_own(env):
    _, info = env.reset(seed=0)
    *_, after = env.step(env.action_space.sample())
    reserved = {"episode", "final_obs", "final_info", "terminal_observation", "_final_obs"}
    assert not reserved & {*info, *after}
    assert info["is_success"] is False and info["failure"] == ""


def test_actions_are_scaled_to_one_unless_physical_units_are_asked_for():
    scaled, physical = make(), make(physical_units=True)
    assert (scaled.action_space.low == -1).all() and (scaled.action_space.high == 1).all()
    space = physical.unwrapped.task.action.space
    np.testing.assert_array_equal(physical.action_space.high, space.high)
    q = np.append(physical.unwrapped.task.episodes.station.robot.q, 1.0)
    for env, action in ((scaled, space.normalized(q + 0.01)), (physical, q + 0.01)):
        env.reset(seed=0)
        env.step(action.astype(np.float32))
    found = [one.unwrapped.task.episodes.station.robot.q for one in (scaled, physical)]
    np.testing.assert_allclose(*found, atol=1e-6)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"rewards": "dense"}, "an environment has no option 'rewards'; did you mean 'reward'"),
        ({"frameskip": 1}, "unexpected keyword argument 'frameskip'"),  # TorchRL
        ({"render_mod": "rgb_array"}, "no option 'render_mod'; did you mean 'render_mode'"),
        ({"goal_conditioned": True, "images": {}}, "leave out 'images' and 'reward'"),
        ({"goal_conditioned": True, "reward": "dense"}, "leave out 'images' and 'reward'"),
        ({"reward": "shaped", "discount": 1.5}, "the discount is from 0 to 1, got 1.5"),
        ({"reward": "dense", "discount": 0.9}, "'shaped', and has no effect on 'dense'"),
        ({"images": {"kinds": ("rbg",)}}, "no images are called 'rbg'; did you mean 'rgb'"),
        ({"images": {"camera": ("overview",)}}, "images have no option 'camera'; .* 'cameras'"),
        ({"images": {"cameras": ("overvew",)}}, "no camera 'overvew'; did you mean 'overview'"),
        ({"images": {"kinds": (), "cameras": ("overvew",)}}, "no camera 'overvew'"),
    ],
)
def test_options_that_are_unknown_or_do_not_go_together_are_refused(options, message):
    with pytest.raises(BtManipError, match=message) as error:
        GymnasiumEnvironment("pick_place", **options)
    assert isinstance(error.value, TypeError) == (" option " in str(error.value))  # as libraries do


def test_an_action_of_another_size_and_a_misspelt_option_of_reset_are_refused(env):
    env.reset(seed=0)
    with pytest.raises(BtManipError, match="8 finite numbers"):
        env.unwrapped.step(np.zeros(1))
    with pytest.raises(BtManipError, match="reset has no option 'episodes'; .* 'episode'"):
        env.reset(options={"episodes": 3})


def test_images_have_bounds_by_their_kind_and_are_in_colour_by_default(opengl):
    assert Images(cameras=("overview",)) == (("rgb",), ("overview",), 128, 128)
    images = {"kinds": ("rgb", "depth", "segmentation"), "width": 16, "height": 8}
    options = {"images": images, "render_mode": "rgb_array", "step_time": 0.1}
    env = GymnasiumEnvironment("pick_place", **options)
    last, boxes = len(env.task.episodes.station.cell.entities), env.observation_space
    assert boxes["overview_rgb"] == spaces.Box(0, 255, (8, 16, 3), np.uint8)
    assert boxes["overview_depth"] == spaces.Box(0.0, np.inf, (8, 16), np.float32)
    assert boxes["overview_segmentation"] == spaces.Box(0, last, (8, 16), np.int32)
    assert env.render().shape == (480, 640, 3)
    assert (env.metadata["render_fps"], GymnasiumEnvironment.metadata["render_fps"]) == (10, 20)
    env.close()


def test_ids_exist_for_trees_that_need_no_arguments_only():
    ids = [one for one in gymnasium.registry if one.startswith("bt_manip/")]
    assert ID in ids
    assert "bt_manip/PickPlacePolicy-v0" not in ids  # the file of the policy has no default


def test_a_copy_continues_the_episode_and_those_after_it():
    env = make()
    env.reset(seed=4)
    env.action_space.seed(4)
    env.step(env.action_space.sample())
    other = pickle.loads(pickle.dumps(env))
    for _ in range(2):
        action = env.action_space.sample()
        assert (other.action_space.sample() == action).all()
        (a, *rest), (b, *others) = env.step(action), other.step(action)
        assert rest == others and all(np.array_equal(a[name], b[name]) for name in a)
    assert rest[2]  # truncated: the wrapper's count of steps is copied too
    assert env.reset()[1] == other.reset()[1]


def test_an_environment_that_records_says_why_it_cannot_be_copied(tmp_path):
    env = GymnasiumEnvironment("pick_place", record=str(tmp_path / "run.mcap"))
    with pytest.raises(BtManipError, match="would write the same files"):
        copy.deepcopy(env)


def test_known_bounds_are_declared_and_kept():
    env = gymnasium.make(ID, disable_env_checker=True)
    space, limits = env.observation_space, env.unwrapped.task.episodes.station.arm.model.limits
    bounds = {  # a little beyond those of the physics
        "robot_joint_positions": (limits.lower - 0.1, limits.upper + 0.1),
        "robot_gripper_opening": (-0.1, 1.1),
        "cube_rotation": (-1.001, 1.001),
        "cube_position": (-np.inf, np.inf),
    }
    for name, (low, high) in bounds.items():
        np.testing.assert_allclose(space[name].low, np.broadcast_to(low, space[name].shape), 1e-6)
        np.testing.assert_allclose(space[name].high, np.broadcast_to(high, space[name].shape), 1e-6)
    observation, _ = env.reset(seed=0)
    for _ in range(20):
        assert space.contains(observation)
        observation, *_ = env.step(np.sign(env.action_space.sample()))

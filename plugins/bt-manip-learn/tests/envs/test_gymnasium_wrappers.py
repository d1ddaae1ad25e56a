"""Gymnasium's own wrappers and vector environments take the environments as they are."""

import copy
import pickle

import gymnasium
import numpy as np
import pytest
from gymnasium import wrappers

import bt_manip_learn.envs  # noqa: F401 (registers the environments)
from bt_manip.cell import extent
from bt_manip.exceptions import BtManipError
from bt_manip.spatial import pose
from bt_manip_learn.envs import LearningTask
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


def run(env, steps=7):
    """Make steps over the ends of episodes; return the last infos of the episodes."""
    env.reset(seed=0)
    env.action_space.seed(0)
    infos = []
    for _ in range(steps):
        *_, terminated, truncated, info = env.step(env.action_space.sample())
        if terminated or truncated:
            infos.append(info)
            env.reset()
    return infos


def test_statistics_of_episodes_are_recorded(env):
    infos = run(wrappers.RecordEpisodeStatistics(env))
    assert [(one["episode"]["l"], one["episode_number"]) for one in infos] == [(3, 0), (3, 1)]


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


# Actions


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


def test_an_action_of_another_size_is_refused(env):
    env.reset(seed=0)
    with pytest.raises(BtManipError, match="8 finite numbers"):
        env.unwrapped.step(np.zeros(1))


# Options


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"rewards": "dense"}, "an environment has no option 'rewards'; did you mean 'reward'"),
        ({"render_mod": "rgb_array"}, "no option 'render_mod'; did you mean 'render_mode'"),
        ({"images": {"camera": ("overview",)}}, "images have no option 'camera'; .* 'cameras'"),
        ({"images": {"cameras": ("overvew",)}}, "no camera 'overvew'; did you mean 'overview'"),
        ({"images": {"kinds": (), "cameras": ("overvew",)}}, "no camera 'overvew'"),
    ],
)
def test_a_misspelt_option_is_named(options, message):
    with pytest.raises(BtManipError, match=message):
        GymnasiumEnvironment("pick_place", **options)


def test_a_misspelt_option_of_reset_is_named(env):
    with pytest.raises(BtManipError, match="reset has no option 'episodes'; .* 'episode'"):
        env.reset(options={"episodes": 3})


def test_images_without_kinds_are_in_colour(opengl):
    env = GymnasiumEnvironment("pick_place", images={"cameras": ("overview",), "width": 64})
    assert env.observation_space["overview_rgb"].shape == (128, 64, 3)
    env.close()


def test_ids_exist_for_trees_that_need_no_arguments_only():
    ids = [one for one in gymnasium.registry if one.startswith("bt_manip/")]
    assert ID in ids
    assert "bt_manip/PickPlacePolicy-v0" not in ids  # the file of the policy has no default


# Copies


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


# Goals


def test_relabelled_goals_are_positions_of_the_object():
    env = GymnasiumEnvironment("pick_place", goal_conditioned=True)
    observation, _ = env.reset(seed=0)
    assert set(observation) == {"observation", "achieved_goal", "desired_goal"}
    assert env.observation_space.contains(observation)
    cell = env.task.episodes.station.cell
    achieved, desired = observation["achieved_goal"], observation["desired_goal"]
    np.testing.assert_allclose(achieved[:3], cell.pose("cube").translation, atol=1e-7)
    basket = np.mean(extent(cell, "basket"), axis=0)
    np.testing.assert_allclose(desired, [*basket, 1.0], atol=1e-6)
    near, beside = achieved + [[0.049, -0.049, 0.049, 0.0], [0.0, -0.051, 0.0, 0.0]]
    found = np.stack([near, beside, [*desired[:3], 0.0], desired])
    assert env.compute_reward(found, np.stack([achieved] * 4), [{}] * 4).tolist() == [0, -1, -1, -1]
    assert env.compute_reward(found, np.stack([desired] * 4), [{}] * 4).tolist() == [-1, -1, -1, 0]
    after, reward, *_, info = env.step(np.zeros(env.action_space.shape, np.float32))
    assert reward == env.compute_reward(after["achieved_goal"], after["desired_goal"], info) == -1.0


def steps_of_the_expert(env, seed, disturbed):
    """Yield the goals after each step; disturbed: the object is put elsewhere now and then."""
    observation, _ = env.reset(seed=seed)
    task, rng = env.task, np.random.default_rng(seed)
    cell = task.episodes.station.cell
    goal = task.episodes.run.tree.goal[0]
    name, destination = goal.object, getattr(goal, goal.destination)
    for _ in range(1200):
        yield env.result(task.expert_step())[0]
        if task.episodes.ended:
            return
        if disturbed and rng.random() < 0.1 and name in cell.entities:
            place = cell.pose(destination).translation + rng.uniform(-0.15, 0.15, 3)
            cell.move(name, pose(place + [0, 0, 0.15]), overlap=1.0)


QUICK = [("pick_place", False), ("pick_place_cluttered", True)]
"""Undisturbed, pick_place_cluttered is in test_takeover.py."""

TREES = [
    pytest.param(tree, disturbed, marks=() if (tree, disturbed) in QUICK else pytest.mark.soak)
    for tree in (one.kwargs["tree"] for one in gymnasium.registry.values() if "tree" in one.kwargs)
    if not tree.endswith("_seen")  # the expert of these needs cameras
    for disturbed in (False, True)
]


@pytest.mark.parametrize(("tree", "disturbed"), TREES)
def test_a_goal_is_reached_if_and_only_if_that_of_the_tree_holds(tree, disturbed):
    goal = LearningTask(tree).episodes.run.tree.goal
    if not all(getattr(one, "destination", "") for one in goal):
        with pytest.raises(BtManipError, match="not a position"):
            GymnasiumEnvironment(tree, goal_conditioned=True)
        return
    env = GymnasiumEnvironment(tree, goal_conditioned=True)
    reached = []
    for goals in steps_of_the_expert(env, 1, disturbed):
        reward = env.compute_reward(goals["achieved_goal"], goals["desired_goal"], {})
        reached.append(reward == 0.0)
        assert reached[-1] == (not env.task.episodes.run.goal.why_not())
    assert disturbed or reached.count(True) == 1 and reached[-1]
    env.close()


@pytest.mark.parametrize("wrong", [{"images": {}}, {"reward": "dense"}])
def test_goals_do_not_go_with_images_or_another_reward(wrong):
    with pytest.raises(BtManipError, match="leave out 'images' and 'reward'"):
        GymnasiumEnvironment("pick_place", goal_conditioned=True, **wrong)


def test_a_goal_that_is_no_position_is_refused():
    pytest.importorskip("bt_manip_impedance", reason="the plugin is not installed")
    with pytest.raises(BtManipError, match="not a position: 'IsOpen'"):
        GymnasiumEnvironment("open_drawer", goal_conditioned=True)


def test_an_unknown_option_is_a_type_error_as_libraries_expect():
    with pytest.raises(TypeError, match="unexpected keyword argument 'frameskip'"):  # TorchRL
        gymnasium.make(ID, frameskip=1)


def test_known_bounds_are_declared_and_kept():
    env = gymnasium.make(ID, disable_env_checker=True)
    space, limits = env.observation_space, env.unwrapped.task.episodes.station.arm.model.limits
    joints = space["robot_joint_positions"]
    assert (joints.low < limits.lower).all() and (limits.upper < joints.high).all()
    assert joints.is_bounded() and space["cube_rotation"].is_bounded()
    opening = space["robot_gripper_opening"]  # a share, up to a tenth beyond its ends
    assert -0.1 <= opening.low[0] < 0.0 and 1.0 < opening.high[0] <= 1.1 + 1e-6
    observation, _ = env.reset(seed=0)
    for _ in range(20):
        assert space.contains(observation)
        observation, *_ = env.step(np.sign(env.action_space.sample()))
    env.close()

"""A batch of environments (`bt_manip_learn.envs.batch`) has the bits of single ones."""

import json

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence

from bt_manip.exceptions import BtManipError
from bt_manip_learn.agents import Images
from bt_manip_learn.envs import gymnasium_env
from bt_manip_learn.envs.gymnasium_env import GymnasiumEnvironment
from bt_manip_learn.envs.vector_env import BatchEnvironment

ID = "bt_manip/PickPlace-v0"
COMMON = {"reward": "dense", "controller": "native_pd"}


def make_batch(n, name=ID, **options):
    options = {**COMMON, **options}
    return gymnasium.make_vec(name, num_envs=n, vectorization_mode="vector_entry_point", **options)


@pytest.fixture(scope="module")
def pair():
    """Two environments, which tests reset."""
    batch = make_batch(2)
    yield batch
    batch.close()


def assert_same_bits(
    steps, n=8, action="joint_targets", mode="NextStep", limit=20, name=ID, **options
):
    """Compare a batch with `SyncVectorEnv`, which steps single environments."""
    mode = gymnasium.vector.AutoresetMode(mode)
    batch = make_batch(
        n, name, action=action, max_episode_steps=limit, autoreset_mode=mode, **options
    )
    singles = gymnasium.make_vec(
        name, num_envs=n, vectorization_mode="sync", action=action, max_episode_steps=limit,
        vector_kwargs={"autoreset_mode": mode}, disable_env_checker=True, **COMMON,
    )  # fmt: skip
    try:
        assert data_equivalence(batch.reset(seed=5), singles.reset(seed=5), exact=True)
        rng, ends = np.random.default_rng(1), 0
        for _ in range(steps):
            actions = rng.uniform(-1.0, 1.0, batch.action_space.shape).astype(np.float32)
            found, expected = batch.step(actions), singles.step(actions)
            assert data_equivalence(found, expected, exact=True), (found, expected)
            ends += int(found[2].sum() + found[3].sum())
        return ends
    finally:
        batch.close()
        singles.close()


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_a_batch_has_the_bits_of_single_environments_over_resets(mode):
    assert assert_same_bits(7, n=2, limit=3, mode=mode) >= 4


RESULTS = """\
<root BTCPP_format="4">
  <BehaviorTree ID="T" _goal="IsIn object={cube} container=basket" _results="cube half unwritten">
    <Sequence>
      <Script code="half := 0.5"/><SpawnObject name_hint="part" object="{cube}"/><MoveHome/>
    </Sequence>
  </BehaviorTree>
</root>
"""


def test_results_of_the_tree_are_in_the_info_of_each_environment(tmp_path):
    tree = tmp_path / "counted.xml"
    tree.write_text(RESULTS)
    single, batch = GymnasiumEnvironment(str(tree)), BatchEnvironment(str(tree), 2)
    _, info = single.reset(seed=5)
    assert info["results"] == {"cube": "part", "half": 0.5}
    _, infos = batch.reset(seed=5)
    for _ in range(2):
        assert infos["results"]["half"].tolist() == [0.5, 0.5]
        assert infos["results"]["cube"].tolist() == ["part", "part"]
        *_, infos = batch.step(batch.action_space.sample())
    *_, info = single.step(single.action_space.sample())
    assert info["results"] == {"cube": "part", "half": 0.5}


@pytest.mark.soak
@pytest.mark.parametrize("action", ["joint_targets", "cartesian_deltas"])
@pytest.mark.parametrize("threads", [1, 2])
def test_eight_environments_have_the_bits_of_single_ones_over_500_steps(action, threads):
    assert assert_same_bits(500, action=action, limit=60, threads=threads) >= 64
    assert assert_same_bits(100, n=2, limit=25, name="bt_manip/TwoArms-v0") >= 6


def test_a_mask_resets_some_environments_and_leaves_the_others():
    batch = make_batch(2, autoreset_mode="Disabled", max_episode_steps=2)
    first, _ = batch.reset(seed=3)
    still = np.zeros(batch.action_space.shape, np.float32)
    batch.step(still)
    before, *_, truncated, _ = batch.step(still)
    assert truncated.all()
    with pytest.raises(BtManipError, match="reset it with 'reset_mask'"):
        batch.step(still)
    mask = np.array([True, False])
    after, info = batch.reset(seed=[3, None], options={"reset_mask": mask})
    for name in first:
        assert after[name][0].tobytes() == first[name][0].tobytes()
        assert after[name][1].tobytes() == before[name][1].tobytes()
    assert info["_seed"].tolist() == [True, False]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"action": "joint_torques"}, "'joint_torques' act between control steps"),
        ({"action": "subtree_choice"}, "'subtree_choice' act between control steps"),
        ({"controller": "computed_torque"}, "'computed_torque' is not 'native_pd'"),
        ({"record": "run.mcap"}, "act in control steps"),
        ({"num_envs": 0}, "at least one environment"),
        ({"reward": "thick"}, "a reward is sparse or dense"),
    ],
)
def test_tasks_that_cannot_be_batched_are_refused_with_the_reason(options, message):
    options = {"n": options.pop("num_envs", 2), **options}
    with pytest.raises(BtManipError, match=message):
        make_batch(**options)


def test_objects_that_act_goals_that_remember_and_models_that_change_are_refused():
    with pytest.raises(BtManipError, match="'button' acts in control steps"):
        BatchEnvironment("pick_place", num_envs=2, scene="button_on_table")
    with pytest.raises(BtManipError, match="'WasPressed' of the goal has a memory"):
        BatchEnvironment("press_button", num_envs=2)
    batch = BatchEnvironment("open_drawer", num_envs=2)
    with pytest.raises(BtManipError, match="episodes in a batch share one model"):
        batch.reset(seed=0)


def test_an_action_that_is_not_finite_is_refused_before_anything_moves(pair):
    actions = np.zeros(pair.action_space.shape, np.float32)
    pair.reset(seed=0)
    expected, *_ = pair.step(actions)
    pair.reset(seed=0)
    actions[1, 0] = np.nan
    with pytest.raises(BtManipError, match="action of environment 1"):
        pair.step(actions)
    after, *_ = pair.step(np.zeros_like(actions))
    assert data_equivalence(after, expected, exact=True)


def test_an_environment_whose_physics_diverge_ends_and_the_others_go_on(pair):
    still = np.zeros(pair.action_space.shape, np.float32)
    pair.reset(seed=0)
    pair.step(still)
    expected, *_ = pair.step(still)
    pair.reset(seed=0)
    before, *_ = pair.step(still)
    pair.simulations[1].bind("qvel")[0] = 1e12
    after, _, ends, _, info = pair.step(still)
    assert ends.tolist() == [False, True]
    assert info["failure"][1].startswith("MuJoCo warned at ")
    for name in before:
        assert after[name][0].tobytes() == expected[name][0].tobytes()
        assert after[name][1].tobytes() == before[name][1].tobytes()  # the last ones before
    started, *_, info = pair.step(still)
    assert info["episode_number"].tolist() == [0, 1]
    assert np.isfinite(started["cube_position"]).all()


def test_a_batch_goes_on_from_states_of_single_environments():
    options = {"max_episode_steps": 50, "autoreset_mode": "Disabled"}
    batch, single = make_batch(2, **options), GymnasiumEnvironment("pick_place", **COMMON)
    single.reset(seed=4)
    rng = np.random.default_rng(0)
    actions = rng.uniform(-0.3, 0.3, (8, *single.action_space.shape)).astype(np.float32)
    for action in actions[:4]:
        single.step(action)
    batch.reset(seed=0)
    mask, state = np.array([False, True]), json.loads(json.dumps(single.get_state()))
    observed, info = batch.reset(options={"reset_mask": mask, "state": state})
    assert info["seed"][1] == 4
    for action in actions[4:]:
        observed, rewards, *_ = batch.step(np.stack([np.zeros_like(action), action]))
        expected, reward, *_ = single.step(action)
        assert rewards[1] == reward
        for name, values in expected.items():
            assert observed[name][1].tobytes() == values.tobytes(), name


def test_a_batch_has_what_clients_ask_of_a_vector_environment():
    batch = make_batch(3, autoreset_mode="SameStep")
    assert batch.unwrapped.autoreset_mode is gymnasium.vector.AutoresetMode.SAME_STEP
    assert batch.get_attr("render_mode") == (None,) * 3  # also before the first reset
    batch.reset(seed=[3, 8, 4])
    assert batch.render() == (None,) * 3
    batch.step(np.zeros(batch.action_space.shape, np.float32))
    assert batch.get_attr("np_random_seed") == (3, 8, 4)  # of each environment
    assert batch.call("has_wrapper_attr", "task") == (True,) * 3
    batch.set_attr("mark", [[7], [7], [7]])
    assert batch.get_attr("mark") == ([7], [7], [7])
    for wrong in ([1, 1, 2], [1, 1], []):
        with pytest.raises(BtManipError, match="share 'mark': set one value"):
            batch.set_attr("mark", wrong)
    with pytest.raises(BtManipError, match="'step' is not possible in single environments"):
        batch.call("step", None)


def test_an_image_of_each_environment_is_rendered_and_no_image_observed(opengl, monkeypatch):
    with pytest.raises(BtManipError, match="images are rendered one by one"):
        make_batch(2, images={"kinds": ["depth"], "width": 8, "height": 8})
    monkeypatch.setattr(gymnasium_env, "RENDERED", Images(width=64, height=48))
    batch = make_batch(2, render_mode="rgb_array")
    batch.reset(seed=[3, 8])
    first, second = batch.render()
    assert first.shape == second.shape and (first != second).any()
    batch.close()

"""robomimic clones behaviour from our file, and rolls the policy out in our environment."""

import json
import subprocess
import sys

import h5py
import numpy as np
import pytest

pytest.importorskip("robomimic", reason="robomimic is not installed")

import robomimic.utils.file_utils as file_utils  # noqa: E402
import robomimic.utils.obs_utils as obs_utils  # noqa: E402
import robomimic.utils.train_utils as train_utils  # noqa: E402
import torch  # noqa: E402
from robomimic.algo import RolloutPolicy, algo_factory  # noqa: E402
from robomimic.config import config_factory  # noqa: E402
from robomimic.envs.env_base import EnvType  # noqa: E402

from bt_manip_learn.envs.robomimic_env import RobomimicEnvironment  # noqa: E402

DEMONSTRATIONS = 15
EPOCHS = 20
ROLLOUTS = 2
HORIZON = 150
OBSERVED = (
    "robot_joint_positions", "robot_tool_position", "robot_tool_rotation",
    "robot_gripper_opening", "robot_gripper_forces", "cube_position", "cube_rotation",
    "basket_position",
)  # fmt: skip


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return export(tmp_path_factory.mktemp("robomimic"), DEMONSTRATIONS)


def export(folder, episodes, *options):
    """Record and export demonstrations by the commands."""
    command = [sys.executable, "-m", "bt_manip", "demos"]
    demos = ["pick_place", "--episodes", str(episodes), "--seed", "1000", "--to", "demos", *options]
    words = ["export", "demos", "--format", "robomimic", "-o", "demos.hdf5"]
    for given in (demos, [*words, "--actions", "cartesian_deltas"]):
        subprocess.run([*command, *given], cwd=folder, check=True, capture_output=True)
    return folder / "demos.hdf5"


def configuration(path, epochs):
    config = config_factory("bc")
    with config.values_unlocked():
        config.train.data = str(path)
        config.train.hdf5_filter_key = "train"
        config.train.num_epochs = epochs
        config.train.batch_size = 128
        config.train.seed = 0
        config.observation.modalities.obs.low_dim = list(OBSERVED)
        config.algo.actor_layer_dims = (256, 256)
        config.algo.optim_params.policy.learning_rate.initial = 1e-3
    obs_utils.initialize_obs_utils_with_config(config)
    return config


def clone(path, epochs):
    """Return a policy that robomimic trained, and the losses of its epochs."""
    torch.manual_seed(0)
    np.random.seed(0)
    config = configuration(path, epochs)
    shapes = file_utils.get_shape_metadata_from_dataset(str(path), all_obs_keys=list(OBSERVED))
    model = algo_factory(
        "bc", config, shapes["all_shapes"], shapes["ac_dim"], device=torch.device("cpu")
    )
    data, _ = train_utils.load_data_for_training(config, obs_keys=list(OBSERVED))
    loader = torch.utils.data.DataLoader(data, batch_size=128, shuffle=True)
    losses = []
    for epoch in range(1, epochs + 1):
        log = train_utils.run_epoch(model, loader, epoch)
        losses.append(log["Loss"])
    return RolloutPolicy(model), losses


def test_it_clones_behaviour_and_rolls_the_policy_out(file):
    policy, losses = clone(file, EPOCHS)
    assert losses[-1] < 0.35 * losses[0]
    env = RobomimicEnvironment.from_file(file)
    env.seed(0)
    logs, _ = train_utils.rollout_with_stats(
        policy, {env.name: env}, HORIZON, num_episodes=ROLLOUTS, terminate_on_success=True
    )
    result = logs[env.name]
    assert 0.0 <= result["Success_Rate"] <= 1.0 and 0 < result["Horizon"] <= HORIZON


def test_recorded_actions_succeed_in_the_environment_of_the_file(file):
    env = RobomimicEnvironment.from_file(file)
    assert env.type == file_utils.get_env_metadata_from_dataset(str(file))["type"]
    assert env.type == EnvType.GYM_TYPE
    env.seed(1000)
    with h5py.File(file) as data:
        demo = next(one for one in data["data"].values() if one.attrs["episode"] == 0)
        actions, first = demo["actions"][()], demo["obs/cube_position"][0]
    np.testing.assert_allclose(env.reset()["cube_position"], first)
    assert np.abs(actions).max() <= 1.0
    for action in [*actions, *[actions[-1] * 0 + actions[-1][-1] * np.eye(7)[-1]] * 20]:
        env.step(action)
        if env.is_success()["task"]:
            break
    assert env.is_success()["task"] and env.is_done()
    again = json.loads(json.dumps(env.serialize()))
    assert again["env_kwargs"]["tree"] == "pick_place"


def test_its_dataset_gives_the_recorded_sequences(file):
    from robomimic.utils.dataset import SequenceDataset

    configuration(file, 1)
    keys = ("actions", "rewards", "dones", "leaf")
    with h5py.File(file, swmr=True) as found:  # as robomimic opens it
        total, actions = found["data"].attrs["total"], found["data/demo_0/actions"][:2]
    data = SequenceDataset(str(file), obs_keys=OBSERVED[:1], dataset_keys=keys, seq_length=2)
    assert len(data) == total
    np.testing.assert_allclose(data[0]["actions"], actions)


def test_images_of_its_loader_are_those_of_the_environment(tmp_path, opengl):
    from robomimic.utils.dataset import SequenceDataset

    path = export(tmp_path, 1, "--images", "overview", "--size", "32x24")
    config = config_factory("bc")
    with config.values_unlocked():
        config.observation.modalities.obs.low_dim = ["robot_joint_positions"]
        config.observation.modalities.obs.rgb = ["overview_rgb"]
    obs_utils.initialize_obs_utils_with_config(config)
    names = ("robot_joint_positions", "overview_rgb")
    data = SequenceDataset(str(path), obs_keys=names, dataset_keys=("actions",), seq_length=1)
    env = RobomimicEnvironment.from_file(path)
    env.seed(1000)
    observed = [env.reset()["overview_rgb"], env.step(data[0]["actions"][0])[0]["overview_rgb"]]
    for i, image in enumerate(observed):
        # The dataset has the image as recorded; its batches are processed as the environment's.
        loaded = {"overview_rgb": data[i]["obs"]["overview_rgb"][0]}
        expected = obs_utils.process_obs_dict(loaded)["overview_rgb"]
        assert image.shape == expected.shape == (3, 24, 32) and image.dtype == np.float32
        assert 0.0 <= image.min() < image.max() <= 1.0 and expected.std() > 0.05
        np.testing.assert_allclose(image, expected, atol=0.05)
    env.env.close()

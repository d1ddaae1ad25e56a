"""LeRobot's own evaluation runs in an environment of a tree."""

import json
import subprocess

from bt_manip_learn.demonstrations import DemonstrationRecorder

PACKAGE = "--env.discover_packages_path=bt_manip_learn.lerobot"

TINY = "dim_model=32 n_heads=2 dim_feedforward=64 n_encoder_layers=1 n_vae_encoder_layers=1"

DECLARED = """
from bt_manip_learn.lerobot import BtManipEnv, LeRobotEnvironment
config = BtManipEnv()
env = LeRobotEnvironment(**config.gym_kwargs)
observation, _ = env.reset(seed=0)
assert env.observation_space.contains(observation)
for key, name in config.features_map.items():
    print(name, *config.features[key].shape)
print(*env.action_names)
print(*env.action_space.low[:2], env.task_description)
"""


def run(python, *words):
    done = subprocess.run([python, *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout.splitlines()


def test_lerobot_evaluates_an_untrained_policy(lerobot, opengl, tmp_path):
    tiny = [f"--policy.{one}" for one in TINY.split()]
    run(
        lerobot, "-m", "lerobot.scripts.lerobot_eval", PACKAGE, "--env.type=bt_manip",
        "--env.task=pick_place", "--env.episode_length=3",
        "--env.options={action: cartesian_deltas}", f"--output_dir={tmp_path}",
        "--eval.n_episodes=1", "--eval.batch_size=1", "--policy.type=act", "--policy.device=cpu",
        "--policy.push_to_hub=false", *tiny,
    )  # fmt: skip
    found = json.loads((tmp_path / "eval_info.json").read_text())["overall"]
    assert (found["n_episodes"], found["pc_success"]) == (1, 0.0)
    assert (tmp_path / "videos" / "bt_manip_0" / "eval_episode_0.mp4").stat().st_size > 1000


def test_features_and_actions_are_those_of_the_export(lerobot, tmp_path):
    recorder = DemonstrationRecorder(tmp_path, "pick_place")
    identity, bounds = recorder.identity(), recorder.episodes.station.arm.model.limits
    sizes = {"robot": 0, "simulator": 0}
    for spec in identity["observations"].values():
        sizes[spec["group"]] += spec["shape"][0]
    names = identity["actions"]["joint_targets"]["names"]
    *features, actions, about = run(lerobot, "-c", DECLARED)
    assert sorted(features) == [
        f"action {len(names)}",
        f"observation.environment_state {sizes['simulator']}",
        f"observation.state {sizes['robot']}",
    ]
    assert actions.split() == list(names)
    *low, task = about.split(" ", 2)
    assert [float(one) for one in low] == [round(float(one), 4) for one in bounds.lower[:2]]
    assert task == "put the object into the basket"

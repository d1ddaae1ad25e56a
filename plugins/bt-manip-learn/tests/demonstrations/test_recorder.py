"""The recorder runs episodes as an environment sees them."""

from functools import partial

import numpy as np
import pytest

from bt_manip.exceptions import BtManipError
from bt_manip_learn.agents import STEP
from bt_manip_learn.demonstrations import DemonstrationRecorder, DemonstrationStore
from bt_manip_learn.demonstrations.recorder import same_length
from bt_manip_learn.envs import LearningTask

DISTANCE = {"joint_targets": 5e-3, "cartesian_deltas": 0.01}
"""Largest differences of the positions of tool and cube, as docs/demonstrations.md says [m]."""

ANGLE = 1e-3
"""Largest difference of a joint's position, with joint targets [rad]."""


@pytest.fixture(scope="module")
def make_recorder(tmp_path_factory, small_trees):
    """Make a recorder of a tree that hovers over a cube; by default it does not reach its goal."""
    return partial(
        DemonstrationRecorder, tmp_path_factory.mktemp("demos") / "store", f"{small_trees}:aimless"
    )


@pytest.fixture(scope="module")
def recorder(make_recorder):
    return make_recorder()


@pytest.fixture(scope="module")
def picked(tmp_path_factory):
    """A demonstration of pick_place."""
    return DemonstrationRecorder(tmp_path_factory.mktemp("picked"), "pick_place").record(1)


def test_an_episode_without_an_end_fails_after_a_minute(recorder, monkeypatch):
    episodes, step = recorder.episodes, recorder.episodes.expert_step

    def late():
        step()
        episodes.steps += 599  # half a minute more

    monkeypatch.setattr(episodes, "expert_step", late)
    one = recorder.record(0)
    assert (len(one), one.reason) == (2, "no end within 60 s simulated")


def test_only_successful_episodes_keep_their_steps(make_recorder, recorder):
    store = DemonstrationStore.create(recorder.folder, recorder.identity())
    recorder.run(0)
    assert len(store.read(0)) == 0 and not store.read(0).success
    assert store.read(0).reason == "the cell has no object 'never'"
    recorder.failures = True
    recorder.run(0)
    assert len(store.read(0)) > 10 and not store.read(0).success
    for setting, value in (("there", "nothing"), ("goal", "table")):
        other = make_recorder(settings={setting: value})
        with pytest.raises(BtManipError, match=f"holds demonstrations that differ: .*{value}"):
            other.run(1)
        other.folder = recorder.folder.with_name(setting)
        other.run(1)
        read = DemonstrationStore(other.folder).read(1)
        assert read.success == (setting == "goal")
        assert read.reason in ("", "is there: the cell has no object 'nothing'")
    assert len(read) == 6  # 300 ms for which its goal held, from the first step on


def test_parameters_that_were_set_belong_to_the_identity(make_recorder, recorder):
    assert make_recorder(vary={"scene.mass": 2}).identity()["varied"] == {"scene.mass": 2}
    assert not recorder.identity()["varied"]


def reproduced(task, demonstration, kind):
    """Repeat the actions, check the observations, and return the success."""
    task.reset(0, demonstration.episode)
    seen = [task.observe()]
    for action in demonstration.actions[kind]:
        outcome = task.step(action)
        seen.append(task.observe())
    errors = {
        name: np.abs([one[name] for one in seen] - array).max()
        for name, array in demonstration.observations.items()
    }
    if kind == "joint_targets":
        assert errors["robot_joint_positions"] < ANGLE
    assert errors["robot_tool_position"] < DISTANCE[kind]
    assert errors["cube_position"] < DISTANCE[kind]
    return outcome.success


@pytest.mark.parametrize("kind", DISTANCE)
def test_recorded_actions_reproduce_observations_and_success(picked, parts, kind):
    task = LearningTask("pick_place", parts=parts, tick=STEP, action=kind)
    assert picked.success and reproduced(task, picked, kind)


@pytest.mark.soak
def test_recorded_actions_reproduce_200_picks(parts, tmp_path):
    recorder = DemonstrationRecorder(tmp_path, "pick_place")
    tasks = {k: LearningTask("pick_place", parts=parts, tick=STEP, action=k) for k in DISTANCE}
    succeeded = dict.fromkeys(tasks, 0)
    for episode in range(200):
        demonstration = recorder.record(episode)
        for kind, task in tasks.items():
            succeeded[kind] += reproduced(task, demonstration, kind)
    assert min(succeeded.values()) >= 195


def test_states_with_fewer_objects_are_padded_with_nan():
    rows = same_length([np.arange(3.0).tobytes(), np.arange(5.0).tobytes()])
    np.testing.assert_array_equal(rows, [[0, 1, 2, np.nan, np.nan], [0, 1, 2, 3, 4]])


def test_each_step_has_what_was_observed_done_and_running(picked):
    one = picked
    n = len(one)
    assert n == len(one.dones) == len(one.leaves) == len(one.statuses)
    assert {len(array) for array in one.observations.values()} == {n + 1} == {len(one.states)}
    assert {len(array) for array in one.actions.values()} == {n}
    assert one.rewards.tolist() == [0.0] * (n - 1) + [1.0]
    assert one.dones.tolist() == [False] * (n - 1) + [True]
    assert not any(";" in leaf for leaf in one.leaves)  # one at a time
    leaves = [leaf.rpartition("/")[2].partition(":")[0] for leaf in dict.fromkeys(one.leaves)]
    assert leaves == ["OpenGripper", "Hover", "Reach", "Grasp", "Lift", "Drop"]


def test_the_same_episode_has_the_same_digest_whatever_ran_before(recorder, make_recorder):
    recorder.record(7)
    again = make_recorder().record(3)
    one = recorder.record(3)
    np.testing.assert_array_equal(one.states, again.states)
    state = recorder.episodes.station.cell.state_bytes()
    np.testing.assert_array_equal(one.states[-1], np.frombuffer(state))  # it can be restored
    assert one.digest == again.digest != recorder.record(4).digest


def test_an_episode_whose_state_diverges_in_the_grip_is_a_failed_one(tmp_path, monkeypatch):
    recorder = DemonstrationRecorder(tmp_path, "pick_place")
    store = DemonstrationStore.create(tmp_path, recorder.identity())
    station, step = recorder.episodes.station, recorder.episodes.expert_step

    def diverging():
        if station.gripper.held:
            station.cell.data.qvel[:] = np.nan
        step()

    monkeypatch.setattr(recorder.episodes, "expert_step", diverging)
    for episode in (0, 1):
        recorder.run(episode)
        assert store.read(episode).reason.startswith("PhysicsDiverged: MuJoCo warned at")


def test_images_of_chosen_cameras_are_observed(make_recorder, opengl):
    recorder = make_recorder(cameras=["overview"], size=(32, 24), settings={"goal": "table"})
    spec = recorder.identity()["observations"]["overview_rgb"]
    assert spec == {"shape": (24, 32, 3), "dtype": "uint8", "unit": "-", "group": "robot"}
    images = recorder.record(0).observations["overview_rgb"]
    assert images.shape[1:] == (24, 32, 3) and images.dtype == np.uint8
    assert images[0].std() > 5.0

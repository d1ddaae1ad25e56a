"""The recorder runs episodes as an environment sees them."""

from functools import partial

import numpy as np
import pytest

from bt_manip.exceptions import BtManipError
from bt_manip.runner import request_of
from bt_manip_learn.agents import STEP, Episodes, Observations, action_kind
from bt_manip_learn.demonstrations import DemonstrationRecorder, DemonstrationStore
from bt_manip_learn.demonstrations.recorder import SETTLING_STEPS
from bt_manip_learn.envs import LearningTask

TREE = """
<root BTCPP_format="4" main_tree_to_execute="T">
  <BehaviorTree ID="T" _goal="ObjectExists object={goal}">
    <Sequence>
      <SpawnObject model="cube" object="{cube}"/>
      <Hover object="{cube}" height="0.3"/>
      <ObjectExists name="is there" object="{there}"/>
      <Sleep msec="200"/>
    </Sequence>
  </BehaviorTree>
  <TreeNodesModel>
    <SubTree ID="T">
      <input_port name="goal" default="never"/>
      <input_port name="there" default="table"/>
    </SubTree>
  </TreeNodesModel>
</root>
"""

DISTANCE = {"joint_targets": 5e-3, "cartesian_deltas": 0.01}
"""Largest differences of the positions of tool and cube, as docs/demonstrations.md says [m]."""

ANGLE = 1e-3
"""Largest difference of a joint's position, with joint targets [rad]."""


@pytest.fixture(scope="module")
def make_recorder(tmp_path_factory):
    """Make a recorder of a tree that hovers over a cube; by default it does not reach its goal."""
    folder = tmp_path_factory.mktemp("demos")
    tree = folder / "hover.xml"
    tree.write_text(TREE)
    return partial(DemonstrationRecorder, folder / "store", str(tree))


@pytest.fixture(scope="module")
def recorder(make_recorder):
    return make_recorder()


@pytest.fixture(scope="module")
def picked(tmp_path_factory):
    """Demonstrations of two episodes of pick_place."""
    recorder = DemonstrationRecorder(tmp_path_factory.mktemp("picked"), "pick_place")
    return [recorder.record(episode) for episode in (0, 1)]


def test_parameters_that_were_set_belong_to_the_identity(make_recorder, recorder):
    assert make_recorder(vary={"scene.mass": 2}).identity()["varied"] == {"scene.mass": 2}
    assert not recorder.identity()["varied"]


def reproduce(episodes, demonstration, kind):
    """Repeat the actions; return the largest error of each observation, and the success."""
    episodes.reset(0, demonstration.episode)
    actions, observations = (
        action_kind(kind, episodes),
        Observations(episodes.station.cell, episodes.station.robots),
    )
    seen = [observations.read()]
    for action in demonstration.actions[kind]:
        actions.step(action)
        seen.append(observations.read())
    errors = {
        name: np.abs([one[name] for one in seen] - array).max()
        for name, array in demonstration.observations.items()
    }
    return errors, episodes.success


def check_reproduction(episodes, demonstration, kind):
    errors, success = reproduce(episodes, demonstration, kind)
    if kind == "joint_targets":
        assert errors["robot_joint_positions"] < ANGLE
    assert errors["robot_tool_position"] < DISTANCE[kind]
    assert errors["cube_position"] < DISTANCE[kind]
    return success


@pytest.mark.parametrize("kind", ["joint_targets", "cartesian_deltas"])
def test_recorded_actions_reproduce_observations_and_success(picked, parts, kind):
    episodes = Episodes(request_of("pick_place", parts, tick=STEP), parts)
    for one in picked:
        assert one.success and check_reproduction(episodes, one, kind)


@pytest.mark.soak
def test_recorded_actions_reproduce_200_picks(parts, tmp_path):
    recorder = DemonstrationRecorder(tmp_path, "pick_place")
    episodes = Episodes(request_of("pick_place", parts, tick=STEP), parts)
    succeeded = {"joint_targets": 0, "cartesian_deltas": 0}
    for episode in range(200):
        demonstration = recorder.record(episode)
        for kind in succeeded:
            succeeded[kind] += check_reproduction(episodes, demonstration, kind)
    assert min(succeeded.values()) >= 195


@pytest.mark.soak
def test_the_published_snippet_reproduces_100_picks(parts, tmp_path):
    recorder = DemonstrationRecorder(tmp_path, "pick_place")
    task = LearningTask("pick_place", parts=parts, tick=STEP)
    succeeded = 0
    for episode in range(100):
        one = recorder.record(episode)
        task.reset(0, episode)
        for action in one.actions["joint_targets"]:
            outcome = task.step(action)
        succeeded += outcome.success
    assert succeeded == 100


def test_each_step_has_what_was_observed_done_and_running(picked):
    one = picked[0]
    n = len(one)
    assert n == len(one.dones) == len(one.leaves) == len(one.statuses)
    assert {len(array) for array in one.observations.values()} == {n + 1} == {len(one.states)}
    assert {len(array) for array in one.actions.values()} == {n}
    assert one.rewards.tolist() == [0.0] * (n - 1) + [1.0]
    assert one.dones.tolist() == [False] * (n - 1) + [True]
    leaves = [leaf.rpartition("/")[2].partition(":")[0] for leaf in dict.fromkeys(one.leaves)]
    assert leaves == ["OpenGripper", "Hover", "Reach", "Grasp", "Lift", "Drop"]


def test_the_same_episode_has_the_same_digest_whatever_ran_before(recorder, make_recorder):
    recorder.record(7)
    again = make_recorder().record(3)
    one = recorder.record(3)
    assert one.digest == again.digest != recorder.record(4).digest
    np.testing.assert_array_equal(one.states, again.states)


def test_the_state_of_a_step_can_be_restored(recorder):
    one = recorder.record(3)
    cell = recorder.episodes.station.cell
    np.testing.assert_array_equal(one.states[-1], np.frombuffer(cell.state_bytes()))


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
    assert len(read) == SETTLING_STEPS + 1  # its goal held from the first step on


DIVERGING = """
from bt_manip.behaviours import Grasp, Hover, IsIn, Reach, SpawnObject
from bt_manip.bt import Action, Sequence, Sleep, Status, Tree


class Diverge(Action):
    def setup(self, **infrastructure):
        self.cell = infrastructure["cell"]

    def update(self):
        self.cell.data.qvel[:] = float("nan")
        return Status.RUNNING


def tree():
    steps = [kind(object="{cube}") for kind in (SpawnObject, Hover, Reach, Grasp)]
    return Tree(Sequence("pick", *steps, Diverge()), goal=IsIn(object="{cube}", container="basket"))
"""


def test_an_episode_whose_state_diverges_is_a_failed_one(tmp_path):
    (tmp_path / "diverging.py").write_text(DIVERGING)
    recorder = DemonstrationRecorder(tmp_path / "store", f"{tmp_path}/diverging.py:tree")
    store = DemonstrationStore.create(recorder.folder, recorder.identity())
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


def test_bad_input_is_found_before_anything_runs(make_recorder):
    with pytest.raises(BtManipError, match="no camera"):
        make_recorder(cameras=["overvew"]).identity()
    with pytest.raises(BtManipError, match="unknown robot"):
        make_recorder(robot="pand")

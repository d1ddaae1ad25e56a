"""Nav2's own trees run, with stubs for its leaves."""

import os
from collections import Counter
from pathlib import Path

import pytest

from bt_manip.bt import BehaviourRegistry, Stubs, read_tree
from bt_manip_nav2.plugin import register_behaviours, register_dialects

FOLDER = Path(os.environ.get("NAV2_ROOT", Path(__file__).resolve().parents[4] / "shared" / "nav2"))
TREES = sorted(FOLDER.glob("nav2_bt_navigator/behavior_trees/*.xml"))


@pytest.fixture(scope="module")
def registry():
    known = BehaviourRegistry()
    register_behaviours(known.register)
    register_dialects(known.register_dialect)
    return known


class Run:
    """A tree of Nav2 that is ticked every 10 ms, with the robot on its way along x."""

    def __init__(self, path, registry, **results):
        (models,) = FOLDER.rglob("nav2_tree_nodes.xml")
        self.now = 0.0
        stubs = Stubs(models=[models], results=results)
        reading = read_tree(path, registry, dialect="auto", clock=lambda: self.now, stubs=stubs)
        self.tree, self.warnings = reading.usable_tree(), reading.warnings
        self.completed = Counter()
        self.tree.root.runtime.observers.append(self._count)

    def _count(self, node, old, new):
        if new.name in ("SUCCESS", "FAILURE"):
            self.completed[node.registration] += 1

    def execute(self, seconds):
        """Tick until the root completes; give its status."""
        status = None
        while self.now < seconds:
            self.tree.blackboard["robot_pose"] = [0.5 * self.now, 0.0, 0.0]
            status = self.tree.tick_exactly_once()
            self.now += 0.01
            if status.name in ("SUCCESS", "FAILURE"):
                break
        return status.name


assert len(TREES) in (0, 15)
pytestmark = pytest.mark.skipif(not TREES, reason=f"no trees of Nav2 at {FOLDER}")


@pytest.mark.parametrize("path", TREES, ids=lambda path: path.stem)
def test_a_tree_of_nav2_has_no_warnings_and_runs_to_its_end(path, registry):
    run = Run(path, registry, ArePosesNear="FAILURE")  # far from the route
    unwritten = [w.message.split("'")[1] for w in run.warnings if w.code == "never-written"]
    lacks = path.stem == "navigate_to_pose_w_bounds_check"  # it is without its selectors
    assert unwritten == (["selected_planner", "selected_controller"] if lacks else [])
    assert len(run.warnings) == len(unwritten)
    endless = path.stem == "follow_point"  # which keeps its robot moving until that fails
    assert run.execute(3.0) == ("RUNNING" if endless else "SUCCESS")
    assert run.completed


@pytest.mark.parametrize(
    ("name", "plans"),
    [
        ("navigate_w_replanning_time", 6),  # 1 Hz
        ("navigate_w_replanning_distance", 3),  # each metre, at 0.5 m/s
        ("navigate_w_replanning_speed", 2),  # at 1 s, then at 10 s: the speed is 0
        ("navigate_w_replanning_only_if_goal_is_updated", 1),
    ],
)
def test_a_tree_of_nav2_plans_again_while_the_robot_follows_its_path(name, plans, registry):
    (path,) = (path for path in TREES if path.stem == name)
    run = Run(path, registry, FollowPath="RUNNING")
    assert run.execute(5.5) == "RUNNING"
    assert run.completed["ComputePathToPose"] == plans


def test_the_recoveries_of_nav2_take_turns_once(registry):
    (path,) = (p for p in TREES if p.stem == "navigate_to_pose_w_replanning_and_recovery")
    run = Run(path, registry, FollowPath="FAILURE", GoalUpdated="FAILURE")
    assert run.execute(60.0) == "FAILURE"
    turns = [run.completed[name] for name in ("Spin", "Wait", "BackUp")]
    assert turns == [1, 1, 1]  # without wrap_around, the last one ends them: it counts as a failure

"""Grasps that may be turned about an axis of the object, and arms that reach few poses."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import build_station, spatial
from bt_manip.arm import MARGIN
from bt_manip.behaviours.poses import centre_pose
from bt_manip.cell.objects import Cube, Cylinder, Sphere
from bt_manip.grasping import GraspPlanner, GripperClearance
from bt_manip.grasping.grasp_search import GraspSearch, standoff_of
from bt_manip.grasping.gripper_clearance import Clearance
from bt_manip.grasping.ranking import RankedGrasp
from bt_manip.grasping.rejections import Rejections
from bt_manip.runner import Station

FIVE_JOINTS = Path(__file__).parents[1] / "robots/models/five_joints.toml"
TABLE = 1.015  # [m] height of its surface
DOWN = pin.SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 0.1]))


@pytest.fixture(scope="module")
def built(parts) -> Station:
    return build_station(parts, robot=str(FIVE_JOINTS))


@pytest.fixture
def five(built):
    """Give the arm of five joints at the table, with nothing to grip on it."""
    for name in ("cube", "it"):
        if name in built.cell.entities:
            built.cell.remove(name)
    return built


def plan(station, thing, radius, yaw, turn=0.0, heights=(0.15,)):
    """Plan a grasp of a thing on the table, seen from the arm's first joint."""
    foot = station.arm.model.model.jointPlacements[1].translation
    x, y = foot[:2] + radius * np.array([np.cos(yaw), np.sin(yaw)])
    quat = (np.cos(0.5 * turn), 0.0, 0.0, np.sin(0.5 * turn))
    station.cell.add(thing, spatial.pose((x, y, TABLE + thing.rest_height), quat), name="it")
    centre = centre_pose(station.cell, "it").translation
    found = GraspPlanner(station.cell, station.arm).plan("it", heights, centre)
    return found, centre


class Search(GraspSearch):
    """Gives the steps of the search, for an arm with given solutions, first joints and margins."""

    def __init__(self, solutions, world=None, clearance=None):
        found = [SimpleNamespace(q=np.array([q]), target=0) for q, _ in solutions]
        self.given = []
        ik = SimpleNamespace(
            nearest_first=lambda *_, **given: self.given.append(given) or found, tool="tool"
        )
        arm = SimpleNamespace(q=np.zeros(1), ik=ik, world=world)
        self.ranking = SimpleNamespace(candidates=SimpleNamespace(closing=None))
        super().__init__(arm, "it", self.ranking, clearance, Rejections("it"))
        self.solutions = dict(solutions)

    def nearest_plan(self):
        return self._nearest([SimpleNamespace(T_wt=DOWN, free_axis=None)], 0.1, np.zeros(3))[0]

    def plan_from(self, *given):
        return self._plan_from(*given)

    def plan(self, *given):
        return self._plan(*given)

    def can_lift(self, *given):
        return self._can_lift(*given)

    def with_clearance(self, ranked):
        return [candidate.grasp for candidate in self._with_clearance(ranked)]


class Margins(Search):
    def _plan_from(self, candidate, q, standoff):
        return self.solutions[q[0]] and (self.solutions[q[0]], q[0])


class Batches(Search):
    """Has clearance everywhere, and notes which grasps are tried together."""

    tried, found = (), None

    def _with_clearance(self, ranked):
        return list(ranked)

    def _plan_from_first(self, batch, *_):
        self.tried += ([candidate.cost for candidate in batch],)
        return self.found


@pytest.mark.parametrize(
    ("solutions", "chosen"),
    [
        ([(0.1, 0.03), (0.5, 0.04), (0.9, 0.02)], 0.5),
        ([(0.1, 0.04), (0.5, MARGIN), (0.9, 2 * MARGIN)], 0.5),
        ([(0.1, None), (0.21, 0.02), (0.5, 0.01)], 0.21),
        ([(0.1, None), (0.19, 0.02), (0.5, 0.01)], 0.5),
        ([(0.1, None), (0.5, None)], None),
    ],
)
def test_the_first_configuration_far_from_joint_limits_or_else_the_farthest_is_taken(
    solutions, chosen
):
    search = Margins(solutions)
    assert search.nearest_plan() == chosen
    searches = [(0, MARGIN), (1, MARGIN), (8, MARGIN), (8, 0.0)]
    assert [tuple(given.values()) for given in search.given] == searches[: 1 if chosen else 4]
    search.rejections.approaches = 24
    assert search.nearest_plan() is None


def test_all_grasps_of_a_group_that_no_configuration_reaches_are_counted():
    search, grasp = Search([]), RankedGrasp(None, pin.SE3.Identity(), 1.0, {}, 0.0, 0.0)
    turnable = grasp._replace(free_axis=np.eye(3)[2], pivot=np.zeros(3))
    for grasps in ([grasp] * 3, [grasp] * 2, [turnable] * 2):
        assert search.plan(grasps, 0.1, np.zeros(3)) is None
    assert search.rejections.unreachable == 7 and len(search.given) == 12
    assert search.plan([turnable], 0.1, np.zeros(3)) is None
    assert len(search.given) == 12  # it was searched at any turn


def test_a_pre_grasp_configuration_in_collision_is_counted_by_its_bodies():
    hits = [("panda/hand", "wall", -0.01), ("panda/link5", "table", -0.02)]
    search = Search([], SimpleNamespace(collisions=lambda q: hits))
    for _ in range(2):
        assert search.plan_from(SimpleNamespace(free_axis=None), np.zeros(1), 0.1) is None
    assert search.rejections.collisions == {("panda/hand", "wall"): 2}


@pytest.mark.parametrize(("T_wt", "lifted", "beside", "blocked"), [
    (DOWN, -1.1e-3, 0.0, ("it", "shelf")), (DOWN, -0.9e-3, -0.1, None),
    (pin.SE3.Identity(), -0.9e-3, -0.1, ("gripper", "post")),
])  # fmt: skip
def test_a_blocked_lift_of_the_object_or_the_gripper_is_counted_once(T_wt, lifted, beside, blocked):
    gaps = SimpleNamespace(
        of_displaced=lambda name, steps: Clearance(lifted, "shelf"),
        at_pose=lambda T: Clearance(beside, "post"),
    )
    search = Search([], clearance=gaps)
    assert search.can_lift(SimpleNamespace(T_wt=T_wt), np.zeros(1)) == (blocked is None)
    assert search.rejections.collisions == ({blocked: 1} if blocked else {})


@pytest.mark.parametrize(
    ("tilt", "height", "standoff"),
    [
        (90, 0.02, 0.05),
        (90, 0.3, 0.12),
        (31, 0.3, 0.12),
        (29, 0.3, 0.29705),
        (0, 0.05, 0.03),
        (0, 0.01, 0.0),
    ],
)
def test_a_grasp_begins_before_it_and_from_the_side_by_at_most_12_cm(tilt, height, standoff):
    tilt = np.pi - np.radians(tilt)
    T_wt = pin.SE3(pin.exp3(np.array([0.0, tilt, 0.0])), np.array([0.33, -0.2, 0.12]))
    centre = np.array([0.3, -0.2, 0.1])
    assert standoff_of(T_wt, height, centre) == pytest.approx(standoff, abs=1e-5)


def test_grasps_are_tried_together_by_four_of_similar_cost_and_in_six_groups():
    search = Batches([])
    costs = [0.0, 0.02, 0.029, 0.031, 0.05, 0.06, 0.0605, 0.0606, 0.2, 0.3, 0.4, 0.5]
    search.ranking.by_cost = lambda: (SimpleNamespace(cost=cost) for cost in costs)
    assert search.best((0.1,), np.zeros(3)) is None
    assert [*search.tried] == [costs[:3], costs[3:7], *([cost] for cost in costs[7:11])]
    search.found = SimpleNamespace(grasp="found")
    assert search.best((0.1,), np.zeros(3)).grasp == search.checked.chosen == "found"
    search.rejections.approaches = 24
    assert search.best((0.1,), np.zeros(3)) is None


def test_grasps_with_less_than_4_mm_come_last_but_at_the_tool_and_fingers_close_freely():
    opened = []
    gaps = SimpleNamespace(
        at_pose=lambda gap: Clearance(gap, "post"),
        open=lambda opening=1.0: opened.append(opening),
        to_entity=lambda *_: inside.get((opened or [1.0])[-1], 0.0),
    )
    search, candidates = Search([], clearance=gaps), SimpleNamespace(clear=True)
    search.ranking.candidates = candidates
    given = [(-0.0031, 0.04), (0.0039, 0.06), (0.0039, 0.04), (-0.0029, 0.06), (0.0041, 0.06)]
    grasps = [SimpleNamespace(T_wt=given[i % 5][0], tool_distance=given[i % 5][1], grasp=i,
                              opening=0.125) for i in range(200)]  # fmt: skip
    kinds = [[i for i in range(128) if i % 5 in kind] for kind in ((2, 4), (1, 3))]
    assert search.with_clearance(grasps) == sum(kinds, [])
    assert search.rejections.no_clearance == {"post": 26}
    assert search.checked.grasps == [(i, i % 5 > 0) for i in range(128)]
    candidates.clear = False
    steps = [1.0 - 0.875 * k / 3 for k in (1, 2, 3)]
    for at, gap, closed in ((steps[2], -4e-4, 3), (steps[1], -6e-4, 2), (1.0, -1e-6, 0)):
        inside = {at: gap}
        opened.clear()
        assert search.with_clearance(grasps[4:5]) == ([4] if closed == 3 else [])
        assert opened == pytest.approx([*steps[:closed], 1.0] if closed else [])
    assert search.rejections.self_obstructed == 2


def test_a_lift_from_the_side_goes_up_5_cm_and_may_touch_the_object_only(monkeypatch):
    seen, hits, lift = [], [("panda/hand", "it", -0.1)], SimpleNamespace(error=None, end="end")
    gaps = SimpleNamespace(
        of_displaced=lambda name, steps: seen.extend(steps) or Clearance(0.0, ""),
        at_pose=lambda T: seen.append(T.translation) or Clearance(1e-9, ""),
    )
    plan = lambda ik, q, T, world: seen.append(T.translation) or lift  # noqa: E731
    monkeypatch.setattr("bt_manip.grasping.grasp_search.plan_straight_approach", plan)
    search = Search([], SimpleNamespace(collisions={"end": hits}.get), gaps)
    candidate = SimpleNamespace(T_wt=spatial.pose((0.1, 0.2, 0.3)))
    assert search.can_lift(candidate, np.zeros(1))
    steps, up = [(0.0, 0.0, 0.025), (0.0, 0.0, 0.05)], [(0.1, 0.2, 0.325), (0.1, 0.2, 0.35)]
    assert np.allclose(seen, [*steps, *up, up[1]])
    hits.append(("panda/hand", "wall", -0.1))
    assert not search.can_lift(candidate, np.zeros(1))
    assert search.rejections.collisions == {("panda/hand", "wall"): 1}


@pytest.mark.parametrize(
    ("make", "turn"), [(Cube, 0.4), (Cube, 1.1), (Cylinder, 0.4), (Sphere, 0.0)]
)
def test_an_arm_of_five_joints_grips_from_above_at_any_turn(five, make, turn):
    found, _ = plan(five, make(), 0.5, -0.4, turn)
    assert found.T_wt.rotation[2, 2] == pytest.approx(-1.0, abs=1e-4)


def test_a_ball_too_far_to_grip_from_above_is_gripped_on_the_side_that_the_joints_reach(five):
    found, centre = plan(five, Sphere(radius=0.025), 0.76, -0.4)
    approach = found.T_wt.rotation[:, 2]
    assert 0.3 < -approach[2] < 0.9
    outwards = np.arctan2(approach[1], approach[0])
    assert outwards == pytest.approx(-0.4, abs=1e-3)
    assert found.T_wt.translation == pytest.approx(centre, abs=1e-5)
    tool = five.arm.model.pose(found.q_pregrasp)
    assert tool.rotation == pytest.approx(found.T_wt.rotation, abs=1e-4)
    nearest = GraspPlanner(five.cell, five.arm).nearest("it", tool)[1]
    assert nearest.rotation == pytest.approx(tool.rotation, abs=1e-4)


@pytest.mark.parametrize("make", [Cube, Cylinder])
def test_the_first_height_that_the_arm_reaches_is_taken_without_more_clearance_checks(
    five, make, monkeypatch
):
    measured = []
    at_pose = GripperClearance.at_pose

    def counted(self, T_wt):
        measured.append(tuple(T_wt.translation.tolist() + T_wt.rotation.ravel().tolist()))
        return at_pose(self, T_wt)

    monkeypatch.setattr(GripperClearance, "at_pose", counted)
    found, centre = plan(five, make(), 0.74, -0.4, heights=(0.4, 0.3, 0.2, 0.1))
    tool = five.arm.model.pose(found.q_pregrasp).translation
    assert tool - centre == pytest.approx([0.0, 0.0, 0.2], abs=1e-4)
    assert make is not Cube or len(set(measured)) == len(measured) > 0

from itertools import product
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import build_station
from bt_manip.cell import CellError, Cube
from bt_manip.grasping import REFERENCE_AREA, ReachFromAbove
from bt_manip.runner import Station
from bt_manip.scenes import two_arms
from bt_manip.spatial import pointing_down, pose
from tests.robot_fixtures import Box
from tests.support.small_arm import write_small_arm

HEIGHT = 0.04  # [m] of the tool over the table, at a grasp of the cube


def reaches(station: Station, x: float, y: float, yaw: float = 0.0) -> bool:
    """Tell whether the tool reaches down there, parallel to a cube of that yaw, without contact."""
    arm, z = station.arm, station.cell.surface_height("table") + HEIGHT
    poses = [pointing_down((x, y, z), yaw + k * np.pi / 2) for k in range(4)]
    found = arm.ik.solutions(poses, arm.q, restarts=4)
    return any(not arm.world.collisions(result.q) for result in found)


@pytest.fixture(scope="module")
def small(parts, tmp_path_factory) -> Station:
    path = write_small_arm(tmp_path_factory.mktemp("small"))
    return build_station(parts, robot=str(path))


@pytest.fixture
def coarse_grid(monkeypatch) -> None:
    monkeypatch.setattr("bt_manip.grasping.reach_from_above.DIVISIONS", 9)


class Reach(ReachFromAbove):
    """The steps of the search."""

    def approach(self, *given):
        return self._approach(*given)

    def reached_grid(self, *given):
        return self._reached_grid(*given)

    def all_reached(self, *given):
        return self._all_reached(*given)

    def comes_down(self, *given):
        return self._comes_down(*given)

    def base(self):
        return self._base()


def test_a_point_is_approached_with_the_two_quarter_turns_nearest_to_the_arm():
    tried = []
    ik = SimpleNamespace(nearest_first=lambda T_wt, *_, **__: tried.append(T_wt) or [])
    model = SimpleNamespace(pose=lambda q: pointing_down((0.0, 0.0, 0.0), q))
    reach = Reach(SimpleNamespace(ik=ik, model=model))
    assert reach.approach((0.4, 0.1, 0.2), 2.2, 2.0, 0) is None
    yaws = 2.2, 2.2 - np.pi / 2  # 0.2 and 1.37 rad from 2.0 rad, others 1.77 and more
    for T_wt, yaw in zip(tried, yaws, strict=True):
        assert T_wt.isApprox(pointing_down((0.4, 0.1, 0.3), yaw), 1e-9)


@pytest.mark.parametrize("reached", [3, 4])
def test_points_are_all_reached_if_each_is_at_both_yaws_one_from_the_other(reached):
    tried = []

    class Turning(Reach):
        def _turned(self, position, yaw, q0):
            tried.append((*position, yaw, q0))
            return q0 + 1.0 if len(tried) <= reached else None

    reach = Turning(SimpleNamespace(model=SimpleNamespace(home=3.0)))
    assert reach.all_reached([(0.1, 0.2), (0.3, 0.4)], 0.5) == (reached == 4)
    places = product([(0.1, 0.2, 0.5), (0.3, 0.4, 0.5)], (0.0, np.pi / 4))
    expected = [(*place, yaw, 3.0 + i) for i, (place, yaw) in enumerate(places)]
    assert np.allclose(tried, expected)


def test_every_third_point_is_searched_and_one_out_of_reach_tried_from_two_neighbours():
    searched, tried = [], []

    class Holed(Reach):
        def _approach(self, position, yaw, q0, restarts):
            (searched if restarts == 4 else tried).append((*position[:2], yaw))
            return None if position[:2] == (2.0, 2.0) else np.zeros(2)

    grid = np.arange(5.0)
    reached = Holed(SimpleNamespace(model=SimpleNamespace(home=None))).reached_grid(grid, grid, 0)
    assert len(reached) == 24 and tried.count((2.0, 2.0, 0.0)) == 2
    assert searched == [(x, y, 0.0) for x in (1.0, 4.0) for y in (1.0, 4.0)]


class Along(Reach):
    """Its arm, 0.9 m long, reaches what is at some distances from its base, and notes all tried."""

    def __init__(self, low, high):
        super().__init__(SimpleNamespace(world=None))
        self.low, self.high, self.tried, self.length = low, high, [], 0.9

    def _base(self):
        return np.array([0.1, -0.2, 0.3]), self.length

    def _can_drop(self, T_wc, heights):
        self.tried.append((np.hypot(*T_wc.translation[:2] - (0.1, -0.2)), *heights))
        return self.low <= self.tried[-1][0] <= self.high

    def reaches(self, cell, name, T_wo=None):
        return T_wo is not None and self._can_drop(T_wo, ())

    def _all_reached(self, points, z):
        self.tried.append((points, z))
        return True

    def _reached_grid(self, xs, ys, z):
        self.tried.append((xs, ys, z))
        return {(i, j): 10 * i + j for i in range(3) for j in range(3) if i + j < 4}

    def _turned(self, *given):
        self.tried.append(given)
        return None if given[2] == 1 else 0  # the second square cannot be reached at a yaw


@pytest.mark.parametrize(("low", "high", "found"), [(0.2, 0.3, 0.26), (0.6, 0.7, 0.65), (2, 3, 0)])
@pytest.mark.parametrize("category", ["graspable", "container"])
def test_an_object_is_placed_a_step_within_reach_towards_the_arm_or_else_away(
    category, low, high, found
):
    towards, moved = np.array([0.6, 0.8, 0.0]), []
    T_wo = pin.SE3(pin.utils.rotate("z", 0.4), np.array([0.1, -0.2, 0.7]) + 0.5 * towards)
    declared, reach = SimpleNamespace(category=category), Along(low, high)
    cell = SimpleNamespace(
        pose=lambda _: T_wo, find=lambda _: declared, move=lambda _, T: moved.append(T)
    )
    reach.place(cell, "it")
    for T in moved:
        assert T.isApprox(pin.SE3(T_wo.rotation, T_wo.translation + (found - 0.5) * towards))
    assert len(moved) == bool(found)
    if not found:  # none from 0.15 to 0.9 m
        steps = [0.5 - 0.03 * k for k in range(1, 12)] + [0.5 + 0.03 * k for k in range(1, 14)]
        drops = [0.25 - 0.03 * k for k in range(6)]
        heights = [drops[:3], drops] if category == "container" else [()]
        for tried, given in zip(reach.tried, product(heights, steps), strict=True):
            assert tried == pytest.approx((given[1], *given[0]))
        with pytest.raises(CellError, match="no free place for 'it'"):
            reach.place(cell, "it", T_wo)


@pytest.mark.parametrize(
    ("low", "high"),
    [
        ((-0.5, -2.0), (2.0, 0.6)),
        ((0.25, -2.0), (2.0, 0.6)),
        ((-0.5, -2.0), (0.35, 0.6)),
        ((-0.5, -0.25), (2.0, 0.6)),
        ((-0.5, -2.0), (2.0, 0.25)),
    ],
)
def test_the_preferred_area_lies_on_the_surface_and_the_grid_also_within_the_arms_length(
    monkeypatch, low, high
):
    module = "bt_manip.grasping.reach_from_above"
    monkeypatch.setattr(f"{module}.extent", lambda *_: (np.array(low), np.array(high)))
    monkeypatch.setattr(f"{module}._fixed_content", lambda _: b"")
    cell, reach = SimpleNamespace(surface_height=lambda name: 0.5), Along(0, 0)
    region = reach.area(cell, "table", 0.12)
    first, *turned = reach.tried
    if (low, high) == ((-0.5, -2.0), (2.0, 0.6)):
        points = [(x, y) for x in (0.2, 0.3, 0.4) for y in (-0.3, 0.0, 0.3)]
        assert np.allclose(first[0], points) and first[1] == 0.62
        reach.length = 0.18
        assert reach.area(cell, "table", 0.12, (9.0, 9.0, 9.0, 9.0)).side == 0.02
        return
    begin, end = np.maximum(low, (-0.8, -1.1)), np.minimum(high, (1.0, 0.7))
    for axis in (0, 1):  # squares of 0.9 m / 18
        assert first[axis] == pytest.approx(np.arange(begin[axis], end[axis] - 1e-9, 0.05))
    x, y = begin + 0.025  # three squares have all corners
    assert first[2] == 0.62 and np.allclose(region.squares, [(x, y), (x + 0.05, y)])
    bounds = [*region.x, *region.y, *region.z]
    assert np.allclose(bounds, [x - 0.025, x + 0.075, y - 0.025, y + 0.025, 0.5, 0.5])
    assert [q for *_, q in turned] == [0, 1, 10] and {yaw for _, yaw, _ in turned} == {np.pi / 4}
    assert np.allclose(
        [at for at, *_ in turned], [(x, y, 0.62), (x, y + 0.05, 0.62), (x + 0.05, y, 0.62)]
    )


def test_the_tool_comes_down_in_two_steps_from_each_reached_configuration():
    hits, followed = [], []

    def follow(target, q, max_step, retry):
        followed.append((*target.translation, q, max_step))
        return SimpleNamespace(solved=True, q=q + 1.0)

    world = SimpleNamespace(collisions=lambda q: hits if q == blocked else [])
    reach = Reach(SimpleNamespace(ik=SimpleNamespace(follow=follow), world=world))
    for blocked in (2.0, 3.0, 4.0, 5.0):
        hits[:] = [SimpleNamespace(first="arm/hand", second="post")]
        assert reach.comes_down(pointing_down((0.3, -0.2, 0.5)), 2.0) == (blocked == 5.0)
    assert np.allclose(followed[-2:], [(0.3, -0.2, 0.45, 2.0, 1.0), (0.3, -0.2, 0.4, 3.0, 1.0)])


def test_the_arms_length_is_that_of_its_links_and_the_longest_travel_of_its_slides():
    joints = SimpleNamespace(jointPlacements=[None, pose((0.1, 0.2, 0.3)), None])
    limits = SimpleNamespace(lower=np.array([-3.0, -0.7, -0.1]), upper=np.array([2.0, 0.2, 0.4]))
    model = SimpleNamespace(units=("rad", "m", "m"), limits=limits, link_lengths=(0.3, 0.5))
    model.model = joints
    base = Reach(SimpleNamespace(model=model)).base()
    assert np.allclose(np.hstack(base), [0.1, 0.2, 0.3, 0.8 + 0.7 + 0.4])


def test_targets_are_reached_in_turn_and_without_any_the_centre_and_10_cm_above_it():
    class Chained(Reach):
        def _first_free(self, poses, q0, used):
            tried.append((*poses[0].translation, len(poses), q0, used))
            return q0 + 1.0

    arm = SimpleNamespace(world=None, model=SimpleNamespace(home=3.0))
    T_wo = pose((0.3, 0.2, 0.1), (0.8, 0.0, 0.0, 0.6))
    own = SimpleNamespace(centre_offset=(0.1, 0.0, 0.05), tool_targets=[])
    cell = SimpleNamespace(pose=lambda _: T_wo, find=lambda _: own)
    for own.tool_targets in ([], [[pose((0.1, 0.0, 0.05))] * 4, [pose((0.1, 0.0, 0.15))] * 4]):
        tried = []
        assert Chained(arm).reaches(cell, "it")
        expected = [(0.328, 0.296, 0.15, 4, 3.0), (0.328, 0.296, 0.25, 4, 4.0)]
        assert np.allclose([one[:5] for one in tried], expected) and tried[0][5] == "it"


def test_basket_and_preferred_areas_stay_where_they_are_within_reach(parts):
    station = build_station(parts)
    assert station.cell.pose("basket").translation.tolist() == [0.68, 0.0, 1.015]
    assert REFERENCE_AREA == (0.2, 0.4, -0.3, 0.3)
    for preferred in (REFERENCE_AREA, (0.25, 0.5, -0.3, 0.05)):
        given = () if preferred == REFERENCE_AREA else (preferred,)
        region = station.first.reach.area(station.cell, "table", HEIGHT, *given)
        assert (*region.x, *region.y) == preferred
        assert not region.squares


def test_the_area_of_a_small_arm_covers_more_than_half_of_what_it_reaches(small):
    assert small.cell.pose("basket").translation[0] < 0.5  # within reach
    assert small.cell.pose("table").translation[0] == 0.0
    region = small.first.reach.area(small.cell, "table", HEIGHT)
    small.arm.world.refresh(fixed_only=True)
    points = np.random.default_rng(0).uniform((-0.7, -0.4), (0.5, 0.4), (40, 2))
    reached = [point for point in points if reaches(small, *point)]
    covered = [point for point in reached if region.covers(pose((*point, 0.0)), slack=0.0)]
    assert len(reached) > 10
    assert len(covered) >= 0.5 * len(reached)


def test_the_tool_comes_down_everywhere_in_the_area_of_a_small_arm(small):
    region = small.first.reach.area(small.cell, "table", HEIGHT)
    small.arm.world.refresh(fixed_only=True)
    rng = np.random.default_rng(1)
    for _ in range(30):
        x, y, _ = region.sample(rng).translation
        assert reaches(small, x, y, rng.uniform(-np.pi, np.pi))


@pytest.mark.usefixtures("coarse_grid")
def test_the_area_does_not_depend_on_free_objects_or_where_the_arm_is(small):
    before = ReachFromAbove(small.arm).area(small.cell, "table", HEIGHT)
    state = small.get_state()
    small.cell.add(Cube(), pose((*before.squares[0], 1.04)), name="cube")
    small.robot.set_configuration(np.array(small.robot.description.home) + 0.3)
    after = ReachFromAbove(small.arm).area(small.cell, "table", HEIGHT)
    small.set_state(state)
    assert after == before


def test_an_arm_that_reaches_nothing_from_above_says_where_to_place_it(small):
    with pytest.raises(CellError, match="reaches no part of 'table' from above.*base"):
        ReachFromAbove(small.arm).area(small.cell, "table", 0.6)


@pytest.mark.usefixtures("coarse_grid")
def test_the_area_does_not_depend_on_where_another_arm_is(parts):
    def area(station):
        right = station.robots["right"]
        return ReachFromAbove(right.arm).area(station.cell, "table", HEIGHT)

    station = build_station(parts, scene=two_arms())
    before, left = area(station), station.robots["left"]
    reached = left.arm.ik.nearest(pointing_down((0.2, 0.0, 1.2)), left.arm.q)
    assert reached.solved
    left.arm.reset(reached.q)
    left.robot.set_configuration(reached.q)
    assert area(station) == before


@pytest.mark.usefixtures("coarse_grid")
def test_the_area_is_found_anew_when_a_fixed_object_was_turned_in_place(small):
    reach, state = ReachFromAbove(small.arm), small.get_state()
    x, y = reach.area(small.cell, "table", HEIGHT).squares[0]
    along, across = pose((x, y, 1.07)), pose((x, y, 1.07), (0.5**0.5, 0.0, 0.0, 0.5**0.5))
    small.cell.add(Box((0.3, 0.02, 0.1)), along, name="bar", free=False)
    before = reach.area(small.cell, "table", HEIGHT)
    small.cell.move("bar", across)
    after = reach.area(small.cell, "table", HEIGHT)
    small.cell.remove("bar")
    small.set_state(state)
    assert before.squares != after.squares

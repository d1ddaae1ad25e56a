"""A robot is placed where it reaches the table and the basket, and has its home above the table."""

from itertools import count
from types import SimpleNamespace

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip_setup import placement
from bt_manip_setup.reach import RadialReach

FOOT = (-0.012, 0.07)  # [m] lowest point and half width


@pytest.fixture
def foot(monkeypatch):
    monkeypatch.setattr(placement, "measure_foot", lambda robot: FOOT)


def annulus(outer: float, front: float, axis=(0.06, -0.04)) -> RadialReach:
    """Return the reach of an arm that reaches all heights between two radii."""
    radii, heights = np.linspace(0.1, outer, 30), np.linspace(-0.6, 0.8, 29)
    return RadialReach(np.array(axis), front, radii, heights, np.full((29, 30), 5.0))


@pytest.mark.parametrize("front", [0.1, np.pi / 2, -1.5, 3.0])
@pytest.mark.parametrize(("outer", "x"), [(0.9, 0.0), (0.601, 0.15), (0.46, 0.3), (0.3, None)])
def test_a_base_moves_ahead_as_far_as_the_basket_needs_with_its_front_to_the_table(
    foot, outer, x, front
):
    """The basket is at 0.78 m; its axis, here 30 mm beside the middle, is the first hinge."""
    quarter = pin.rpy.rpyToMatrix(0.0, 0.0, -np.round(front / (np.pi / 2)) * np.pi / 2)
    axis = quarter.T @ np.array([0.03, 0.02, 0.0])
    reach = annulus(outer, front, axis[:2])
    found = placement.place_base(None, reach)
    assert found.T_rb.rotation == pytest.approx(quarter, abs=1e-9)
    assert found.T_rb.translation[1:] == pytest.approx([0.0, 0.012])  # on its foot
    assert found.pedestal is None
    centre = found.T_rb.act(axis)[:2]

    if x is not None:
        assert found.T_rb.translation[0] == pytest.approx(x)
        assert 0.1 <= np.hypot(*(centre - (0.78, 0.0))) <= outer


def test_positions_of_the_task_lie_on_the_table_evenly_and_alike_on_both_sides(foot):
    asked, heights = {}, set()
    for side in (0.05, -0.05):
        asked[side] = []

        def covers(radius, height, floor, side=side):
            asked[side].append(radius)
            heights.update(np.round(height - floor, 6))  # over the table
            return np.ones(len(radius), dtype=bool)

        reach = SimpleNamespace(axis=np.array([0.03, side]), front=0.0, covers=covers)
        assert placement.place_base(None, reach).T_rb.translation[0] == 0.0
    for left, right in zip(*asked.values(), strict=True):
        assert np.sort(left) == pytest.approx(np.sort(right))
    assert heights == {0.04, 0.15, 0.4, 0.25, 0.22, 0.19}  # to pick, and to drop
    x, y = np.meshgrid((0.3, 0.4, 0.5), (-0.3, -0.15, 0.0, 0.15, 0.3))
    expected = np.sort(np.hypot(x - 0.03, y - 0.05), axis=None)
    assert np.sort(asked[0.05][0]) == pytest.approx(expected)
    table = max(asked[0.05][:8], key=len)  # of the first base: 8 columns of 8 positions
    x, y = np.meshgrid(np.linspace(-0.1, 0.6, 8), np.linspace(-0.35, 0.35, 8))
    assert np.sort(table) == pytest.approx(np.sort(np.hypot(x - 0.03, y - 0.05), axis=None))


PICK, CARRY, TABLE, DROP_HIGH, DROP = (0, 1), (2,), (3, 4), (5,), (6,)


@pytest.mark.parametrize(
    ("better", "gain", "of_table"),
    [
        (PICK, 0.05, 0.5),
        (CARRY, 0.05 / 0.3, 0.5),
        (TABLE, 0.05, 0.5),
        (TABLE, 0.05 / (1.0 + 1.15 / 0.1), 0.05),  # below a tenth, basket counts less, too
        (DROP_HIGH, 0.05 / 2.3, 0.5),
        (DROP, 0.05 / 2.0, 0.5),
    ],
)
def test_a_base_moves_by_50_mm_for_so_much_more_reach(foot, better, gain, of_table):
    """Half of all positions are reached, and a larger share where the base is moved."""
    for more, x in ((0.97 * gain, 0.0), (1.03 * gain, 0.05)):
        calls = count()

        def covers(radius, height, floor, more=more, calls=calls):
            base, part = divmod(next(calls), 8)
            share = of_table if part in TABLE else 0.5
            return np.full(len(radius), share + more * (base == 1 and part in better))

        reach = SimpleNamespace(axis=np.zeros(2), front=0.0, covers=covers)
        assert placement.place_base(None, reach).T_rb.translation[0] == x


@pytest.mark.parametrize(("outer", "height"), [(0.9, 0.3), (0.5, 0.2)])
def test_home_is_over_the_middle_of_the_reach_or_as_near_to_it_as_possible(outer, height):
    """The tool is at 0.3 m over the table, lower for small arms, and in front of the arm."""
    reach, base = annulus(outer, 2.0), pin.SE3(np.eye(3), np.array([0.1, 0.0, 0.03]))
    reach.lowest[:, :9] = -np.inf
    tried = []

    def configuration(position, floor):
        assert floor == -0.03
        tried.append(np.array(position))
        return "home" if len(tried) == 300 else None

    downward = SimpleNamespace(configuration=configuration)
    assert placement.find_home(downward, reach, base) == "home"
    offset = np.array(tried)[:, :2] - (0.06, -0.04)
    radius, z = np.hypot(*offset.T), np.array(tried)[:, 2] + 0.03
    assert offset == pytest.approx(radius[:, None] * [np.cos(2.0), np.sin(2.0)])
    row, middle = np.abs(z - height), 0.5 * (reach.radii[9] + outer)
    assert (np.diff(row) > -1e-9).all() and row[0] < 0.026 and row[-1] > 0.3
    for one in np.unique(z):
        assert (np.diff(np.abs(radius[z == one] - middle)) > -1e-9).all()
        assert radius[z == one].min() >= reach.radii[9] - 1e-9


@pytest.mark.parametrize("width, half", [(0.02, 0.05), (0.08, 0.09), (0.3, 0.15)])
def test_a_foot_is_as_low_and_wide_as_its_corners(width, half):
    """Here a turned block, and a link that turns about the vertical and does not widen it."""
    model = mujoco.MjModel.from_xml_string(f"""<mujoco><worldbody>
      <body pos="-0.01 0.004 0.1">
      <geom type="box" size="{width} 0.02 0.03" euler="90 0 0"/>
      <body pos="0.2 0 0"><joint axis="0 0 1"/><geom size="0.04" pos="0 0 -0.2"/>
        <body><joint axis="1 0 0"/><geom size="0.04" pos="0 0 -0.9"/></body></body>
      </body></worldbody></mujoco>""")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    lowest, found = placement.measure_foot(SimpleNamespace(mj_model=model, mj_data=data))
    assert (lowest, found) == pytest.approx((0.1 - 0.2 - 0.04, half), abs=2e-3)

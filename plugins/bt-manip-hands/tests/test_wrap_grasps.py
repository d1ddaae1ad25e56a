"""A hand wraps thumb and fingers around an object."""

from itertools import product

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip.exceptions import MotionError
from bt_manip.grippers import Solid
from bt_manip_hands.wrap_grasps import HandShape, WrapGraspGenerator, measure

DOWN = np.array([0.0, 0.0, -1.0])
SIGNS = np.array(list(product((-1.0, 1.0), repeat=3)))  # of a box's corners


def box(half, at, turn) -> tuple[Solid, np.ndarray]:
    """Return a block and its corners."""
    T = pin.SE3(pin.exp3(np.array(turn)), np.array(at))
    return Solid("box", np.array(half), T, 0.7), (SIGNS * half) @ T.rotation.T + T.translation


@pytest.mark.parametrize("closing", [(0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)])
@pytest.mark.parametrize("several", [False, True])
def test_thumb_and_fingers_are_beside_the_object_and_the_palm_is_clear_of_it(closing, several):
    """One solid is wrapped along its own axes, several along those of the object."""
    tip, palm, most = 0.02, 0.07, 0.085
    blocks = [box((0.03, 0.02, 0.045), (0.01, -0.02, 0.03), (0.4, -0.3, 0.8))]
    if several:
        blocks = [box((0.03, 0.02, 0.02), (0.01, -0.02, 0.03), (0.0, 0.0, 0.0)),
                  box((0.01, 0.025, 0.03), (0.025, -0.015, 0.04), (0.0, 0.0, 0.0))]  # fmt: skip
    corners, axes = np.concatenate([c for _, c in blocks]), blocks[0][0].T_os.rotation
    shape, down = HandShape(np.array(closing), tip, palm, most), np.array([0.11, 0.09, -0.99])
    solids = [solid for solid, _ in blocks]
    found = WrapGraspGenerator("it", solids, shape, np.zeros(3)).candidates(down)
    extent = np.ptp(corners @ axes, axis=0)
    used = set()
    for index, grasp in enumerate(found):
        R, p = grasp.T_ot.rotation, grasp.T_ot.translation
        across, z = R @ closing, R[:, 2]
        i, j = (int(np.abs(axes.T @ direction).argmax()) for direction in (across, z))
        assert abs(axes[:, i] @ across) == pytest.approx(1.0) and z @ down >= -0.1
        assert np.linalg.det(R) == pytest.approx(1.0) and abs(axes[:, j] @ z) == pytest.approx(1.0)
        assert grasp.width == pytest.approx(extent[i]) and extent[i] <= most - 0.008
        beside = (corners - p) @ np.cross(z, across)
        for along in ((corners - p) @ across, beside):  # centred
            assert along.min() == pytest.approx(-along.max())
        ahead = (corners - p) @ z
        back = 0.5 * (ahead.max() + ahead.min())
        nearest = max(0.0, tip + 0.005 - extent[j] / 2, extent[j] / 2 + 0.005 - palm)
        assert min(abs(back - nearest - more) for more in (0.0, 0.01, 0.02)) < 1e-9
        assert ahead.max() >= tip + 0.005 - 1e-9 and -ahead.min() <= palm - 0.005 + 1e-9
        assert found.costs["depth"][index] == pytest.approx(0.5 * back / (extent[j] / 2))
        used.add((i, j, *np.sign([axes[:, i] @ across, axes[:, j] @ z]), round(back - nearest, 6)))
    fits = [k for k in range(3) if extent[k] <= most - 0.008]
    expected = {
        (i, j, s, t, more)
        for i, j, s, t, more in product(fits, range(3), (-1, 1), (-1, 1), (0.0, 0.01, 0.02))
        if i != j and t * axes[:, j] @ down >= -0.1
        and max(0.0, tip + 0.005 - extent[j] / 2) + more <= extent[j] / 2
    }  # fmt: skip
    assert used == expected and len(found) == len(expected)


def test_an_object_that_does_not_fit_is_refused_with_its_width_and_the_hand():
    shape = HandShape(np.array([0.0, 1.0, 0.0]), 0.01, 0.08, 0.1)
    block = box((0.05, 0.06, 0.07), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))[0]
    message = "it is 100 mm wide, the hand takes 92 mm, 90 mm deep"
    with pytest.raises(MotionError, match=message):
        WrapGraspGenerator("it", [block], shape, np.zeros(3)).candidates(DOWN)


def test_a_hand_is_measured_at_the_corners_of_its_turned_geoms():
    halves = [(0.01, 0.02, 0.05), (0.02, 0.01, 0.04), (0.015, 0.01, 0.04), (0.05, 0.04, 0.02)]
    places = [(-0.05, 0.2, 0.0), (0.05, 0.02, 0.01), (0.06, -0.03, 0.0), (0.0, 0.0, -0.12)]
    turns = [(0.3, -0.2, 0.1), (0.1, 0.2, 0.3), (-0.2, 0.3, 0.0), (0.2, 0.1, -0.4)]
    geoms = "".join('<geom type="box" size="{} {} {}"/>'.format(*half) for half in halves)
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{geoms}</worldbody></mujoco>")
    blocks = [box(*block) for block in zip(halves, places, turns, strict=True)]
    poses = {index: solid.T_os for index, (solid, _) in enumerate(blocks)}
    corners = [points for _, points in blocks]
    shape = measure(model, poses, [0], [1, 2], [3], 0.1)
    assert shape.closing == pytest.approx((0.0, -1.0, 0.0))
    assert shape.tip == pytest.approx(max(corners[k][:, 2].max() for k in range(3)))
    assert shape.palm == pytest.approx(-corners[3][:, 2].max()) and shape.max_width == 0.1

"""A region of poses: bounds of positions and yaw, or squares."""

import numpy as np
import pytest

from bt_manip.cell import CellError, Region
from bt_manip.spatial import pose


@pytest.mark.parametrize(
    ("bounds", "message"),
    [
        ({"x": (0.4, 0.2)}, "x goes from low to high, got .0.4, 0.2."),
        ({"yaw": (0.0, float("nan"))}, "yaw goes from low to high"),
        ({"z": (1.0,)}, "z goes from low to high"),
    ],
)
def test_a_region_that_is_none_is_refused(bounds, message):
    with pytest.raises(CellError, match=message):
        Region(**{"x": (0, 1), "y": (0, 1), "z": (0, 1), **bounds})


@pytest.mark.parametrize("squares", [(), ((0.3, 0.1), (0.2, -0.2))])
def test_the_middle_of_an_object_is_sampled_over_the_region_at_any_yaw(squares):
    region = Region((0.2, 0.4), (-0.1, 0.1), (0.0, 0.0), yaw=(-3.0, 3.0), middle=(0.2, -0.1),
                    squares=squares, side=0.1)  # fmt: skip
    rng, middles = np.random.default_rng(0), []
    for _ in range(50):
        T_wo = region.sample(rng)
        middles.append(T_wo.act(np.array([0.2, -0.1, 0.0]))[:2])
        assert region.covers(T_wo, slack=1e-9)
    lengths = (0.2, 0.4) if squares else (0.2, 0.2)
    assert np.ptp(middles, axis=0) == pytest.approx(lengths, abs=0.02)
    low, high = ([0.25, 0.05], [0.35, 0.15]) if squares else ([0.2, -0.1], [0.4, 0.1])
    for axis, bound, sign in ((0, low, -1), (0, high, 1), (1, low, -1), (1, high, 1)):
        for offset, inside in ((0.9e-3, True), (1.1e-3, False)):  # a millimetre beside counts
            middle = np.array([0.3, 0.1, 7.0]) if squares else np.array([0.3, 0.0, 7.0])
            middle[axis] = bound[axis] + sign * offset
            turn = pose((0.0, 0.0, 0.0), (0.8, 0.3, -0.2, 0.5))
            assert region.covers(pose(middle) * turn * pose((-0.2, 0.1, 0.0))) is inside


def test_height_and_yaw_are_drawn_between_their_bounds_and_equal_bounds_without_chance():
    region, rng = (
        Region((0.2, 0.2), (0.1, 0.1), (0.5, 0.9), yaw=(-0.5, 2.5)),
        np.random.default_rng(0),
    )
    poses = [region.sample(rng) for _ in range(100)]
    yaws = [np.arctan2(T.rotation[1, 0], T.rotation[0, 0]) for T in poses]
    for values, low, high in ((yaws, -0.5, 2.5), ([T.translation[2] for T in poses], 0.5, 0.9)):
        assert (min(values), max(values)) == pytest.approx((low, high), abs=0.05 * (high - low))
    assert {tuple(T.translation[:2]) for T in poses} == {(0.2, 0.1)}
    before = rng.bit_generator.state
    fixed = Region((0.2, 0.2), (0.1, 0.1), (0.5, 0.5), yaw=(0.6, 0.6)).sample(rng)
    assert fixed.isApprox(pose((0.2, 0.1, 0.5), (np.cos(0.3), 0.0, 0.0, np.sin(0.3))))
    assert rng.bit_generator.state == before

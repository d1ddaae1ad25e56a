"""Places for a suction cup lie on the surface of the solid, where a ray of MuJoCo meets it."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip.exceptions import MotionError
from bt_manip.grippers import Solid
from bt_manip_hands.suction.cup_grasps import CupGraspGenerator, places_on

RADIUS, AWAY = 0.012, 0.1  # [m]


def solid(kind, *size, at=(0.0, 0.0, 0.0), rotation=None):
    T = pin.SE3(np.eye(3) if rotation is None else rotation, np.array(at))
    return Solid(kind, np.array([*size, 0.0, 0.0][:3]), T, 0.7)


SIZES = {
    "sphere": (0.04,),
    "ellipsoid": (0.03, 0.04, 0.06),
    "capsule": (0.03, 0.05),
    "box": (0.03, 0.04, 0.05),
}


@pytest.mark.parametrize("kind", SIZES)
def test_a_ray_against_the_normal_meets_the_solid_at_the_place(kind):
    rotation = pin.exp3(np.array([0.4, -0.7, 0.3]))
    at, com = np.array([0.2, -0.1, 0.3]), np.array([0.21, -0.105, 0.32])
    quaternion = pin.Quaternion(rotation).coeffs()[[3, 0, 1, 2]]

    def text(values) -> str:
        return " ".join(map(str, values))

    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody><geom type="{kind}" size="{text(SIZES[kind])}" pos="{text(at)}" '
        f'quat="{text(quaternion)}"/></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    shape = solid(kind, *SIZES[kind], at=at, rotation=rotation)
    found = list(places_on(shape, com, RADIUS, np.array([0.0, 0.0, 1.0])))
    assert len(found) >= 6
    for point, normal in found:
        assert normal @ (point - at) > 0.0  # out of the solid
        geom = np.zeros(1, dtype=np.int32)
        start = point + AWAY * normal
        met = mujoco.mj_ray(model, data, start, -normal, None, 1, -1, geom, None)
        assert met == pytest.approx(AWAY, abs=1e-6)
        # Beside it the solid curves away alike on both sides: the normal is that of the surface.
        for side in np.linalg.svd(normal[None])[2][1:]:
            beside = [
                mujoco.mj_ray(model, data, start + step * side, -normal, None, 1, -1, geom, None)
                for step in (1e-3, -1e-3)
            ]
            assert beside[0] == pytest.approx(beside[1], abs=1e-5)


@pytest.mark.parametrize(("tilt", "lowest"), [(0.0, 0.0), (0.09, -0.09), (0.11, 0.0)])
def test_a_cup_approaches_a_block_to_0_2_mm_but_not_from_below(tilt, lowest):
    block, down = solid("box", 0.04, 0.03, 0.06), np.array([tilt, 0.0, -np.sqrt(1.0 - tilt**2)])
    found = CupGraspGenerator("block", [block], RADIUS, np.zeros(3)).candidates(down)
    approach = found.rotation[:, :, 2]
    cosines = approach @ down
    assert (cosines.max(), cosines.min()) == pytest.approx((-down[2], lowest))
    away = -np.sum(approach * found.position, axis=1)
    assert away == pytest.approx(np.abs(approach) @ (0.04, 0.03, 0.06) + 0.2e-3, abs=1e-9)
    assert found.costs["curvature"] == pytest.approx(0.0, abs=1e-12)


def test_a_ball_reaches_into_a_hollow_cup_and_costs_by_its_curvature():
    """The ball touches the inside of the lip, 3 mm within the radius."""
    ball, at, down = 0.04, np.array([0.1, -0.2, 0.3]), np.array([0.0, 0.6, -0.8])
    sag, inside = (ball - np.sqrt(ball**2 - r**2) for r in (RADIUS, RADIUS - 0.003))
    for hollow, depth in ((True, inside), (False, 0.0)):
        made = CupGraspGenerator("ball", [solid("sphere", ball, at=at)], RADIUS, at, hollow=hollow)
        found = made.candidates(down)
        away = found.position - at
        distance = np.linalg.norm(away, axis=1)
        assert distance == pytest.approx(ball + 0.2e-3 - depth, abs=0.3e-3)
        assert -away / distance[:, None] == pytest.approx(found.rotation[:, :, 2])
        assert found.costs["curvature"] == pytest.approx(0.3 * sag / (0.5 * RADIUS), abs=0.02)
        cosines = found.rotation[:, :, 2] @ down
        assert len(found) == len(np.unique(found.position.round(6), axis=0)) == 17
        assert (cosines.min(), cosines.max()) == pytest.approx((0.0, 1.0), abs=1e-9)
    with pytest.raises(MotionError, match="no face that a cup of 24 mm seals on"):
        small = solid("sphere", 1.2 * RADIUS, at=at)  # too deep at the lip
        CupGraspGenerator("ball", [small], RADIUS, at).candidates(down)


@pytest.mark.parametrize(
    "half, bump, fits",
    [
        (RADIUS + 1.5e-3, 0.0, False),
        (RADIUS + 2.5e-3, 0.8e-3, True),
        (RADIUS + 2.5e-3, 1.2e-3, False),
    ],
)
def test_a_lip_keeps_2_mm_from_the_edges_of_a_face_and_bumps_up_to_1_mm(half, bump, fits):
    down = np.array([0.0, 0.0, -1.0])
    bumps = [
        solid("box", 1e-3, 1e-3, bump, at=RADIUS * np.array([*side, 0.0]) + [0.0, 0.0, 0.1])
        for side in ((1, 0), (0, 1), (-1, 0), (0, -1))
        if bump
    ]
    post = solid("box", half, 0.03, 0.1)
    made = CupGraspGenerator("post", [post, *bumps], RADIUS, np.array([0.0, 0.0, 0.1]))
    heights = {round(height, 3) for height in made.candidates(down).position[:, 2]}
    assert (0.1 in heights) == fits


def test_places_on_a_face_are_below_the_centre_of_mass_at_its_centroid_and_between():
    rotation, at = pin.exp3(np.array([0.4, -0.7, 0.3])), np.array([0.2, -0.1, 0.3])
    com = np.array([0.01, -0.02, 0.005])
    block = solid("box", 0.03, 0.04, 0.012, at=at, rotation=rotation)
    found = list(places_on(block, rotation @ com + at, 0.02, np.array([0.0, 0.0, 1.0])))
    found = [(rotation.T @ (point - at), rotation.T @ normal) for point, normal in found]
    flat = {tuple(np.round(point, 6) + 0.0) for point, normal in found if abs(normal[2]) > 0.9}
    over = [(0.01, -0.02), (0.005, -0.01), (0.0, 0.0)]
    assert flat == {(x, y, z) for x, y in over for z in (0.012, -0.012)}
    sides = {int(np.abs(normal).argmax()) for point, normal in found if abs(normal[2]) < 0.9}
    assert sides == {0, 1}  # each of 1.4 and 1.9 thousand mm2; the cup of 1.26
    assert {2} == {
        int(np.abs(rotation.T @ normal).argmax())
        for _, normal in places_on(block, at, 0.025, np.array([0.0, 0.0, 1.0]))
    }


@pytest.mark.parametrize(("com", "height"), [(0.31, 0.31), (0.349, 0.35 - RADIUS - 2e-3)])
def test_a_cup_on_a_round_side_is_beside_the_centre_of_mass_but_not_beyond_its_ends(com, height):
    shape, up = solid("capsule", 0.03, 0.05, at=(0.1, 0.0, 0.3)), np.array([1.0, 0.0, 0.0])
    found = places_on(shape, np.array([0.1, 0.0, com]), RADIUS, up)
    sides = np.array([(*point, *normal) for point, normal in found if abs(normal[2]) < 1e-9])
    assert sides[:, 2] == pytest.approx(height)
    angles = np.degrees(np.arctan2(sides[:, 4], sides[:, 3]))
    assert np.sort(angles) == pytest.approx((-90.0, -45.0, 0.0, 45.0, 90.0), abs=1e-6)

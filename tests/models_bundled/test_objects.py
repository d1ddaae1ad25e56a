"""Table, basket and cube have their sizes and do what they are for."""

import mujoco
import numpy as np
import pytest


def hit(model: mujoco.MjModel, data: mujoco.MjData, start, direction, group: int) -> np.ndarray:
    """Return where a ray meets the geoms of one group."""
    groups = np.zeros(6, np.uint8)
    groups[group] = 1
    geom = np.zeros(1, np.int32)
    distance = mujoco.mj_ray(
        model, data, np.array(start, float), np.array(direction, float), groups, 1, -1, geom
    )
    assert distance >= 0
    return np.array(start) + distance * np.array(direction)


@pytest.mark.parametrize("group", [2, 3], ids=["as seen", "as touched"])
def test_the_table_s_surface_is_where_the_reference_task_has_it(scene, group):
    physics = scene(table=(0, 0, 0))
    model, data = physics.model.ptr, physics.data.ptr
    for x in (-0.749, 0.0, 0.749):
        for y in (-0.399, 0.0, 0.399):
            top = hit(model, data, (x, y, 2), (0, 0, -1), group)
            assert top[2] == pytest.approx(1.015)
    for side in (1, -1):
        end = hit(model, data, (2 * side, 0, 1), (-side, 0, 0), group)
        assert end[0] == pytest.approx(side * 0.75)
        edge = hit(model, data, (0, 2 * side, 1), (0, -side, 0), group)
        assert edge[1] == pytest.approx(side * 0.4)
        leg = hit(model, data, (2 * side, 0.38, 0.5), (-side, 0, 0), group)
        assert leg[0] == pytest.approx(side * 0.70)


def test_the_basket_has_its_real_size_and_taper(scene):
    physics = scene(basket=(0, 0, 0))
    model, data = physics.model.ptr, physics.data.ptr
    for side in (1, -1):
        for axis, low, high in ((0, 0.206, 0.233), (1, 0.130, 0.157)):
            for z in (0.002, 0.05, 0.1, 0.144):
                start, direction = np.array([0, 0, z]), np.zeros(3)
                start[axis], direction[axis] = side, -side
                outside = side * hit(model, data, start, direction, 3)[axis]
                expected = (low + (high - low) * z / 0.145) / 2
                assert outside == pytest.approx(expected, abs=1e-4)
    floor = hit(model, data, (0, 0, 1), (0, 0, -1), 3)
    assert floor[2] == pytest.approx(0.020)
    rim = hit(model, data, (0.113, 0, 1), (0, 0, -1), 3)
    assert rim[2] == pytest.approx(0.145, abs=1e-3)


def test_no_ray_from_inside_the_basket_gets_out_but_over_the_rim(scene):
    physics = scene(basket=(0, 0, 0))
    model, data = physics.model.ptr, physics.data.ptr
    rng = np.random.default_rng(5)
    for _ in range(1000):
        direction = rng.normal(size=3)
        direction[2] = -abs(direction[2])
        direction /= np.linalg.norm(direction)
        where = hit(model, data, (0, 0, 0.14), direction, 3)
        assert abs(where[0]) < 0.1165 and abs(where[1]) < 0.0785 and where[2] > 0.0199


def test_the_cube_is_a_solid_wooden_one_and_friction_is_the_reference_task_s(scene):
    model = scene(table=(0, 0, 0), cube=(0, 0, 2)).model.ptr
    body = model.body("cube/cube")
    assert body.mass[0] == pytest.approx(0.0565)
    np.testing.assert_allclose(body.inertia, 0.0565 * 0.05**2 / 6, rtol=1e-12)
    np.testing.assert_allclose(body.ipos, 0, atol=1e-15)
    for name, mu in (("table/table", 0.6), ("cube/cube", 1.0)):
        geoms = (model.geom_bodyid == model.body(name).id) & (model.geom_group == 3)
        np.testing.assert_array_equal(model.geom_friction[geoms, 0], mu)


@pytest.mark.parametrize(
    ("x", "y", "yaw"), [(0, 0, 0.0), (0.06, 0.015, np.pi / 4), (-0.06, -0.015, 0.3)]
)
def test_a_cube_dropped_into_the_basket_stays(scene, x, y, yaw):
    physics = scene(basket=(0, 0, 0), cube=(0, 0, 0))
    model, data = physics.model.ptr, physics.data.ptr
    data.qpos[:] = (x, y, 0.25, np.cos(yaw / 2), 0, 0, np.sin(yaw / 2))
    mujoco.mj_step(model, data, 1000)
    assert np.abs(data.qvel).max() < 5e-3
    assert abs(data.qpos[0]) < 0.095 and abs(data.qpos[1]) < 0.058
    # It lies flat on the floor: nothing in there can hold it up.
    assert data.qpos[2] == pytest.approx(0.045, abs=1e-3)


def test_a_cube_pushed_about_in_the_basket_does_not_get_out(scene):
    physics = scene(basket=(0, 0, 0), cube=(0, 0, 0.06))
    model, data = physics.model.ptr, physics.data.ptr
    rng = np.random.default_rng(2)
    for _ in range(20):
        data.qvel[:2] = rng.uniform(-0.8, 0.8, size=2)
        data.qvel[3:] = rng.uniform(-5, 5, size=3)
        mujoco.mj_step(model, data, 150)
        assert abs(data.qpos[0]) < 0.1 and abs(data.qpos[1]) < 0.07 and data.qpos[2] > 0.035


def test_a_cube_on_the_table_stays(scene):
    physics = scene(table=(0, 0, 0), cube=(0.3, 0.1, 1.04))
    model, data = physics.model.ptr, physics.data.ptr
    mujoco.mj_step(model, data, 200)
    before = data.qpos.copy()
    mujoco.mj_step(model, data, 500)
    np.testing.assert_allclose(data.qpos, before, atol=1e-5)
    assert data.qpos[2] == pytest.approx(1.04, abs=1e-4)
    assert np.abs(data.qvel).max() < 1e-4

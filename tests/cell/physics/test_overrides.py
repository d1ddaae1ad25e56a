"""What is altered differs from its model, in the physics and nowhere else, and stays so."""

import json

import numpy as np
import pinocchio as pin
import pytest
from dm_control import composer, mjcf

from bt_manip.cell import Camera, Cell, CellError, Cube, OverlapError, Table, looking_at
from bt_manip.cell.objects import Bottle, Wall
from bt_manip.spatial import pose
from tests.cell.conftest import content

G = 9.81


@pytest.fixture
def cell():
    cell = Cell()
    with cell.editing():
        cell.add(Cube(mass=0.1, friction=1.0), pose((0.0, 0.0, 0.025)))
        cell.add(Bottle(), pose((0.5, 0.0, 0.0)))
    return cell


def mass(cell, name) -> float:
    return float(cell.model.body_subtreemass[cell.body_id(name)])


def test_a_heavier_thing_weighs_and_turns_as_much_more(cell):
    body = int(cell.model.body("cube/cube").id)
    inertia = cell.model.body_inertia[body].copy()
    assert inertia.all()
    cell.override("cube", mass=0.3)
    np.testing.assert_allclose(cell.model.body_inertia[body], 3 * inertia, rtol=1e-12)
    cell.step(500)
    assert cell.contacts.wrench("cube").force[2] == pytest.approx(0.3 * G, rel=0.01)
    assert cell.model.dof_M0[:3] == pytest.approx(0.3)  # what MuJoCo derives follows


def test_a_slippery_thing_slides_down_a_slope_that_held_it():
    slope = 0.3  # [rad]; its tangent is 0.31
    cell = Cell()
    with cell.editing():
        cell.arena.mjcf_model.find("geom", "floor").friction = (0.01,)
        cell.add(Cube(friction=0.5), pose((0.0, 0.0, 0.026)))
    cell.model.opt.gravity[:] = (G * np.sin(slope), 0.0, -G * np.cos(slope))
    cell.step(300)
    assert abs(cell.velocity("cube")[0]) < 5e-3
    cell.override("cube", friction=0.2)
    before = cell.velocity("cube")[0]
    cell.step(200)
    # Newton on a slope: a = g (sin - mu cos).
    expected = G * (np.sin(slope) - 0.2 * np.cos(slope))
    assert (cell.velocity("cube")[0] - before) / 0.2 == pytest.approx(expected, rel=0.05)


DRIVEN = """<mujoco><worldbody><body><geom size=".1"/>
<body><joint name="a"/><geom size=".1"/></body><body><joint name="b"/><geom size=".1"/></body>
</body></worldbody><tendon><fixed name="both"><joint joint="a" coef="1"/><joint joint="b" coef="2"/>
</fixed></tendon><actuator><position joint="a" kp="7" kv="2"/><motor tendon="both" gear="3"/>
<muscle joint="b" lengthrange="0 1"/><general joint="b" gaintype="affine" gainprm="3 4 5"
biastype="affine" biasprm="6 7 8"/></actuator></mujoco>"""


def test_a_gain_scales_the_forces_of_actuators_of_joints_and_tendons_of_one_object():
    cell = Cell()
    for name in ("it", "other"):
        model = mjcf.from_xml_string(DRIVEN)
        cell.add(composer.ModelWrapperEntity(model), pose((0, 0, 1)), name=name, overlap=1.0)
    nominal = cell.model.actuator_gainprm.copy(), cell.model.actuator_biasprm.copy()
    factors = np.array([0.5, 2.0, 3.0])
    cell.override("it", gain=factors)
    for found, before in zip(
        (cell.model.actuator_gainprm, cell.model.actuator_biasprm), nominal, strict=True
    ):
        expected = before.copy()
        expected[[0, 1, 3], :3] *= factors[:, np.newaxis]  # that of a muscle is none
        assert found == pytest.approx(expected)


def test_dry_friction_holds_a_load_below_it_nearly_without_slip():
    """With MuJoCo's defaults a cube of 57 g slips at 0.9 m/s under 50 N."""
    cell = Cell()
    with cell.editing():
        for x in (0.0, 1.0):
            cell.add(Cube(), pose((x, 0.0, 1.0)))
    given = np.array([60.0, 0.0, 60.0, 0.0, 0.0, 0.0])
    cell.override("cube_1", joint_friction=given)
    model, nominal = cell.model, cell.nominal_model
    assert model.dof_frictionloss.tolist() == [0.0] * 6 + given.tolist()
    raised = np.arange(12)[6:][given > 0.0]
    others = np.delete(np.arange(12), raised)
    for name in ("dof_solimp", "dof_solref"):
        assert (getattr(model, name)[others] == getattr(nominal, name)[others]).all()
    cell.data.qfrc_applied[6] = 50.0
    cell.step(300)
    assert cell.velocity("cube_1")[0] == pytest.approx(0.18e-3, rel=0.2)
    assert cell.pose("cube").translation[2] < 0.7 and cell.pose("cube_1").translation[2] > 0.999


def test_of_factors_and_rotations_the_nominal_value_changes_nothing(cell):
    before = content(cell.model)
    for name, key in (("light:key", "brightness"), ("camera:overview", "rotation")):
        nominal = cell.nominal(name, key)
        assert np.unique(nominal).tolist() == [float(key == "brightness")]
        cell.override(name, **{key: nominal})
    assert content(cell.model) == before


def test_lights_and_cameras_are_altered_by_name(cell):
    cell.add(Camera(), looking_at((1.0, 0.0, 1.0), (0.0, 0.0, 0.0)))
    specular = cell.model.light("key").specular.copy()
    cell.override("light:key", brightness=0.5, colour=(1.0, 0.8, 0.6), direction=(0, 3, -4))
    light, overview = cell.model.light("key"), cell.model.camera("overview")
    np.testing.assert_allclose(light.diffuse, (0.5, 0.4, 0.3), rtol=1e-6)
    np.testing.assert_allclose((*light.dir, *light.specular), (0, 0.6, -0.8, *(0.5 * specular)))
    expected = pose((0, 0, 0), overview.quat).rotation @ pin.exp3(np.array([0.2, -0.3, 0.6]))
    cell.override("camera:overview", fovy=50.0, rotation=(0.2, -0.3, 0.6))
    np.testing.assert_allclose(pose((0, 0, 0), overview.quat).rotation, expected, atol=1e-9)
    cell.override("camera:camera", rotation=(0.0, 0.0, np.pi / 2))  # an entity, by its own name
    with pytest.raises(CellError, match="'camera' cannot be overridden: it has no collision geom"):
        cell.override("camera", friction=0.5)
    assert cell.model.camera("overview").fovy == 50.0
    np.testing.assert_allclose(cell.model.camera("camera/eye").quat, (0.5**0.5, 0, 0, 0.5**0.5))


def test_colours_take_the_place_of_materials(cell):
    cell.override("cube", colour=(0.2, 0.4, 0.6))
    seen = [g for g in range(cell.model.ngeom) if cell.model.geom(g).name.startswith("cube/")]
    seen = [g for g in seen if cell.model.geom_group[g] <= 2]
    np.testing.assert_allclose(cell.model.geom_rgba[seen[0]], (0.2, 0.4, 0.6, 1.0), rtol=1e-6)
    assert cell.model.geom_matid[seen[0]] == -1


def test_overrides_change_neither_the_state_nor_what_can_be_known_of_the_things(cell):
    cell.step(10)
    before, state = content(cell.model), cell.state_bytes()
    cell.override("cube", mass=0.3, friction=0.2)
    cell.override("light:key", brightness=0.1)
    assert cell.state_bytes() == state
    assert content(cell.nominal_model) == before
    assert content(cell.model) != before
    cell.override("cube", mass=None, friction=None)
    cell.override("light:key", brightness=None)
    assert content(cell.model) == before
    assert cell.overrides == {}


def test_alterations_stay_when_other_things_come_and_go_and_go_with_the_thing(cell):
    cell.override("cube", mass=0.3)
    cell.add(Cube(mass=0.1), pose((1.0, 0.0, 0.025)))
    assert mass(cell, "cube") == pytest.approx(0.3)
    assert mass(cell, "cube_1") == pytest.approx(0.1)
    cell.remove("cube_1")  # the physics without it has been compiled before
    assert mass(cell, "cube") == pytest.approx(0.3)
    assert cell.nominal("cube", "mass") == pytest.approx(0.1)
    cell.remove("cube")
    cell.add(Cube(mass=0.1), pose((0.0, 0.0, 0.025)))
    assert mass(cell, "cube") == pytest.approx(0.1)
    assert cell.overrides == {}


def test_a_change_that_fails_leaves_the_alterations_as_they_were(cell):
    cell.override("cube", mass=0.3)
    cell.initial_overrides = lambda name, entity, model: {"mass": -1.0}
    with pytest.raises(CellError, match=r"mass of 'wall' is a number above 0 .* \[kg\], got -1"):
        cell.add(Wall(), pose((2.0, 0.0, 0.0)))
    with pytest.raises(CellError), cell.editing():
        cell.remove("cube")
        cell.add(Wall(), pose((2.0, 0.0, 0.0)))
    assert cell.overrides == {"cube": {"mass": 0.3}}
    assert list(cell.entities) == ["cube", "bottle"]
    cell.step(10)


def test_a_snapshot_brings_alterations_back_bit_for_bit(cell):
    cell.override("cube", mass=0.3, friction=0.4)
    cell.override("light:fill", brightness=2.0)
    cell.step(20)
    snapshot = json.loads(json.dumps(cell.snapshot()))
    cell.step(30)
    future = cell.state_bytes()
    made = {"cube": Cube, "bottle": Bottle}
    other = Cell()
    other.initial_overrides = lambda *_: {"mass": 7.0}  # is not asked of what comes back
    other.restore(snapshot, lambda entry: made[entry["kind"]](**entry["parameters"]))
    assert other.overrides == snapshot["altered"]
    other.step(30)
    assert other.state_bytes() == future
    cell.override("cube", mass=None)
    cell.restore(snapshot)
    cell.step(30)
    assert cell.state_bytes() == future


IMPOSSIBLE = [
    ("cub", {"mass": 1.0}, "there is no 'cub' in the cell; did you mean 'cube'"),
    ("light:kay", {"brightness": 1.0}, "no light 'kay' in the cell; did you mean 'key'"),
    ("camera:over", {"fovy": 1.0}, "no camera 'over' in the cell; did you mean 'overview'"),
    ("cube", {"mas": 1.0}, "'mas' of an entity cannot be overridden; did you mean 'mass'"),
    ("cube", {"mass": 0.0}, r"the mass of 'cube' is a number above 0 .* \[kg\], got 0.0"),
    ("cube", {"mass": 1.1e10}, "is a number above 0"),
    ("cube", {"mass": (1.0, 2.0)}, "is a number above 0"),
    ("cube", {"joint_friction": [0.0] * 5 + [-0.1]}, "a number of at least 0 for each"),
    ("cube", {"colour": (0.1, -0.1, 0.0)}, "3 or 4 numbers from 0 to 1"),
    ("cube", {"mass": float("nan")}, "is a number above 0"),
    ("cube", {"mass": 0.3, "friction": -1.0}, "the friction of 'cube' is a positive number"),
    ("cube", {"colour": (2.0, 0.0, 0.0)}, "3 or 4 numbers from 0 to 1"),
    ("cube", {"gain": 1.1}, "the gain of 'cube' cannot be overridden: it has no actuators"),
    ("camera:overview", {"fovy": 0.0}, r"between 0 and 180 \[degrees\], got 0"),
    ("camera:overview", {"fovy": 180.0}, r"between 0 and 180 \[degrees\], got 180"),
    ("light:key", {"direction": (0, 0, 0)}, "not all 0"),
]


def test_what_cannot_be_altered_is_one_error_and_alters_nothing(cell):
    before = content(cell.model)
    for thing, values, message in IMPOSSIBLE:
        with pytest.raises(CellError, match=message):
            cell.override(thing, **values)
        assert content(cell.model) == before
        assert cell.overrides == {}


def test_a_thing_is_moved_to_rest_and_all_else_keeps_its_state(cell):
    cell.add(Cube(), pose((1.0, 0.0, 0.025)))
    cell.data.qvel[:] = 0.1
    generation, T_wo = cell.generation, pose((0.0, 1.0, 0.3), (0.1, 0.5, -0.3, 0.7))
    others = [(cell.pose(name), cell.velocity(name).tolist()) for name in ("cube", "cube_1")]
    cell.move("bottle", T_wo)  # between the others in the state
    assert cell.generation == generation
    assert cell.pose("bottle").isApprox(T_wo) and not cell.velocity("bottle").any()
    assert others == [
        (cell.pose(name), cell.velocity(name).tolist()) for name in ("cube", "cube_1")
    ]


def test_a_fixed_thing_is_moved_too_and_stays_moved_in_snapshots(cell):
    cell.add(Table(), pose((2.0, 0.0, 0.0)))
    there = pose((2.0, 0.5, 0.0))
    cell.move("table", there)
    assert cell.pose("table") == there
    assert cell.data.xpos[cell.body_id("table")][1] == 0.5
    snapshot = cell.snapshot()
    cell.move("table", pose((2.0, -0.5, 0.0)))
    cell.restore(snapshot, lambda entry: Table())
    assert cell.pose("table") == there


def test_nothing_is_moved_into_something_else(cell):
    cell.add(Wall(), pose((2.0, 0.0, 0.0)))
    before, places = cell.state_bytes(), {n: cell.pose(n) for n in cell.entities}
    for name in ("cube", "wall"):
        with pytest.raises(OverlapError, match=f"'{name}' cannot be moved: '.*' would be"):
            cell.move(name, pose((0.5, 0.0, 0.03)))
    assert cell.state_bytes() == before
    assert {n: cell.pose(n) for n in cell.entities} == places
    cell.step(10)


def test_a_thing_that_takes_the_name_of_another_does_not_take_its_state(cell):
    cell.data.qvel[:] = 1.0
    there = pose((0.0, 0.0, 0.5))
    with cell.editing():
        cell.remove("cube")
        cell.add(Cube(), there)
    assert not cell.velocity("cube").any()
    assert cell.pose("cube").isApprox(there, 1e-12)
    assert cell.velocity("bottle").all()


def test_a_friction_of_several_parts_is_that_of_the_roughest_and_scales_the_others():
    root = mjcf.RootElement(model="mixed")
    for x, friction in ((0.0, 0.8), (0.3, 0.4)):
        root.worldbody.add("geom", size=(0.1,), pos=(x, 0, 0), mass=1, friction=(friction,))
    cell = Cell()
    cell.add(composer.ModelWrapperEntity(root), pose((0.0, 0.0, 0.2)), name="mixed", free=True)
    cell.override("mixed", friction=0.6)
    geoms = cell.model.geom_bodyid == cell.body_id("mixed")
    assert cell.model.geom_friction[geoms, 0] == pytest.approx([0.6, 0.3])

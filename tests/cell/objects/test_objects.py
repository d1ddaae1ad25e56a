"""Each registered object is what its name says; its package holds it to the contract."""

from itertools import product

import mujoco
import numpy as np
import pytest

from bt_manip.cell import Cell, CellError, Cube, objects
from bt_manip.plugins import load_plugins
from bt_manip.spatial import pose

PARTS = load_plugins(entry_points=()).parts
NAMES = PARTS.objects.names()
GRASPABLE = [n for n in NAMES if PARTS.objects.get(n).category == "graspable"]
CATEGORIES = {"graspable", "container", "surface", "obstacle", "socket", "sensor"}


def standing(thing, free=False):
    """Give the compiled model, the state and the solid geoms of a thing 1 m above the floor."""
    cell = Cell()
    cell.add(thing, pose((0, 0, 1)), free=free)
    model = cell.model
    return model, cell.data, np.flatnonzero((model.geom_contype > 0) & (model.geom_bodyid > 0))


def distance(built, start, ray):
    """Give the distance from a point above the origin of a thing to it along a ray [m]."""
    model, data, _ = built
    hit = np.zeros(1, np.int32)
    start, ray = np.add(start, (0, 0, 1)), np.array(ray, float)
    return mujoco.mj_ray(model, data, start, ray, None, 1, -1, hit)


@pytest.mark.parametrize("name", NAMES)
def test_every_object_weighs_what_it_says_and_no_more_than_steel_nor_is_slippery_as_ice(name):
    thing = PARTS.objects.create(name)
    given = {key: value for key, value in thing.parameters.items() if value is not None}
    assert PARTS.objects.create(name, **given).parameters == thing.parameters
    assert thing.category in CATEGORIES
    model, _, solid = standing(thing, free=True)
    assert model.body_mass.sum() == pytest.approx(thing.mass, rel=1e-6)
    for body in np.flatnonzero(model.body_mass > 0.0):
        # The box with this inertia; of rods and shells it is larger than what they fill.
        x, y, z = model.body_inertia[body] * 6.0 / model.body_mass[body]
        squares = np.array([y + z - x, x + z - y, x + y - z])
        volume = float(np.sqrt(np.maximum(squares, 1e-12).prod()))
        assert model.body_mass[body] < 8000.0 * volume
    assert np.all(model.geom_friction[solid, 0] > 0.1)


@pytest.mark.parametrize("name", GRASPABLE)
def test_what_is_graspable_is_free_and_fits_between_fingers(name):
    thing = PARTS.objects.create(name)
    assert thing.free
    built, grip = standing(thing), (0, 0, thing.centre_offset[2])
    widths = [
        2.0 - sum(distance(built, side * d + grip, -side * d) for side in (1.0, -1.0))
        for d in np.eye(3)[:2]
    ]
    assert 0 < min(widths) <= 0.075


@pytest.mark.parametrize("name", NAMES)
def test_impossible_parameters_are_one_error_each(name):
    for key, value in PARTS.objects.create(name).parameters.items():
        wrong = (0.0, -1.0, float("nan"))[key == "offset" :]  # no offset is possible
        if key == "colour":
            wrong = ((2, 0, 0),)
        for one in wrong if key != "points" else ():
            impossible = [one, *value[1:]] if isinstance(value, list) else one
            with pytest.raises(CellError, match=key):
                PARTS.objects.create(name, **{key: impossible})


def test_parameters_reach_the_compiled_model_and_make_the_same_object_again():
    cube = Cube(size=0.1, mass=0.3, friction=0.3, colour=(1, 0, 0))
    assert Cube(**cube.parameters).mjcf_model.to_xml_string() == cube.mjcf_model.to_xml_string()
    model, _, _ = standing(cube, free=True)
    body = model.body("cube/cube")
    assert body.mass[0] == pytest.approx(0.3)
    np.testing.assert_allclose(body.inertia, 0.3 * 0.1**2 / 6)  # of a solid one
    np.testing.assert_allclose(model.geom("cube/box").friction[0], 0.3)
    np.testing.assert_allclose(model.geom("cube/wood").rgba, (1, 0, 0, 1))
    assert (Cube().size, Cube().mass) == pytest.approx((0.05, 0.0565))  # as in the reference task
    basket, _, _ = standing(objects.Basket(mass=1.5), free=True)
    assert basket.body_mass.sum() == pytest.approx(1.5)


def test_blocks_are_of_the_colour_that_their_name_says():
    for index, kind in enumerate((objects.RedBlock, objects.GreenBlock, objects.BlueBlock)):
        assert int(standing(kind())[0].geom_rgba[-1, :3].argmax()) == index


def test_a_mesh_has_the_inertia_of_its_hull():
    corners = list(product((-0.1, 0.1), (-0.05, 0.05), (-0.02, 0.02)))
    model, _, _ = standing(objects.ConvexMesh(points=corners, mass=0.6), free=True)
    sizes = np.array([0.2, 0.1, 0.04])
    expected = 0.6 / 12 * (np.sum(sizes**2) - sizes**2)
    inertia = model.body("mesh/mesh").inertia
    np.testing.assert_allclose(sorted(inertia), sorted(expected), rtol=1e-5)


CORNER = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


@pytest.mark.parametrize(
    "points",
    [
        [],
        [[0, 0], [1, 1]],
        [[0, 0, 0], [1, 0, 0]] * 3,
        [*CORNER, [0, 0, np.nan]],
        [*CORNER, [1, 1, 1e-7]],
    ],
)
def test_points_without_a_volume_are_no_mesh(points):
    with pytest.raises(CellError, match="not in one plane|list of points"):
        objects.ConvexMesh(points=points)


def test_a_foil_of_a_fifth_of_a_millimetre_is_a_mesh():
    corners = list(product((-0.1, 0.1), (-0.05, 0.05), (-1e-4, 1e-4)))
    assert objects.ConvexMesh(points=corners, mass=0.01).rest_height == pytest.approx(1e-4)


@pytest.mark.parametrize(
    ("thing", "lengths"),
    [
        (objects.Bin(size=(0.3, 0.2, 0.15)), (0.3, 0.2, 0.15)),
        (objects.Tray(size=(0.3, 0.2, 0.04)), (0.3, 0.2, 0.04)),
        (objects.Shelf(size=(0.25, 0.5, 0.6)), (0.25, 0.5, 0.6)),
        (objects.Wall(size=(0.05, 0.4, 0.3)), (0.05, 0.4, 0.3)),
        (objects.Bottle(radius=0.03, height=0.2), (0.06, 0.06, 0.2)),
        (objects.Cylinder(radius=0.03, height=0.07), (0.06, 0.06, 0.07)),
        (objects.Sphere(radius=0.03), (0.06, 0.06, 0.06)),
        (objects.Box(size=(0.05, 0.06, 0.07)), (0.05, 0.06, 0.07)),
        (objects.RedBlock(size=0.05), (0.05, 0.05, 0.05)),
        (objects.Capsule(radius=0.02, length=0.05), (0.09, 0.04, 0.04)),
        (objects.ConvexMesh(), (0.04, 0.04, 0.04)),
        (objects.Mug(radius=0.03, height=0.08), (0.0865, 0.06, 0.08)),  # with its handle
        (
            objects.ConvexMesh(points=list(product((-0.05, 0.05), (-0.03, 0.03), (-0.01, 0.03)))),
            (0.1, 0.06, 0.04),
        ),
    ],
    ids=lambda given: getattr(given, "kind", ""),
)
def test_things_are_as_long_wide_and_high_as_they_say(thing, lengths):
    model, data, solid = standing(thing)
    corners = np.array(list(product((-1, 1), repeat=3)))
    boxes = model.geom_aabb[solid, None, :3] + corners * model.geom_aabb[solid, None, 3:]
    turned = boxes @ data.geom_xmat[solid].reshape(-1, 3, 3).swapaxes(1, 2)
    points = np.concatenate(data.geom_xpos[solid, None] + turned)
    assert np.ptp(points, axis=0) == pytest.approx(lengths, rel=0.02)  # polygons for circles
    assert np.ptp(points[:, 2]) == pytest.approx(lengths[2])
    assert points[:, 2].min() == pytest.approx(1.0 - getattr(thing, "rest_height", 0.0))


BLOCK = (0.04, 0.045, 1.0)
PYRAMID = [
    [x, y, z]
    for z, half in ((-0.02, 0.02), (0.02, 0.017))
    for x, y in product((-half, half), repeat=2)
]
DEFAULTS = {  # dimensions [m], mass [kg] and friction
    "bin": ([0.3, 0.22, 0.16], 0.008, 0.8, 0.6),
    "block": BLOCK, "red_block": BLOCK, "green_block": BLOCK, "blue_block": BLOCK,
    "yellow_block": BLOCK,
    "bottle": (0.034, 0.2, 0.3, 0.8),
    "box": ([0.06, 0.04, 0.04], 0.1, 1.0),
    "camera": (45.0, 320, 240),
    "can": (0.033, 0.1, 0.2, 0.7),
    "capsule": (0.018, 0.06, 0.06, 1.0, 5e-4),
    "cylinder": (0.02, 0.05, 0.1, 1.0),
    "mesh": (PYRAMID, 0.08, 1.0),
    "mug": (0.032, 0.085, 0.004, 0.2, 0.7),
    "shelf": ([0.25, 0.6, 0.7], 3, 0.015, 6.0, 0.6),
    "sphere": (0.025, 0.05, 1.0, 5e-4),
    "tray": ([0.34, 0.24, 0.03], 0.006, 0.4, 0.6),
    "wall": ([0.04, 0.4, 0.4], 8.0, 0.6),
}  # fmt: skip


@pytest.mark.parametrize("name", DEFAULTS)
def test_saved_scenes_may_rely_on_the_defaults_of_objects(name):
    parameters = PARTS.objects.create(name).parameters
    assert (*(v for key, v in parameters.items() if key != "colour"),) == DEFAULTS[name]


def test_a_table_has_the_given_top_and_height_and_legs_as_far_inside_as_usual():
    usual, table = objects.Table(), objects.Table(size=(1.0, 1.2), height=0.7)
    assert usual.surface_height == 1.015 and table.surface_height == pytest.approx(0.7)
    (before, _, _), (model, _, _) = standing(usual), standing(table)
    top = model.geom("table/top")
    assert (*(top.pos - top.size), *(top.pos + top.size)) == pytest.approx(
        (-0.5, -0.6, 0.67, 0.5, 0.6, 0.7)
    )
    for i in range(4):
        leg, old = (m.geom(f"table/leg{i}") for m in (model, before))  # of a top of 1.5 x 0.8 m
        moved = [*(np.sign(old.pos[:2]) * (-0.25, 0.2)), -0.315 / 2]
        assert leg.pos == pytest.approx(old.pos + moved)
        assert leg.size == pytest.approx(old.size - (0.0, 0.315 / 2, 0.0))
    for wrong in ({"size": (1.0,)}, {"size": (0.1, 1.0)}, {"height": 0.09}):
        with pytest.raises(CellError, match="size|height"):
            objects.Table(**wrong)
    objects.Table(size=(0.2, 0.2), height=0.1)


def test_a_bottle_tapers_in_even_steps_from_its_belly_to_its_neck():
    bottle = standing(objects.Bottle(radius=0.03, height=0.2))
    widths = [
        1.0 - distance(bottle, (1, 0, 0.2 * part), (-1, 0, 0))
        for part in (0.01, 0.54, 0.56, 0.59, 0.6, 0.63, 0.64, 0.67, 0.69, 0.99)
    ]
    steps = np.repeat([1.0, 0.9, 0.73, 0.56, 0.45], 2)
    assert widths == pytest.approx(0.03 * steps)


def test_a_shelf_has_its_boards_at_even_heights_between_walls_and_is_open_in_front():
    shelf = objects.Shelf(size=(0.2, 0.5, 0.7), boards=4, thickness=0.025)
    assert (*shelf.levels, shelf.surface_height) == pytest.approx((0.025, 0.25, 0.475, 0.7, 0.7))
    built = standing(shelf)
    for level in shelf.levels:
        assert distance(built, (0.02, 0.1, level + 0.1), (0, 0, -1)) == pytest.approx(0.1)
    assert distance(built, (-1, 0.2, 0.2), (1, 0, 0)) == pytest.approx(1 + 0.1 - 0.025)
    for side in (-1, 1):
        assert distance(built, (-0.05, 0, 0.2), (0, side, 0)) == pytest.approx(0.25 - 0.025)
    assert built[0].geom("shelf/board_1").size == pytest.approx([0.1, 0.225, 0.0125])
    for boards in (1, 101):
        with pytest.raises(CellError, match="boards must be a whole number from 2 to 100"):
            objects.Shelf(boards=boards)
    assert len(objects.Shelf(boards=100).levels) == 100


def test_a_mug_is_open_above_and_in_its_handle():
    mug = standing(objects.Mug(radius=0.03, height=0.08, wall=0.005))
    for x, top in ((0.0, 0.005), (0.0275, 0.08), (-0.0275, 0.08), (0.04, 0.0645), (0.052, 0.0645)):
        assert distance(mug, (x, 0, 1), (0, 0, -1)) == pytest.approx(1 - top)
    for z in (0.02, 0.04, 0.06):
        assert distance(mug, (0, 0, z), (1, 0, 0)) == pytest.approx(0.025, abs=1e-6)
        assert distance(mug, (1, 0, z), (-1, 0, 0)) == pytest.approx(1 - 0.0565)
    for x in (0.04, 0.052):
        assert distance(mug, (x, 0, -1), (0, 0, 1)) == pytest.approx(1 + 0.0155)
        assert distance(mug, (x, 1, 0.06), (0, -1, 0)) == pytest.approx(1 - 0.0045)
    for ray, reach in (((-1, 0, 0), 0.01), ((1, 0, 0), 0.0075)):
        assert distance(mug, (0.04, 0, 0.04), ray) == pytest.approx(reach, abs=1e-6)
    for up in (-1, 1):
        assert distance(mug, (0.04, 0, 0.04), (0, 0, up)) == pytest.approx(0.02 - 0.0045)


def test_tall_objects_are_gripped_3_cm_below_their_top_and_round_ones_do_not_roll_for_ever():
    for thing, z in (
        (objects.Box(size=(0.05, 0.06, 0.2)), 0.07), (objects.Box(size=(0.05, 0.06, 0.05)), 0.0),
        (objects.Can(height=0.1), 0.07), (objects.Mug(height=0.05), 0.025),
    ):  # fmt: skip
        assert thing.centre_offset == pytest.approx([0.0, 0.0, z])
    for kind in (objects.Sphere, objects.Capsule):
        model, _, (solid,) = standing(kind(friction=0.9, rolling_friction=2e-4))
        assert model.geom_condim[solid] == 6
        assert model.geom_friction[solid] == pytest.approx([0.9, 0.005, 2e-4])


@pytest.mark.parametrize("kind", [objects.Bin, objects.Tray])
def test_a_container_is_hollow_between_walls_of_its_thickness(kind):
    (x, y, z), wall = (0.3, 0.2, 0.05), 0.01
    built = standing(kind(size=(x, y, z), wall=wall))
    for u in np.linspace(-0.49 * x, 0.49 * x, 21):
        for v in np.linspace(-0.49 * y, 0.49 * y, 21):
            depth = distance(built, (u, v, 1.0), (0, 0, -1))
            inside = abs(u) < x / 2 - wall and abs(v) < y / 2 - wall
            assert 1.0 - depth == pytest.approx(wall if inside else z)


@pytest.mark.parametrize("kind", [objects.Bin, objects.Tray])
def test_a_container_has_the_inertia_of_a_box_without_its_inside(kind):
    size, wall, mass = np.array([0.3, 0.2, 0.05]), 0.01, 0.7
    model, _, _ = standing(kind(size=tuple(size), wall=wall, mass=mass), free=True)
    inside = size - [2 * wall, 2 * wall, wall]
    density = mass / (size.prod() - inside.prod())
    parts = [(density * size.prod(), size, size[2] / 2)]
    parts += [(-density * inside.prod(), inside, wall + inside[2] / 2)]
    height = sum(m * z for m, _, z in parts) / mass
    expected = sum(
        m * ((np.sum(lengths**2) - lengths**2) / 12 + np.array([1, 1, 0]) * (z - height) ** 2)
        for m, lengths, z in parts
    )
    body = model.body(f"{kind.kind}/{kind.kind}")
    assert body.ipos == pytest.approx([0.0, 0.0, height], abs=1e-12)
    assert np.sort(body.inertia) == pytest.approx(np.sort(expected))


def test_the_damping_of_a_servo_becomes_that_of_its_joint(tmp_path):
    (tmp_path / "lid.xml").write_text("""
        <mujoco><option integrator="implicitfast"/>
        <worldbody><body name="base"><geom size="0.1"/>
          <body><joint name="motor" damping="0.3"/><geom size="0.05"/></body>
          <body pos="0 0 0.2"><joint name="hinge" damping="0.2"/><geom size="0.05"/></body>
          <body><joint name="slide" type="slide" damping="0.1"/><geom size="0.05"/></body>
        </body></worldbody><actuator><motor joint="motor"/>
        <position joint="hinge" kp="9" kv="0.7" gear="2"/>
        <general joint="slide" biastype="affine" biasprm="1 -5 -0.4" gear="3"/></actuator>
        </mujoco>""")
    model, _, _ = standing(lid := objects.ModelObject(str(tmp_path / "lid.xml")))
    assert not lid.free  # what moves in itself stands
    assert model.dof_damping == pytest.approx([0.3, 0.2 + 0.7 * 2**2, 0.1 + 0.4 * 3**2])
    bias = [[0, 0, 0], [0, -9, 0], [1, -5, 0]]
    assert model.actuator_biasprm[:, :3] == pytest.approx(np.array(bias))


@pytest.mark.parametrize(
    ("size", "category", "told"),
    [
        ((0.3, 0.079, 0.4), "graspable", False),
        ((0.081, 0.3, 0.499), "thing", False),
        ((0.31, 0.501, 0.02), "surface", False),
        ((0.501, 0.29, 0.4), "thing", False),
        ((0.4, 0.31, 1.9), "surface", False),
        ((0.4, 2.1, 0.3), "surface", True),
        ((0.9e-3,) * 3, "graspable", True),
        ((1.1e-3,) * 3, "graspable", False),
    ],
)
def test_a_models_size_tells_whether_it_is_free_graspable_a_surface_or_in_another_unit(
    tmp_path, size, category, told
):
    x, y, z = 0.5 * np.array(size)
    (tmp_path / "it.xml").write_text(f"""<mujoco><worldbody><body pos="0.1 0.2 {3 * z}">
        <geom type="box" size="{x} {y} {z}" mass="1"/></body></worldbody></mujoco>""")
    thing = objects.ModelObject(str(tmp_path / "it.xml"))
    assert (thing.category, thing.free) == (category, max(size) < 0.5)
    assert any("reads millimetres" in text for text in thing.warnings) == told
    assert (thing.rest_height, thing.surface_height) == pytest.approx((-2 * z, 4 * z))
    assert thing.centre_offset == pytest.approx([0.1, 0.2, 3 * z])


@pytest.mark.parametrize(
    ("inertial", "touched", "free"),
    [
        ("", 0, False),
        ("", 1, True),
        ('<inertial pos="0 0 0" mass="0.1" diaginertia="1e-4 1e-4 1e-4"/>', 0, True),
    ],
)
def test_a_model_that_may_only_be_seen_is_fixed(tmp_path, inertial, touched, free):
    seen = f'density="{1000 * touched}" contype="{touched}" conaffinity="0"'
    (tmp_path / "it.xml").write_text(
        f'<mujoco><worldbody><body>{inertial}<geom size=".02" {seen}/></body></worldbody></mujoco>'
    )
    assert objects.ModelObject(str(tmp_path / "it.xml")).free == free


def test_a_new_mass_scales_all_masses_and_inertias_of_a_model(tmp_path):
    (tmp_path / "it.xml").write_text("""<mujoco><worldbody><body><geom size="0.05"/>
        <geom size="0.04" density="300"/><geom size="0.04" mass="0.2" pos="0 0 0.2"/>
        <body><inertial mass="0.3" pos="0 0 0" diaginertia="1e-3 2e-3 2.5e-3"/>
          <geom size="0.2" contype="0" conaffinity="0"/></body>
        <body><inertial mass="0.5" pos="0 0 0" fullinertia="1e-3 2e-3 2.5e-3 1e-4 0 0"/>
          <geom size="0.2"/></body></body></worldbody></mujoco>""")
    masses = 4.0 / 3.0 * np.pi * np.array([1000.0 * 0.05**3, 300.0 * 0.04**3])
    one, three = (objects.ModelObject(str(tmp_path / "it.xml"), mass=m) for m in (None, 3.0))
    assert one.mass == pytest.approx(masses.sum() + 0.2 + 0.3 + 0.5) and three.mass == 3.0
    before, after = standing(one, free=True)[0], standing(three, free=True)[0]
    for field in ("body_mass", "body_inertia"):
        scaled = getattr(before, field) * 3.0 / one.mass
        np.testing.assert_allclose(getattr(after, field), scaled, rtol=1e-9)


@pytest.mark.parametrize("kind", [objects.Basket, objects.Bin, objects.Tray])
@pytest.mark.parametrize("direction", [(1, 0), (-1, 0), (0, 1), (0, -1)])
def test_what_slides_to_a_side_of_a_container_stays_inside(kind, direction):
    cell = Cell()
    container = cell.add(kind(), pose((0, 0, 0)))
    cell.add(Cube(size=0.03), pose((0, 0, 0.04)))
    cell.model.opt.gravity[:2] = np.multiply(12.0, direction)  # as on a slope
    cell.step(600)
    assert cell.contacts.partners("cube") == [container]
    assert cell.pose("cube").translation[2] < 0.05


def test_a_mug_holds_what_is_dropped_into_it():
    cell = Cell()
    cell.add(objects.Mug(), pose((0, 0, 0)))
    cell.add(objects.Sphere(radius=0.01), pose((0, 0, 0.05)))
    cell.step(500)
    assert cell.contacts.partners("sphere") == ["mug"]
    assert cell.pose("sphere").translation[2] == pytest.approx(0.004 + 0.01, abs=2e-3)

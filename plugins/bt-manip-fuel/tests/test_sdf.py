"""SDF as MJCF: mass, inertia, shape and motion as they come out by hand."""

import sys
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip.cell.objects import ModelObject
from bt_manip.models import ModelError, load_model
from bt_manip_fuel.sdf import scopes

from . import fuel_server
from .fuel_server import bundled_sdf

MODEL = "<sdf version='1.10'><model name='m'>{}</model></sdf>"
INERTIAL = "<inertial><mass>{}</mass><inertia>{}</inertia></inertial>"


def compiled(tmp_path: Path, sdf: str, **options) -> mujoco.MjModel:
    """Convert and compile a document."""
    model, _ = converted(tmp_path, sdf, **options)
    return model


def converted(tmp_path: Path, sdf: str, **options) -> tuple[mujoco.MjModel, tuple[str, ...]]:
    path = tmp_path / "thing.sdf"
    path.write_text(sdf)
    return fuel_server.compiled(str(path), **options)


def refused(tmp_path: Path, inside: str) -> str:
    path = tmp_path / "thing.sdf"
    path.write_text(MODEL.format(inside))
    with pytest.raises(ModelError) as caught:
        load_model(str(path))
    return str(caught.value)


def link(name: str, inside: str = "", pose: str = "", relative_to: str = "") -> str:
    place = f"<pose relative_to='{relative_to}'>{pose}</pose>" if pose else ""
    return f"<link name='{name}'>{place}{inside}</link>"


def joint(name: str, kind: str, parent: str, child: str, inside: str = "") -> str:
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f"<joint name='{name}' type='{kind}'>{ends}{inside}</joint>"


def moments(ixx: float, iyy: float, izz: float) -> str:
    return f"<ixx>{ixx!r}</ixx><iyy>{iyy!r}</iyy><izz>{izz!r}</izz>"


def spatial_inertia(model: mujoco.MjModel) -> pin.Inertia:
    """Add up all bodies, seen from the world."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    total = pin.Inertia.Zero()
    for body in range(1, model.nbody):
        T = pin.SE3(data.ximat[body].reshape(3, 3), data.xipos[body])
        total += T.act(
            pin.Inertia(model.body_mass[body], np.zeros(3), np.diag(model.body_inertia[body]))
        )
    return total


@pytest.mark.parametrize(
    ("name", "static", "mass", "friction"),
    [("table", True, 24.0, 0.6), ("basket", False, 0.45, 0.6), ("cube", True, 0.0565, 1.0)],
)
def test_objects_of_the_task_keep_mass_inertia_shape_and_friction_and_are_free_or_fixed(
    tmp_path, name, static, mass, friction
):
    ours = mujoco.MjModel.from_xml_string(load_model(f"bundled:{name}").path.read_text())
    made = compiled(tmp_path, bundled_sdf(name, static=static))
    for one, other in zip(
        np.flatnonzero(ours.geom_contype), np.flatnonzero(made.geom_contype), strict=True
    ):
        assert made.geom_size[other] == pytest.approx(ours.geom_size[one])
        assert made.geom_pos[other] + made.body_pos[1] == pytest.approx(ours.geom_pos[one])
        assert abs(made.geom_quat[other] @ ours.geom_quat[one]) == pytest.approx(1)
        assert made.geom_friction[other, 0] == pytest.approx(friction)
    assert spatial_inertia(made).isApprox(spatial_inertia(ours), 1e-9)
    assert made.body_mass.sum() == pytest.approx(mass) and made.nv == 0
    assert ModelObject(str(tmp_path / "thing.sdf")).free is not static


M1, M2, L1, L2 = 1.0, 0.5, 0.4, 0.3  # [kg], [m]: thin rods
G = 9.81


def rod(mass: float, length: float) -> str:
    about = mass * length**2 / 12
    place = f"<pose>0 0 {-length / 2} 0 0 0</pose>"
    return f"<inertial>{place}<mass>{mass}</mass><inertia>{moments(about, about, 1e-6)}</inertia>" \
           "</inertial>"  # fmt: skip


def mass_matrix_by_hand(elbow: float) -> np.ndarray:
    """Two rods, in the joints' angles, the second one relative to the first."""
    i1, i2 = M1 * L1**2 / 3, M2 * L2**2 / 3
    c = M2 * L1 * L2 / 2 * np.cos(elbow)
    return np.array([[i1 + M2 * L1**2 + i2 + 2 * c, i2 + c], [i2 + c, i2]])


def test_the_double_pendulum_has_the_mass_matrix_and_the_energy_of_the_textbook(tmp_path):
    axis = "<axis><xyz>0 1 0</xyz></axis>"
    sdf = MODEL.format(
        link("upper", rod(M1, L1), "0 0 2 0 0 0")
        + link("lower", rod(M2, L2), f"0 0 {-L1} 0 0 0", "upper")
        + joint("shoulder", "revolute", "world", "upper", axis)
        + joint("elbow", "continuous", "upper", "lower", axis)
    )
    model = compiled(tmp_path, sdf)
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    data = mujoco.MjData(model)
    for q in ([0.0, 0.0], [0.3, -1.2], [2.0, 2.5]):
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        M = np.zeros((2, 2))
        mujoco.mj_fullM(model, data, M)
        assert pytest.approx(mass_matrix_by_hand(q[1]), rel=1e-9) == M
        z1 = 2 - L1 / 2 * np.cos(q[0])  # heights of the two middles
        z2 = 2 - L1 * np.cos(q[0]) - L2 / 2 * np.cos(sum(q))
        assert data.energy[0] == pytest.approx(M1 * G * z1 + M2 * G * z2, rel=1e-9)


def test_what_an_inertial_leaves_out_is_1_with_a_warning_of_the_mass(tmp_path):
    part = "<inertial><mass>2</mass><inertia><ixx>0.9</ixx></inertia></inertial>"
    path = tmp_path / "thing.sdf"
    path.write_text(MODEL.format(link("a") + link("b", "<inertial/>") + link("c", part)))
    made = load_model(str(path))
    model = mujoco.MjModel.from_xml_string(made.xml)
    for name, mass, inertia in (("a", 1, 1), ("b", 1, 1), ("c", 2, 0.9)):
        assert model.body(name).mass[0] == mass
        assert np.sort(model.body(name).inertia) == pytest.approx([inertia, 1, 1])
        warned = f"'{name}': the file gives no mass" in " ".join(made.warnings)
        assert warned is (name != "c")


def test_an_inertia_is_turned_with_its_pose(tmp_path):
    full = f"{moments(0.3, 0.35, 0.4)}<ixy>0.02</ixy><ixz>-0.03</ixz><iyz>0.04</iyz>"
    pose = "<pose>0.1 0.2 -0.1 0.3 -0.2 0.9</pose>"
    sdf = MODEL.format(
        link("a", f"<inertial>{pose}<mass>2</mass><inertia>{full}</inertia></inertial>")
    )
    T = pin.SE3(pin.rpy.rpyToMatrix(0.3, -0.2, 0.9), np.array([0.1, 0.2, -0.1]))
    I = np.array([[0.3, 0.02, -0.03], [0.02, 0.35, 0.04], [-0.03, 0.04, 0.4]])  # noqa: E741
    by_hand = T.act(pin.Inertia(2.0, np.zeros(3), I))
    assert spatial_inertia(compiled(tmp_path, sdf)).isApprox(by_hand, 1e-9)


@pytest.mark.parametrize(
    ("mass", "inertia", "words"),
    [
        (0, moments(1, 1, 1), "a mass must be a positive number of at most 1e+10 [kg], got 0"),
        (-2, moments(1, 1, 1), "got -2"),
        ("inf", moments(1, 1, 1), "got inf"),
        (1, moments(-1, 1, 1), "positive about every axis"),
        (1, moments(1, 1, 1) + "<ixy>5</ixy>", "positive about every axis"),
        ("heavy", "", "<mass>: expected 1 numbers, got 'heavy'"),
    ],
)
def test_a_body_that_cannot_be_is_refused_with_its_line(tmp_path, mass, inertia, words):
    message = refused(tmp_path, "\n\n" + link("a", INERTIAL.format(mass, inertia)))
    assert words in message
    assert "thing.sdf:3: " in message


@pytest.mark.parametrize("values", [(0.1, 0.1, 1.0), (1e-4, 1e-4, 2.1e-4)])
def test_principal_inertias_that_no_body_has_become_a_balls_with_a_warning(tmp_path, values):
    inertial = INERTIAL.format(1, moments(*values))
    model, warnings = converted(tmp_path, MODEL.format(link("a", inertial)))
    assert model.body("a").inertia == pytest.approx([sum(values) / 3] * 3)
    assert len(warnings) == 1 and "thing.sdf:1: link 'a': invalid principal" in warnings[0]


def test_a_flat_plate_and_a_thin_rod_are_bodies(tmp_path):
    for values in ((1.0, 2.0, 3.0), (1.0, 2.0, 3.0000009), (0.1, 0.1, 1e-9), (1 / 3, 1 / 6, 1 / 2)):
        sdf = MODEL.format(link("a", INERTIAL.format(1, moments(*values))))
        model, warnings = converted(tmp_path, sdf)
        assert np.sort(model.body("a").inertia) == pytest.approx(np.sort(values), rel=1e-6)
        assert warnings == ()


def test_an_automatic_inertial_is_that_of_the_shapes(tmp_path):
    shape = "<geometry><box><size>0.1 0.2 0.3</size></box></geometry>"
    inside = f"<inertial auto='true'/><collision name='c'><density>500</density>{shape}</collision>"
    inside += f"<gravity>false</gravity><visual name='v'>{shape}</visual>"  # of no mass
    model = compiled(tmp_path, MODEL.format(link("a", inside)))
    assert model.body("a").mass[0] == pytest.approx(500 * 0.1 * 0.2 * 0.3)
    assert model.body_gravcomp[1] == 1.0


SHAPES = {
    "<box><size>0.2 0.4 0.6</size></box>": ("BOX", [0.1, 0.2, 0.3]),
    "<sphere><radius>0.2</radius></sphere>": ("SPHERE", [0.2, 0, 0]),
    "<cylinder><radius>0.1</radius><length>0.6</length></cylinder>": ("CYLINDER", [0.1, 0.3, 0]),
    "<capsule><radius>0.1</radius><length>0.6</length></capsule>": ("CAPSULE", [0.1, 0.3, 0]),
    "<ellipsoid><radii>0.1 0.2 0.3</radii></ellipsoid>": ("ELLIPSOID", [0.1, 0.2, 0.3]),
    "<box/>": ("BOX", [0.5, 0.5, 0.5]),  # from here on by default, as SDFormat specifies it
    "<sphere/>": ("SPHERE", [1.0, 0.0, 0.0]),
    "<cylinder/>": ("CYLINDER", [1.0, 0.5, 0.0]),
    "<capsule/>": ("CAPSULE", [0.5, 0.5, 0.0]),
    "<ellipsoid/>": ("ELLIPSOID", [1.0, 1.0, 1.0]),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("tag", ["collision", "visual"])
def test_each_shape_has_its_measures_and_place(tmp_path, shape, tag):
    pose = "<pose degrees='true'>0.1 0.2 0.3 0 0 90</pose>"
    inside = f"<{tag} name='s'>{pose}<geometry>{shape}</geometry></{tag}>"
    model, warnings = converted(tmp_path, MODEL.format(link("a", inside)))
    kind, size = SHAPES[shape]
    assert model.geom_type[0] == int(getattr(mujoco.mjtGeom, f"mjGEOM_{kind}"))
    assert model.geom_size[0] == pytest.approx(size)
    assert model.geom_pos[0] == pytest.approx([0.1, 0.2, 0.3])
    assert model.geom_quat[0] == pytest.approx([0.5**0.5, 0, 0, 0.5**0.5])
    collides = tag == "collision"
    assert [model.geom_contype[0], model.geom_conaffinity[0]] == [collides, collides]
    assert model.geom_group[0] == (3 if collides else 2)
    assert model.body("a").mass[0] == 1.0
    assert warnings == ()


def test_a_cone_is_a_mesh_of_its_volume(tmp_path):
    shape = "<cone><radius>0.1</radius><length>0.3</length></cone>"
    inside = f"<inertial auto='true'/><collision name='c'><geometry>{shape}</geometry></collision>"
    model = compiled(tmp_path, MODEL.format(link("a", inside)))
    volume = np.pi * 0.1**2 * 0.3 / 3
    assert model.body("a").mass[0] == pytest.approx(1000 * volume, rel=5e-3)
    assert model.body("a").ipos == pytest.approx([0, 0, -0.15 + 0.3 / 4], abs=1e-3)


def test_a_plane_of_a_static_model_is_one_and_else_a_thin_box(tmp_path):
    shape = "<plane><normal>0 1 0</normal><size>2 4</size></plane>"
    inside = link("a", f"<collision name='c'><geometry>{shape}</geometry></collision>")
    still = compiled(tmp_path, MODEL.format(f"<static>true</static>{inside}"))
    assert still.geom_type[0] == int(mujoco.mjtGeom.mjGEOM_PLANE)
    data = mujoco.MjData(still)
    mujoco.mj_kinematics(still, data)
    assert data.geom_xmat[0].reshape(3, 3)[:, 2] == pytest.approx([0, 1, 0])
    moving, warnings = converted(tmp_path, MODEL.format(inside))
    assert moving.geom_type[0] == int(mujoco.mjtGeom.mjGEOM_BOX)
    assert "thin box" in warnings[0]


@pytest.mark.parametrize(
    "shape",
    ["<box><size>0 1 1</size></box>", "<sphere><radius>-1</radius></sphere>",
     "<cylinder><radius>1</radius><length>nan</length></cylinder>", "<box><size>1 1</size></box>",
     "<mesh><uri>nowhere.stl</uri></mesh>"],
)  # fmt: skip
def test_a_shape_that_cannot_be_is_refused_with_its_line(tmp_path, shape):
    inside = f"\n<collision name='c'><geometry>{shape}</geometry></collision>"
    assert "thing.sdf:2: " in refused(tmp_path, link("a", inside))


def test_meshes_are_scaled(tmp_path):
    import trimesh

    box = trimesh.creation.box((0.1, 0.2, 0.3))
    for kind in ("stl", "obj", "dae"):
        box.export(tmp_path / f"box.{kind}")
        mesh = f"<mesh><uri>box.{kind}</uri><scale>1 2 -1</scale></mesh>"
        shape = f"<collision name='c'><geometry>{mesh}</geometry></collision>"
        inside = link("a", f"<inertial auto='true'/>{shape}")
        model = compiled(tmp_path, MODEL.format(inside))
        assert model.body("a").mass[0] == pytest.approx(1000 * 0.1 * 0.4 * 0.3, rel=1e-6)


def test_a_mesh_collides_by_its_hull_or_by_convex_parts_that_are_kept(tmp_path, monkeypatch):
    pytest.importorskip("coacd", reason="coacd is not installed: pip install 'bt-manip[convex]'")
    import trimesh

    monkeypatch.setenv("BT_MANIP_CACHE", str(tmp_path / "kept"))
    rim = [(0, 0), (0.3, 0), (0.3, 0.1), (0.1, 0.1), (0.1, 0.3), (0, 0.3)]
    flat = np.array([(0, 1, 3), (1, 2, 3), (0, 3, 5), (3, 4, 5)])
    i, j = np.arange(6), (np.arange(6) + 1) % 6
    corner = trimesh.Trimesh(
        [(x, y, z) for z in (0, 0.1) for x, y in rim],
        np.vstack([flat[:, ::-1], flat + 6, np.c_[i, j, j + 6], np.c_[i, j + 6, i + 6]]),
    )
    assert corner.is_volume
    corner.export(tmp_path / "corner.stl")
    uri = "<mesh><uri>corner.stl</uri></mesh>"
    sdf = MODEL.format(link("a", f"<collision name='c'><geometry>{uri}</geometry></collision>"))
    assert compiled(tmp_path, sdf).ngeom == 1
    parts = compiled(tmp_path, sdf, convex="parts")
    assert parts.ngeom > 1
    monkeypatch.setitem(sys.modules, "coacd", None)  # not needed, as they are kept
    assert compiled(tmp_path, sdf, convex="parts").ngeom == parts.ngeom


def test_friction_is_read_and_its_default_is_1(tmp_path):
    def mu(surface: str) -> tuple[float, tuple[str, ...]]:
        shape = "<geometry><sphere><radius>0.1</radius></sphere></geometry>"
        inside = f"<collision name='c'>{shape}{surface}</collision>"
        model, warnings = converted(tmp_path, MODEL.format(link("a", inside)))
        return float(model.geom_friction[0, 0]), warnings

    ode = "<surface><friction><ode>{}</ode></friction></surface>"
    assert mu("") == (1.0, ())
    assert mu(ode.format("<mu>0.6</mu>")) == (0.6, ())
    assert mu(ode.format("<mu>0.6</mu><mu2>0.6</mu2>")) == (0.6, ())
    value, warnings = mu(ode.format("<mu>0.6</mu><mu2>0.1</mu2>"))
    assert value == 0.6 and "by direction" in warnings[0]


def test_materials_keep_their_colours(tmp_path):
    shape = "<geometry><sphere><radius>0.1</radius></sphere></geometry>"
    colours = "<diffuse>0.1 0.2 0.3 0.5</diffuse><emissive>0.5 0.5 0.5 1</emissive>"
    visual = (
        f"<visual name='v'>{shape}<transparency>0.5</transparency>"
        f"<material>{colours}</material></visual>"
    )
    model = compiled(tmp_path, MODEL.format(link("a", visual)))
    assert model.mat_rgba[model.geom_matid[0]] == pytest.approx([0.1, 0.2, 0.3, 0.25])
    assert model.mat_emission[model.geom_matid[0]] == pytest.approx(0.5)


def two_links(kind: str, inside: str = "", **places: str) -> str:
    return MODEL.format(
        link("a")
        + link("b", "", places.get("b", "0 0 1 0 0 0"))
        + joint("j", kind, "a", "b", inside)
    )


def test_each_joint_has_its_axis_limits_damping_and_friction(tmp_path):
    inside = """<axis><xyz>0 2 0</xyz><limit><lower>-0.5</lower><upper>1.5</upper>
    <effort>0.8</effort></limit><dynamics><damping>0.3</damping><friction>0.2</friction>
    <spring_stiffness>4</spring_stiffness><spring_reference>0.1</spring_reference></dynamics>
    </axis>"""
    for kind, mj in (("revolute", "HINGE"), ("prismatic", "SLIDE")):
        model, warnings = converted(tmp_path, two_links(kind, inside))
        assert model.jnt_type[0] == int(getattr(mujoco.mjtJoint, f"mjJNT_{mj}"))
        assert model.jnt_axis[0] == pytest.approx([0, 1, 0])
        assert model.jnt_range[0] == pytest.approx([-0.5, 1.5]) and model.jnt_limited[0]
        assert model.jnt_actfrcrange[0] == pytest.approx([-0.8, 0.8])
        assert model.dof_damping[0] == 0.3 and model.dof_frictionloss[0] == 0.2
        assert model.jnt_stiffness[0] == 4 and model.qpos_spring[0] == 0.1
        assert warnings == ()
    for given, expected in (
        ("<lower>-0.5</lower>", (-0.5, 1e6)), ("<upper>-0.2</upper>", (-1e6, -0.2)),
        ("<lower>0.3</lower><upper>0.3</upper>", (0.3, 0.3 + 1e-9)),
    ):  # fmt: skip
        axis = f"<axis><limit>{given}<effort>-1</effort></limit><dynamics/></axis>"
        model = compiled(tmp_path, two_links("revolute", axis))
        assert model.jnt_limited[0] and tuple(model.jnt_range[0]) == expected
        assert not model.dof_damping[0] and not model.dof_frictionloss[0]
        assert not model.jnt_actfrclimited[0]  # negative: unlimited, of the SDFormat specification
    turning = compiled(tmp_path, two_links("continuous", inside))
    assert not turning.jnt_limited[0]


def test_fixed_ball_and_universal_joints(tmp_path):
    assert compiled(tmp_path, two_links("fixed")).nv == 0
    ball = compiled(tmp_path, two_links("ball", "<pose>0 0 -1 0 0 0</pose>"))
    assert ball.jnt_type[0] == int(mujoco.mjtJoint.mjJNT_BALL)
    assert ball.jnt_pos[0] == pytest.approx([0, 0, -1])
    axes = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>"
    universal = compiled(tmp_path, two_links("universal", axes))
    assert universal.jnt_axis == pytest.approx(np.array([[1, 0, 0], [0, 1, 0]]))


def test_an_axis_may_be_said_in_another_frame(tmp_path):
    quarter = str(np.pi / 2)
    inside = "<axis><xyz expressed_in='__model__'>1 0 0</xyz></axis>"
    model = compiled(tmp_path, two_links("revolute", inside, b=f"0 0 1 0 0 {quarter}"))
    assert model.jnt_axis[0] == pytest.approx([0, -1, 0])
    inside = "<axis><xyz>3 0 4</xyz><use_parent_model_frame>1</use_parent_model_frame></axis>"
    model = compiled(tmp_path, two_links("revolute", inside, b=f"0 0 1 0 0 {quarter}"))
    assert model.jnt_axis[0] == pytest.approx([0, -0.6, 0.8])
    own = compiled(tmp_path, two_links("revolute", "<axis><xyz>1 0 0</xyz></axis>"))
    assert own.jnt_axis[0] == pytest.approx([1, 0, 0])
    default = compiled(tmp_path, two_links("revolute", "<axis/>"))
    assert default.jnt_axis[0] == pytest.approx([0, 0, 1])  # of the SDFormat specification


def test_a_joint_that_follows_another_one(tmp_path):
    mimic = "<mimic joint='j'><multiplier>2</multiplier><offset>0.1</offset>" \
            "<reference>0.3</reference></mimic>"  # fmt: skip
    sdf = MODEL.format(
        link("a") + link("b") + link("c")
        + joint("j", "revolute", "a", "b", "<axis><xyz>0 0 1</xyz></axis>")
        + joint("k", "revolute", "b", "c", f"<axis><xyz>0 0 1</xyz>{mimic}</axis>")
        + link("d") + joint("l", "revolute", "c", "d", "<axis><mimic joint='j'/></axis>")
    )  # fmt: skip
    model = compiled(tmp_path, sdf)
    leader = np.linspace(-1.0, 1.0, 5)
    follower = np.polynomial.polynomial.polyval(leader, model.eq_data[0, :5])
    assert follower == pytest.approx(2.0 * (leader - 0.3) + 0.1)
    assert model.eq_data[1, :5].tolist() == [0, 1, 0, 0, 0]  # what is left out changes nothing


def test_the_order_of_links_and_joints_does_not_matter(tmp_path):
    sdf = MODEL.format(
        joint("k", "fixed", "b", "c") + link("c") + link("b")
        + joint("j", "revolute", "a", "b", "<axis><xyz>0 0 1</xyz></axis>") + link("a")
    )  # fmt: skip
    model = compiled(tmp_path, sdf)
    assert model.body("b").parentid[0] == model.body("a").id
    assert model.body("c").parentid[0] == model.body("b").id


def test_a_static_model_does_not_move(tmp_path):
    sdf = two_links("revolute", "<axis><xyz>0 0 1</xyz></axis>")
    sdf = sdf.replace("<link name='a'>", "<static>1</static><link name='a'>")
    assert compiled(tmp_path, sdf).nv == 0


def test_links_of_a_model_collide_only_if_it_says_so(tmp_path):
    ball = (
        "<collision name='c'><geometry><sphere><radius>1</radius></sphere></geometry></collision>"
    )
    chain = (
        link("a", ball) + link("b", ball) + link("c", ball)
        + joint("j", "revolute", "a", "b", "<axis/>") + joint("k", "revolute", "b", "c", "<axis/>")
    )  # fmt: skip
    for inside, contacts in ((chain, False), (f"<self_collide>true</self_collide>{chain}", True)):
        model = compiled(tmp_path, MODEL.format(inside))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        assert bool(data.ncon) == contacts


def pose_of(model: mujoco.MjModel, kind: str, name: str) -> pin.SE3:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    thing = getattr(data, kind)(name)
    return pin.SE3(thing.xmat.reshape(3, 3), thing.xpos)


def T(x, y, z, roll=0.0, pitch=0.0, yaw=0.0) -> pin.SE3:
    return pin.SE3(pin.rpy.rpyToMatrix(roll, pitch, yaw), np.array([x, y, z], dtype=float))


def test_poses_are_relative_to_frames_links_and_joints(tmp_path):
    sdf = MODEL.format(
        link("a", "", "1 0 0 0 0 0.5")
        + "<frame name='f' attached_to='a'><pose>0 1 0 0.2 0 0</pose></frame>"
        + "<frame name='g'><pose relative_to='f'>0 0 1 0 0.3 0</pose></frame>"
        + link("b", "", "0 0 1 0 0 0.4", "g")
        + joint("j", "revolute", "a", "b",
                "<pose relative_to='f'>0 0 0.1 0 0 0</pose><axis><xyz>0 0 1</xyz></axis>")
        + link("c", "", "0.5 0 0 0 0 0", "j")
    )  # fmt: skip
    model = compiled(tmp_path, sdf)
    a = T(1, 0, 0, yaw=0.5)
    f = a * T(0, 1, 0, roll=0.2)
    g = f * T(0, 0, 1, pitch=0.3)
    b = g * T(0, 0, 1, yaw=0.4)
    for kind, name, by_hand in (
        ("body", "a", a), ("site", "f", f), ("site", "g", g), ("body", "b", b),
        ("body", "c", f * T(0.5, 0, 0.1)),
    ):  # fmt: skip
        assert pose_of(model, kind, name).isApprox(by_hand, 1e-9), name
    hinge = b.inverse() * f * T(0, 0, 0.1)
    assert model.jnt_pos[0] == pytest.approx(hinge.translation)
    assert model.jnt_axis[0] == pytest.approx(hinge.rotation[:, 2])


def test_a_model_in_the_model_has_a_scope_of_its_own(tmp_path):
    inner = "<model name='arm'><pose>0 0 1 0 0 1.0</pose>{}</model>".format(
        link("base", "", "1 0 0 0 0 0") + link("tip", "", "0 0 1 0 0 0", "base")
        + joint("j", "prismatic", "base", "tip", "<axis/>")
    )  # fmt: skip
    sdf = MODEL.format(
        link("base") + inner + joint("mount", "fixed", "base", "arm::base")
        + link("cap", "", "0 0 0.1 0 0 0", "arm::tip") + joint("lid", "fixed", "arm::tip", "cap")
    )  # fmt: skip
    model = compiled(tmp_path, sdf)
    tip = T(0, 0, 1, yaw=1.0) * T(1, 0, 1)
    assert pose_of(model, "body", "arm::tip").isApprox(tip, 1e-9)
    assert pose_of(model, "body", "cap").isApprox(tip * T(0, 0, 0.1), 1e-9)
    assert model.joint("arm::j").type[0] == int(mujoco.mjtJoint.mjJNT_SLIDE)


def test_a_placement_frame_is_what_is_placed(tmp_path):
    inner = "<model name='in' placement_frame='f'><pose>0 0 5 0 0 0</pose>{}</model>".format(
        link("l") + "<frame name='f'><pose>1 0 0 0 0 0.5</pose></frame>"
    )
    model = compiled(tmp_path, MODEL.format(inner))
    assert pose_of(model, "site", "in::f").isApprox(T(0, 0, 5), 1e-9)
    assert pose_of(model, "body", "in::l").isApprox(
        T(0, 0, 5) * T(1, 0, 0, yaw=0.5).inverse(), 1e-9
    )
    whole = MODEL.replace("name='m'", "name='m' placement_frame='f'").format(
        link("l") + "<frame name='f'><pose>1 0 0 0 0 0</pose></frame>"
    )
    assert pose_of(compiled(tmp_path, whole), "body", "l").isApprox(T(-1, 0, 0), 1e-9)


def test_an_include_brings_another_file_under_its_own_name(tmp_path):
    (tmp_path / "ball").mkdir()
    (tmp_path / "ball" / "model.config").write_text("<model><sdf>m.sdf</sdf></model>")
    (tmp_path / "ball" / "m.sdf").write_text(MODEL.format("<pose>9 9 9 0 0 0</pose>" + link("l")))
    include = "<include><uri>{}</uri><name>{}</name><pose>0 0 1 0 0 0</pose></include>"
    for uri in ("ball", "ball/m.sdf", "model://ball"):
        model = compiled(tmp_path, MODEL.format(include.format(uri, "one") + link("base")))
        assert pose_of(model, "body", "one::l").isApprox(T(0, 0, 1), 1e-9)
    twice = MODEL.format(include.format("ball", "one") + include.format("ball", "two"))
    assert compiled(tmp_path, twice).nbody == 3
    assert "thing.sdf:1: 'nowhere': there is no such file" in refused(
        tmp_path, include.format("nowhere", "x")
    )


def test_a_model_that_includes_itself_is_refused(tmp_path):
    itself = "<include><uri>thing.sdf</uri><name>{}</name></include>"
    message = refused(tmp_path, link("l") + itself.format("a") + itself.format("b"))
    assert "more than 16 deep: one may include itself" in message


def test_includes_that_multiply_are_refused(tmp_path, monkeypatch):
    assert scopes.MAX_FRAMES == 5000
    monkeypatch.setattr(scopes, "MAX_FRAMES", 50)
    twice = "".join(f"<include><uri>{{0}}.sdf</uri><name>{n}</name></include>" for n in "ab")
    for i in range(6):
        inside = link("l") + twice.format(i + 1)
        (tmp_path / f"{i}.sdf").write_text(MODEL.format(inside))
    (tmp_path / "6.sdf").write_text(MODEL.format(link("l")))
    assert "more than 50 links and frames" in refused(tmp_path, twice.format(0))


@pytest.mark.parametrize(
    ("inside", "words"),
    [
        (link("a", "", "0 0 0 0 0 0", "nobody"), "there is no frame 'nobody'"),
        (link("arm") + joint("j", "fixed", "arm", "amr"), "did you mean 'arm'"),
        (link("a") + link("a"), "the name 'a' is used twice"),
        (link("a") + f"<model name='a'>{link('b')}</model>", "the name 'a' is used twice"),
        (f"<model name='a'>{link('b')}</model>" + link("a"), "the name 'a' is used twice"),
        (link("a", "", "0 0 1 0 0 0", "b") + link("b", "", "0 0 1 0 0 0", "a"), "to itself"),
        ("<frame name='f' attached_to='f'/>" + link("a"), "cycle"),
        (link(""), "has no name"), (link("a/b"), "cannot be a name"), ("", "without links"),
        (link("a", "", "0 0 0"), "<pose>: expected 6 numbers, got '0 0 0'"),
        (link("a") + link("b") + joint("j", "revolute", "a", "b"), "has no <axis>"),
        (link("a") + link("b") + joint("j", "revolute", "a", "b", "<axis><xyz>0 0 0</xyz></axis>"),
         "an axis of zeros"),
        (link("a") + "<joint name='j' type='fixed'><parent>a</parent></joint>", "has no <child>"),
        (link("a") + "<static>perhaps</static>", "expected true or false, got 'perhaps'"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_one_error_with_its_line(tmp_path, inside, words):
    message = refused(tmp_path, inside)
    assert words in message
    assert "thing.sdf:1: " in message


@pytest.mark.parametrize(
    ("inside", "words"),
    [
        (link("a", "\n<sensor name='s' type='camera'/>"), "<sensor> of <link>"),
        (link("a") + "\n<plugin name='p' filename='p.so'/>", "<plugin> of <model>"),
        (link("a") + link("b") + "\n" + joint("j", "screw", "a", "b"), "type 'screw'"),
        (link("a") + "\n" + link("b"), "no joint holds link 'b'"),
        (link("a") + link("b") + joint("j", "fixed", "a", "b") + "\n"
         + joint("k", "fixed", "b", "a"), "closes a loop"),
        ("\n<pose>0 0 1 0 0 0</pose>" + link("a"), "the model's own pose is ignored"),
        (link("a", "<visual name='v'><geometry>\n<heightmap/></geometry></visual>"),
         "the shape <heightmap> cannot be expressed"),
    ],
)  # fmt: skip
def test_what_cannot_be_expressed_is_a_warning_with_its_line(tmp_path, inside, words):
    _, warnings = converted(tmp_path, MODEL.format(inside))
    assert len(warnings) == 1
    assert words in warnings[0]
    assert "thing.sdf:2: " in warnings[0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<sdf version='1.9'><world name='w'/></sdf>", "it is a world"),
        ("<sdf version='1.9'/>", "it has no <model>"),
        ("<robot/>", "expected <sdf>, found <robot>"),
        ("<sdf><model></sdf>", "not XML"),
        ("<!DOCTYPE sdf [<!ENTITY x SYSTEM 'file:///etc/passwd'>]><sdf>&x;</sdf>", "DOCTYPE"),
    ],
)
def test_a_document_without_a_model_is_refused(tmp_path, text, words):
    path = tmp_path / "thing.sdf"
    path.write_text(text)
    with pytest.raises(ModelError, match=words):
        load_model(str(path))


def test_a_lost_visual_is_a_warning_and_the_collision_geometry_is_drawn(tmp_path):
    lost = "<{0} name='{0}'><geometry><mesh><uri>gone.stl</uri></mesh></geometry></{0}>"
    box = "<collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision>"
    model, warnings = converted(tmp_path, MODEL.format(link("a", lost.format("visual") + box)))
    assert "the visual is left out" in warnings[0] and model.geom_group.tolist() == [2]
    assert "gone.stl" in refused(tmp_path, link("a", lost.format("collision")))

"""Going back to a physics that has been compiled before, held against compiling it again."""

import mujoco
import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.cell import Cell, CellError, OverlapError, Region, objects
from bt_manip.cell.physics.state import carry_state
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, panda
from tests.cell.conftest import content

BESIDE = spatial.pose((0.4, 0.3, 0.03))


def make_cell(kept: int = 2, robot: bool = False) -> Cell:
    cell = Cell()
    cell.compiles_kept = kept
    if robot:
        cell.add(Robot(panda(), gripper=TwoFingerGripper), free=False)
    cell.add(objects.Cube(), spatial.pose((0.5, 0.0, 0.2)), name="cube")
    return cell


def test_the_same_things_have_the_same_physics_again_as_far_as_it_is_kept():
    cell, keeping_one = make_cell(), make_cell(1)
    model, generation = cell.model, cell.generation
    cell.add(objects.Cube(), BESIDE, name="other")
    assert cell.model is not model
    cell.remove("other")
    assert cell.model is model
    assert cell.generation == generation + 2
    cell.step(20)
    state = cell.snapshot()
    cell.remove("cube")
    cell.restore(state, make)
    assert cell.model is model
    first = keeping_one.model
    for i, name in enumerate("ab"):
        keeping_one.add(objects.Cube(), spatial.pose((0.4, 0.3 + 0.3 * i, 0.03)), name=name)
    for name in "ba":
        keeping_one.remove(name)
    assert keeping_one.model is not first


def falling_again(cell: Cell, i: int) -> None:
    cell.step(50)  # the cube falls, and lies
    cell.add(objects.Cube(), spatial.pose((0.4, 0.3, 0.1 + 0.01 * i)), name="other")
    cell.step(20)
    cell.remove("other")
    cell.step(5)


def restored_without_what_came(cell: Cell, i: int) -> None:
    state = cell.snapshot()
    cell.add(objects.Cube(), BESIDE, name="other")
    cell.step(20)
    cell.restore(state)
    cell.step(30)


def restored_with_what_went(cell: Cell, i: int) -> None:
    state = cell.snapshot()
    cell.step(7)
    cell.remove("cube")
    cell.step(20)
    cell.restore(state, make)
    cell.step(30)


CHANGES = [falling_again, restored_without_what_came, restored_with_what_went]


@pytest.mark.parametrize("change", CHANGES)
def test_what_follows_is_that_of_a_compile_to_the_last_bit(change):
    def history(kept: int) -> list[bytes]:
        cell = make_cell(kept, robot=True)
        cell.step(180)
        states = []
        for i in range(2):
            change(cell, i)
            states.append(cell.state_bytes())
        return states

    assert history(3) == history(0)


KINDS = ("free", "ball", "slide", "hinge")
BODY = """<body name="{0}"><joint name="{0}" type="{0}"/><geom size="0.1"/></body>
<body name="to_{0}" mocap="true"/>"""
MOTOR = '<general name="m_{0}" joint="{0}" dyntype="integrator"/>'
LOCK = '<joint name="{0}" joint1="{0}" active="false"/>'
SENSORS = {"free": "framepos", "ball": "framequat", "slide": "framelinacc", "hinge": "framexaxis"}
SENSOR = '<{1} name="{0}" objtype="body" objname="{0}"/>'


def test_the_state_of_all_elements_is_carried_by_their_names(rng):
    def build(*order):
        bodies = "".join(map(BODY.format, order))
        driven = [kind for kind in order if kind in KINDS[2:]]
        motors, locks = ("".join(map(text.format, driven)) for text in (MOTOR, LOCK))
        sensors = "".join(SENSOR.format(kind, SENSORS[kind]) for kind in order)
        model = mujoco.MjModel.from_xml_string(
            f"<mujoco><worldbody>{bodies}</worldbody><actuator>{motors}</actuator>"
            f"<equality>{locks}</equality><sensor>{sensors}</sensor></mujoco>"
        )
        return model, mujoco.MjData(model)

    old, data = build(*KINDS)
    new, target = build("hinge", "slide", "free", "ball")
    for field in ("qpos", "qvel", "qacc", "qacc_warmstart", "qfrc_applied", "act", "ctrl",
                  "xfrc_applied", "mocap_pos", "mocap_quat", "sensordata"):  # fmt: skip
        getattr(data, field)[:] = rng.normal(size=getattr(data, field).shape)
    data.time, data.eq_active[:] = 0.7, (0, 1)
    carry_state(old, data, new, target, except_entities=())
    assert target.time == 0.7
    for name in KINDS:
        for field in ("qpos", "qvel", "qacc", "qacc_warmstart", "qfrc_applied"):
            given, carried = (getattr(d.joint(name), field) for d in (data, target))
            assert (given == carried).all() and given.any()
        assert (target.body(name).xfrc_applied == data.body(name).xfrc_applied).all()
        assert (target.sensor(name).data == data.sensor(name).data).all()
        source, there = (m.body(f"to_{name}").mocapid[0] for m in (old, new))
        assert (target.mocap_pos[there] == data.mocap_pos[source]).all()
        assert (target.mocap_quat[there] == data.mocap_quat[source]).all()
    for field in ("act", "ctrl", "eq_active"):
        assert (getattr(target, field) == getattr(data, field)[::-1]).all()


def test_what_was_changed_by_hand_is_compiled_anew():
    cell = make_cell()
    model = cell.model
    model.opt.gravity[2] = -1.0
    cell.add(objects.Cube(), BESIDE, name="other")
    cell.remove("other")
    assert cell.model is not model
    assert cell.model.opt.gravity[2] == pytest.approx(-9.81)
    cell.arena.mjcf_model.option.gravity = (0.0, 0.0, -5.0)
    cell.add(objects.Cube(), BESIDE, name="other")
    cell.find("cube").mjcf_model.find_all("geom")[0].rgba = (0.1, 0.2, 0.3, 1.0)
    cell.remove("other")
    assert cell.model.opt.gravity[2] == pytest.approx(-5.0)
    assert any(np.allclose(colour, (0.1, 0.2, 0.3, 1.0)) for colour in cell.model.geom_rgba)


def test_the_same_entity_at_another_pose_has_the_model_of_a_new_compile():
    cell, elsewhere = make_cell(), spatial.pose((0.4, 0.1, 0.3), (0.6, 0.0, 0.8, 0.0))
    model = cell.model
    cell.add(cell.remove("cube"), elsewhere, name="cube")
    assert cell.model is model
    assert cell.pose("cube").isApprox(elsewhere)
    new = make_cell(kept=0)
    new.remove("cube")
    new.add(objects.Cube(), elsewhere, name="cube")
    assert content(cell.model) == content(new.model)
    assert cell.state_bytes() == new.state_bytes()


def test_a_fixed_entity_at_another_pose_and_one_of_another_size_are_compiled():
    cell = make_cell()
    cell.add(objects.Cube(), BESIDE, name="fixed", free=False)
    model = cell.model
    cell.add(cell.remove("fixed"), spatial.pose((0.4, 0.4, 0.03)), name="fixed", free=False)
    assert cell.model is not model
    model = cell.model
    cell.remove("cube")
    cell.add(objects.Cube(size=0.03), spatial.pose((0.5, 0.0, 0.2)), name="cube")
    assert cell.model is not model


def test_what_did_not_fit_is_added_elsewhere_without_a_compile(monkeypatch):
    cell = make_cell()
    model, cube = cell.model, objects.Cube()
    with pytest.raises(OverlapError):
        cell.add(cube, spatial.pose((0.5, 0.0, 0.2)), name="other")
    assert cell.model is model
    assert cell.is_reusable(cube)
    monkeypatch.setattr("bt_manip.cell.physics.mjcf_writer.MjcfWriter.compile", None)
    inside = Region((0.5, 0.5), (0.0, 0.0), (0.2, 0.2))
    with pytest.raises(CellError, match="'other' cannot be placed"):
        cell.place(cube, inside, np.random.default_rng(0), name="other", attempts=2)
    cell.add(cube, BESIDE, name="other")
    cell.step(3)


def make(entry):
    return objects.Cube(**entry["parameters"])


@pytest.mark.parametrize("removed_first", [True, False])
def test_what_was_edited_by_hand_does_not_come_back(removed_first):
    cell = make_cell()
    state = cell.snapshot()
    cube = cell.remove("cube") if removed_first else cell.find("cube")
    cube.mjcf_model.find_all("geom")[0].rgba = (0.1, 0.2, 0.3, 1.0)
    if not removed_first:
        cell.remove("cube")
    cell.restore(state, make)
    assert cell.find("cube") is not cube
    assert not any(np.allclose(colour, (0.1, 0.2, 0.3, 1.0)) for colour in cell.model.geom_rgba)


def test_what_stands_elsewhere_by_now_is_left_there():
    cell, other = make_cell(), Cell()
    state = cell.snapshot()
    cube = cell.remove("cube")
    other.add(cube, BESIDE)
    cell.restore(state, make)
    assert cell.find("cube") is not cube
    assert "cube" in other.objects

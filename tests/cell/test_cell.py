"""Entities come and go; everything else stays, to the bit."""

import mujoco
import numpy as np
import pytest
from dm_control import composer, mjcf

from bt_manip.cell import Arena, Cell, CellError, Cube, PhysicsDiverged
from bt_manip.spatial import pose


class Pendulum(composer.Entity):
    """A driven pendulum with everything that a state consists of."""

    def _build(self, name="pendulum"):
        self.root = mjcf.from_xml_string(f"""
            <mujoco model="{name}">
              <worldbody>
                <body name="arm" pos="0 0 1">
                  <joint name="swing" axis="0 1 0" damping="0.1"/>
                  <geom name="bob" size="0.03" pos="0.3 0 0" mass="0.2"/>
                  <body name="wrist" pos="0.3 0 0">
                    <joint name="ball" type="ball" damping="0.01"/>
                    <geom name="stick" type="capsule" size="0.01" mass="0.1"
                      fromto="0 0 0 0.1 0 0"/>
                  </body>
                </body>
              </worldbody>
              <actuator>
                <general name="lag" joint="swing" dyntype="filter" dynprm="0.1" gainprm="0.5"/>
              </actuator>
              <equality><joint name="lock" joint1="swing" active="false"/></equality>
            </mujoco>""")
        self.events = []

    @property
    def mjcf_model(self):
        return self.root

    def after_compile(self, physics, random_state):
        self.events.append("compiled")

    def initialize_episode(self, physics, random_state):
        self.events.append("initialised")
        physics.bind(self.root.find("joint", "swing")).qpos = 0.3

    def before_substep(self, physics, random_state):
        t = physics.data.time
        physics.bind(self.root.find("actuator", "lag")).ctrl = np.sin(5 * t)


class Broken(Pendulum):
    """An entity that MuJoCo refuses: a moving body without mass."""

    def _build(self):
        super()._build("broken")
        body = self.root.worldbody.add("body", name="ghost")
        body.add("joint", name="slide", type="slide")


class Grumpy(Pendulum):
    """An entity whose hook raises."""

    def after_compile(self, physics, random_state):
        raise RuntimeError("not today")


@pytest.fixture
def cell():
    """Give a cell with a mocap body, a pendulum and a cube."""
    arena = Arena()
    arena.mjcf_model.worldbody.add("body", name="target", mocap="true")
    cell = Cell(arena)
    cell.add(Pendulum())
    cell.add(Cube(), pose((1, 0, 0.3), (0.9, 0.1, 0.2, 0.3)))
    return cell


def disturb(cell):
    """Give every part of the state a value of its own."""
    rng = np.random.default_rng(3)
    d = cell.data
    cell.step(50)
    d.qfrc_applied[:] = rng.normal(size=cell.model.nv) * 1e-3
    d.xfrc_applied[1:] = rng.normal(size=(cell.model.nbody - 1, 6)) * 1e-3
    d.mocap_pos[:] = rng.normal(size=d.mocap_pos.shape)
    cell.step(7)
    d.eq_active[:] = 1


def test_adding_and_removing_distant_things_changes_no_bit_of_the_future(cell):
    disturb(cell)
    state = cell.snapshot()
    cell.step(100)
    future = cell.state_bytes()
    cell.restore(state)
    names = [cell.add(Cube(), pose((5, 5, 3))), cell.add(Pendulum(), pose((3, 0, 0)))]
    assert len(cell.data.qpos) == 2 * (7 + 1 + 4)
    for name in names:
        cell.remove(name)
    cell.step(100)
    assert cell.state_bytes() == future


def test_names_are_unique_and_a_removed_entity_and_its_name_can_come_back():
    cell = Cell()
    assert [cell.add(Cube(), pose((i, 0, 1))) for i in range(3)] == ["cube", "cube_1", "cube_2"]
    cube = cell.remove("cube_1")
    assert cell.add(cube, pose((5, 0, 2))) == "cube_1"
    assert cell.pose("cube_1").translation[2] == 2
    assert cell.add(Cube(), pose((6, 0, 1)), name="die") == "die"
    assert list(cell.objects) == ["cube", "cube_2", "cube_1", "die"]


@pytest.mark.parametrize("entity", [Broken, Grumpy])
def test_an_entity_that_cannot_be_added_leaves_the_cell_as_it_was(cell, entity):
    disturb(cell)
    before, generation, names = cell.state_bytes(), cell.generation, list(cell.entities)
    with pytest.raises(CellError, match="cannot be added"):
        cell.add(entity(), pose((0, 2, 0)))
    assert cell.state_bytes() == before
    assert (cell.generation, list(cell.entities)) == (generation, names)
    cell.add(Cube(), pose((0, 3, 1)))
    cell.step(10)


def test_an_edit_that_fails_undoes_all_of_it(cell):
    before, names = cell.state_bytes(), list(cell.entities)
    with pytest.raises(CellError), cell.editing():
        cell.add(Cube(), pose((0, 2, 1)))
        cell.remove("cube")
        cell.add(Broken())
    assert cell.state_bytes() == before
    assert list(cell.entities) == names
    cell.step(10)


def test_an_edit_compiles_once_and_hooks_run_after_each_compile():
    cell, pendulum = Cell(), Pendulum()
    cell.add(pendulum)
    generation = cell.generation
    with cell.editing():
        cell.add(Cube(), pose((0, 2, 1)))
        cell.add(Cube(), pose((0, 3, 1)))
    assert cell.generation == generation + 1
    assert cell.objects.keys() >= {"cube", "cube_1"}
    assert pendulum.events == ["compiled", "initialised", "compiled"]


def test_an_unknown_name_offers_the_nearest_and_an_entity_stands_in_one_place_only(cell):
    with pytest.raises(CellError, match="did you mean 'cube'"):
        cell.remove("cub")
    with pytest.raises(CellError, match="did you mean 'pendulum'"):
        cell.pose("pendulun")
    with pytest.raises(CellError, match="already attached"):
        cell.add(cell.find("cube"))


def test_pose_and_velocity_of_a_free_entity_are_in_the_world():
    cell = Cell()
    with cell.editing():
        for x in range(3):
            cell.add(Cube(), pose((x, 0, 5), (0.5, 0.5, 0.5, 0.5)))
    cell.data.qvel[6:12] = (1, 2, 3, 4, 0, 0)  # turns about its own x axis, the world's y
    np.testing.assert_allclose(cell.velocity("cube_1"), (1, 2, 3, 0, 4, 0), atol=1e-12)
    before = cell.pose("cube_1")
    np.testing.assert_allclose(before.translation, (1, 0, 5))
    cell.step()
    moved = cell.pose("cube_1").translation - before.translation
    np.testing.assert_allclose(moved, (1e-3, 2e-3, (3 - 9.81e-3) * 1e-3), atol=1e-12)
    np.testing.assert_allclose(
        cell.pose("cube_1").rotation @ before.rotation.T,
        [[np.cos(4e-3), 0, np.sin(4e-3)], [0, 1, 0], [-np.sin(4e-3), 0, np.cos(4e-3)]],
        atol=1e-12,
    )


def test_a_state_with_an_unknown_object_and_no_factory_changes_nothing(cell):
    state = cell.snapshot()
    other = Cell()
    other.add(Pendulum())
    names = list(other.entities)
    with pytest.raises(CellError, match="'cube'"):
        other.restore(state)
    assert list(other.entities) == names


def test_numbers_that_are_not_finite_are_a_fault_and_not_a_silent_restart(cell):
    cell.step(10)
    cell.data.qvel[0] = np.nan
    with pytest.raises(PhysicsDiverged, match="QVEL|QACC"):
        cell.step(2)
    assert cell.time > 0.005


@pytest.mark.parametrize("stiffness", [62500, 0.5, 0])
def test_a_time_step_too_long_for_a_contact_is_refused(stiffness):
    def add(timestep):
        cube = Cube()
        cube.mjcf_model.find("geom", "box").solref = (-stiffness, -1850)
        Cell(timestep=timestep).add(cube, pose((0, 0, 1)))

    add(1e-3)
    with pytest.raises(CellError, match="'cube/box'.* need a time step below 0.001 s, got 0.002 s"):
        add(2e-3)


def test_the_same_entities_give_the_same_bits_in_a_composer_environment():
    cell, world = Cell(), Cell()
    for one in (cell, world):
        one.add(Pendulum())
        one.add(Cube(), pose((0.2, 0.0, 0.3), (0.9, 0.1, 0.2, 0.3)))
    cell.step(500)
    environment = composer.Environment(composer.NullTask(world.arena), random_state=0)
    environment.reset()
    for _ in range(500):
        environment.step(np.zeros(1))
    kind = mujoco.mjtState.mjSTATE_INTEGRATION
    state = np.empty(mujoco.mj_stateSize(cell.model, kind))
    physics = environment.physics
    mujoco.mj_getState(physics.model.ptr, physics.data.ptr, state, kind)
    assert state.tobytes() == cell.state_bytes()

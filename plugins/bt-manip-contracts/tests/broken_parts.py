"""Parts that break their contracts, each in one way."""

import itertools
from typing import ClassVar

import numpy as np
from dm_control import composer, mjcf

from bt_manip.behaviours import ArmBehaviour, CellBehaviour, Hover, MoveHome, SpawnObject
from bt_manip.bt import Action, Condition, Input, Sequence, Sleep, Status
from bt_manip.control import ComputedTorque
from bt_manip.grippers import TwoFingerGripper

_runs = itertools.count(1)


class ForgetfulGripper(TwoFingerGripper):
    """Keep everything to itself."""

    def get_state(self):
        return {}

    def set_state(self, state):
        pass


class AsksTheCellAtOnce(Hover):
    """Look at the cell when it is made."""

    def __init__(self, *arguments, **ports):
        super().__init__(*arguments, **ports)
        self.cell.time  # noqa: B018


class MovesInSetup(MoveHome):
    """Start in setup."""

    def setup(self, **infrastructure):
        super().setup(**infrastructure)
        self.gripper.close(10.0)


class StepsThePhysics(CellBehaviour):
    """Wait by stepping."""

    def update(self):
        self.cell.step(5)
        return Status.SUCCESS


class PushesThePhysics(CellBehaviour):
    """Push an object by hand."""

    def update(self):
        self.cell.data.qvel[-6] += 0.1
        return Status.SUCCESS


class DrivesOn(Hover):
    """Forget to brake when halted."""

    def terminate(self, new_status):
        pass


class ClosesOn(ArmBehaviour):
    """Forget the fingers when halted."""

    def start(self):
        self.gripper.close(10.0)

    def update(self):
        return Status.SUCCESS if self.gripper.width < 0.04 else Status.RUNNING


class FailsSilently(CellBehaviour):
    """Fail without a word."""

    object = Input(str, doc="Name of the object.")

    def update(self):
        return Status.SUCCESS if self.object in self.cell.objects else Status.FAILURE


class TakesItsTime(Condition):
    """Look twice."""

    looks = 0

    def update(self):
        self.looks += 1
        return Status.SUCCESS if self.looks % 2 == 0 else Status.RUNNING


class NeverFails(CellBehaviour):
    """Succeed at all speeds."""

    speed = Input(float, default=1.0, doc="Ignored.")

    def update(self):
        return Status.SUCCESS


class Remembers(CellBehaviour):
    """Take longer the second time."""

    memory: ClassVar = (*CellBehaviour.memory, "ticks")
    ticks = 0

    def initialise(self):
        pass

    def update(self):
        self.ticks += 1
        return Status.SUCCESS if self.ticks >= 3 else Status.RUNNING


class RemembersForAll(CellBehaviour):
    """Differ from run to run."""

    def initialise(self):
        self.left = next(_runs)

    def update(self):
        self.left -= 1
        return Status.RUNNING if self.left > 0 else Status.SUCCESS


class ForgetsItsState(CellBehaviour):
    """Count in something that is not in its state."""

    def initialise(self):
        super().initialise()
        self.seen = 0

    def update(self):
        self.seen = getattr(self, "seen", 0) + 1
        return Status.SUCCESS if self.seen == 10 else Status.RUNNING

    def set_state(self, state):
        self.seen = 0


class Nan(ComputedTorque):
    """Give no numbers."""

    def compute(self, *state):
        return super().compute(*state) * np.nan


class TooFew(ComputedTorque):
    """Give too few numbers."""

    def compute(self, *state):
        return super().compute(*state)[:-1]


class NoGravity(ComputedTorque):
    """Let the arm fall."""

    def compute(self, q, v, q_ref, v_ref, a_ref):
        return np.zeros_like(q)


class BeyondTheLimits(ComputedTorque):
    """Write what it likes."""

    def before_substep(self, physics, random_state):
        super().before_substep(physics, random_state)
        physics.data.ctrl[self.robot.ctrl_adr] *= 10.0


class Swings(ComputedTorque):
    """Have no damping."""

    def _build(self, robot):
        super()._build(robot, ki=0.0, kd=0.0)


class BangBang(ComputedTorque):
    """Give the full torque in the direction of the error."""

    saturates = True

    def compute(self, q, v, q_ref, v_ref, a_ref):
        error = q_ref - q + 0.1 * (v_ref - v)
        return np.sign(error) * self.robot.limits.effort


class SignOfVelocity(ComputedTorque):
    """Compensate friction by the sign of the measured velocity, and too much of it."""

    saturates = True

    def compute(self, q, v, q_ref, v_ref, a_ref):
        friction = 0.2 * self.robot.limits.effort * np.sign(v)
        return super().compute(q, v, q_ref, v_ref, a_ref) + friction


class Jerks(ComputedTorque):
    """Begin with a blow."""

    blow = 0.8

    def compute(self, *state):
        blow, self.blow = self.blow, 0.0
        return super().compute(*state) + blow * self.robot.limits.effort


class Thing(composer.Entity):
    """An object made of whatever is asked for."""

    kind = category = "thing"
    free = True

    parameters: ClassVar = {}

    def _build(self, rest_height=0.02, tilt=0.0):
        self.rest_height = rest_height
        self.root = mjcf.RootElement(model="thing")
        body = self.root.worldbody.add("body", name="body")
        body.add(
            "geom", type="box", size=(0.02, 0.02, 0.02), mass=0.1, euler=(tilt, 0, 0),
            solref=(0.004, 1),
        )  # fmt: skip

    @property
    def mjcf_model(self):
        return self.root


class RaisesInsteadOfFailing(Action):
    """Look for an object, and let what the cell raises go on."""

    object = Input(str, doc="Name of the object.")

    def setup(self, *, cell, **_):
        self.cell = cell

    def update(self):
        self.cell.pose(self.object)
        return Status.SUCCESS


def forgetful():
    """Return a tree with a state that is not restored."""
    return Sequence("task", Sleep("rest", msec=50), ForgetsItsState("count"))


def counting():
    """Return a tree whose episodes depend on how many there were before."""
    return Sequence("task", RemembersForAll("count"), Sleep("rest", msec=50))


def steady():
    """Return a tree that keeps the contract."""
    return Sequence("task", SpawnObject(object="{o}"), Sleep("rest", msec=200))

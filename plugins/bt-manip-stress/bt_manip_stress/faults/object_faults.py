"""Faults of objects, containers and obstacles."""

import math
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.cell import Cell, OverlapError, is_rest_velocity

from .fault import Fault, FaultError, parameter
from .places import Places, add_obstacle
from .robot_faults import LOCKING_FRICTION

GRAVITY = 9.81  # [m/s2] for the choice of a velocity; the throw itself is simulated
OUT_OF_HAND = 0.06  # [m] displacement of a held object out of the gripper before it is thrown
THROWN = 0.02  # [m] height over its support from which an object falls before it slides
THROWS = 50  # maximum number of random targets
FLIGHT = 1.0  # [s] within which a thrown object has to come to rest


@dataclass
class _ObjectFault(Fault):
    """A fault of an object."""

    object: str = parameter("", "Name of the object; by default the one that the tree handles.")

    @property
    def name(self) -> str:
        """Name of the object.

        Raises:
            FaultError: If there is none, or it does not move freely.
        """
        name = self.context.find_object(self.object)
        if not self.context.cell.is_free(name):
            raise FaultError(f"'{name}' does not move freely")
        return name


@dataclass
class Vanish(_ObjectFault):
    """The object is removed from the cell; one of the scene until the cycle ends."""

    def begin(self) -> None:
        """Remove it."""
        name = self.name
        if any(scene_object.name == name for scene_object in self.context.station.scene.objects):
            _remove_until_end(self, name)
        else:
            self.context.cell.remove(name)


@dataclass
class Displace(_ObjectFault):
    """The object is suddenly at another position on the table, within reach."""

    distance: float = parameter(0.1, "Least distance that it moves [m].")

    def begin(self) -> None:
        """Move it."""
        cell, name = self.context.cell, self.name
        for T_wo in Places(self.context, name, self.distance).sample():
            with suppress(OverlapError):
                cell.move(name, T_wo)
                return
        raise FaultError(f"there is no free place for '{name}' within reach")


@dataclass
class Knock(_ObjectFault):
    """The object is knocked away, also out of the gripper, and stays on the table within reach."""

    distance: float = parameter(0.1, "Least horizontal distance that it goes [m].")

    def begin(self) -> None:
        """Set a velocity with which it comes to rest within reach if the robot stands still."""
        context, cell, name = self.context, self.context.cell, self.name
        places = Places(context, name, self.distance)
        T_wo, robot = cell.pose(name), context.robot
        held = robot.gripper is not None and name in robot.gripper.held
        for T_target in islice(places.sample(), THROWS):
            T_start, offset = T_wo, T_target.translation - T_wo.translation
            if held:
                out = robot.robot.tool_pose.rotation[:, 2]
                if offset[2] > -OUT_OF_HAND:  # on the table it is thrown sideways
                    out = np.array([*offset[:2], 0.0]) / math.hypot(*offset[:2])
                T_start = pin.SE3(T_wo.rotation, T_wo.translation + OUT_OF_HAND * out)
            velocity = self._velocity(T_start, T_target, cell.nominal(name, "friction"))
            end = _thrown(cell, name, T_start, velocity)
            if end is None or places.height_at(*end[:2]) is None:
                continue
            with suppress(OverlapError):
                if held:
                    cell.move(name, T_start)
                dof = int(cell.model.joint(f"{name}/").dofadr[0])
                cell.data.qvel[dof : dof + 3] = velocity
                return
        raise FaultError(f"'{name}' cannot be knocked to a free place within reach")

    @staticmethod
    def _velocity(T_start: pin.SE3, T_target: pin.SE3, friction: float) -> np.ndarray:
        """Return the horizontal velocity for an object to fall and slide to a target [m/s]."""
        offset = T_target.translation - T_start.translation
        drop = -float(offset[2])
        fall = math.sqrt(2.0 * drop / GRAVITY) if drop > THROWN else 0.0
        deceleration, length = GRAVITY * friction, math.hypot(offset[0], offset[1])
        speed = deceleration * (math.sqrt(fall**2 + 2.0 * length / deceleration) - fall)
        return speed / length * np.array([offset[0], offset[1], 0.0])  # (3,)


def _thrown(cell: Cell, name: str, T_wo: pin.SE3, velocity: np.ndarray) -> np.ndarray | None:
    """Return where the origin of a thrown object comes to rest in a static copy of the cell [m].

    None if it does not come to rest. The initial velocity is in [m/s].
    """  # (3,)
    model, trial = cell.model, mujoco.MjData(cell.model)
    mujoco.mj_copyData(trial, model, cell.data)
    joint = model.joint(f"{name}/")
    q, v = int(joint.qposadr[0]), int(joint.dofadr[0])
    trial.qpos[q : q + 7] = [*T_wo.translation, *spatial.quat_wxyz(T_wo)]
    trial.qvel[v : v + 6] = [*velocity, 0.0, 0.0, 0.0]
    others_q, others_v = np.ones(model.nq, dtype=bool), np.ones(model.nv, dtype=bool)
    others_q[q : q + 7] = others_v[v : v + 6] = False
    still = trial.qpos[others_q].copy()
    for _ in range(round(FLIGHT / cell.dt)):
        trial.qpos[others_q], trial.qvel[others_v] = still, 0.0
        mujoco.mj_step(model, trial)
    return trial.qpos[q : q + 3].copy() if is_rest_velocity(trial.qvel[v : v + 6]) else None


@dataclass
class Slippery(_ObjectFault):
    """The object has very low friction."""

    friction: float = parameter(0.003, "Its coefficient of friction.")

    def begin(self) -> None:
        """Override its friction."""
        self.override(self.name, friction=self.friction)


@dataclass
class Heavy(_ObjectFault):
    """The object is heavier than the robot expects."""

    mass: float = parameter(10.0, "Its mass [kg].")

    def begin(self) -> None:
        """Override its mass."""
        self.override(self.name, mass=self.mass)


@dataclass
class Stuck(_ObjectFault):
    """The object is stuck to its position."""

    duration: float = parameter(1.0, "Time for which it is stuck [s].")

    def begin(self) -> None:
        """Lock its six degrees of freedom."""
        name = self.name
        dofs = len(self.context.cell.nominal(name, "joint_friction"))
        self.override(name, joint_friction=[LOCKING_FRICTION] * dofs)


@dataclass
class Obstacle(Fault):
    """A block appears on the arm's path, with a path around it."""

    width: float = parameter(0.06, "Its width and depth [m].")
    height: float = parameter(0.3, "Its height [m].")
    distance: float = parameter(0.15, "Least distance ahead of the tool [m].")
    clearance: float = parameter(0.1, "Least distance from object, container and tool [m].")

    def begin(self) -> None:
        """Add it."""
        size = (self.width, self.width, self.height)
        name = add_obstacle(self.context, size, self.distance, self.clearance)
        self.at_end(self.context.cell.remove, name)


@dataclass
class ContainerVanishes(Fault):
    """The container is removed from the cell until the cycle ends."""

    container: str = parameter("", "Its name; by default the one that the tree uses.")

    def begin(self) -> None:
        """Remove it."""
        _remove_until_end(self, self.context.find_container(self.container))


def _remove_until_end(fault: Fault, name: str) -> None:
    """Remove an entity, and add it again at the end of the fault."""
    cell = fault.context.cell
    T_we, free = cell.pose(name), cell.is_free(name)
    entity = cell.remove(name)
    fault.at_end(cell.add, entity, T_we, name=name, free=free, overlap=math.inf)

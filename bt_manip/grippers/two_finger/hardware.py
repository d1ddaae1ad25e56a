"""A real two-finger gripper in the simulated cell."""

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import mjcf

from bt_manip.cell import entity_of
from bt_manip.robots import GripperConnection, GripperError, Robot
from bt_manip.spatial import pose, quat_wxyz

from .fingers import DrivenFingers

SPEED = 0.1
"""Speed of the width in commands [m/s]."""

SLIPPED = 3e-3
"""Tolerance of the width for a held object, and for fully open or closed [m]."""

OPEN = 1e-3
"""Width below fully open from which on an object can be held: open fingers hold nothing [m]."""

NEAR_WIDTH = 0.1
"""Largest distance of the tool from the centre of mass of a gripped object [m]."""

FALLING = 50
"""Control steps after a release until the gripper counts as free; by then the object falls."""


_HOLD = ("_asked", "_busy", "_closing", "_grasp_width", "_held", "_steps_released")
"""What `RealTwoFingerGripper.get_state` has besides measurements and poses."""


class RealTwoFingerGripper(DrivenFingers):
    """A gripper whose fingers are at the measured positions of the real fingers.

    It holds an object while the device reports a grip, and the width is that of the grasp and
    neither fully closed nor fully open. The object nearest to the tool is assumed to be gripped,
    and moves with the tool; once released it falls in the simulation.

    Attributes:
        assumed: Names of released objects, whose poses are assumed.
    """

    def _build(self, robot: Robot, connection: GripperConnection) -> None:  # type: ignore[override]
        """Initialize the commands of a robot's gripper through a connection."""
        self._connection, self._closing, self._busy = connection, False, False
        self._grasp_width = 0.0
        self._held: str | None = None
        self._T_to = pin.SE3.Identity()
        self._steps_released = FALLING
        self.assumed: set[str] = set()
        super()._build(robot)

    # Commands

    def open(self) -> None:
        """Open fully; the object falls when the device is open."""
        self._closing = False
        self._connection.command("move", self._open, SPEED)
        self._busy = True

    def close(self, force: float) -> None:
        """Grip with a force [N]."""
        self._asked, self._closing, self._busy = self.check_force(force), True, True
        self._connection.command("grasp", 0.0, SPEED, self._asked)

    def stop(self) -> None:
        """Do nothing: commands of the device cannot be interrupted."""

    def update(self) -> None:
        """Read the device's latest state; called before each tick.

        Raises:
            DeviceError: If the connection is lost.
        """
        self._connection.update()
        if self._connection.busy:
            return
        if self._busy:
            self._busy = False
            if self._closing:
                self._grasp_width = self.width
                if self._grips() and self._held is None:
                    self._attach()
            elif self._held is not None:
                self._release()
        elif self._held is not None and not self._grips():  # it slipped or was removed
            self._release()

    def close_connection(self) -> None:
        """End the connection."""
        self._connection.close()

    def _grips(self) -> bool:
        state = self._connection.state
        kept = abs(state.width - self._grasp_width) <= SLIPPED
        between = self._min + SLIPPED < state.width < self._open - OPEN
        return state.is_grasped and kept and between

    # Measurements

    @property
    def width(self) -> float:
        """Measured distance between the fingers [m]."""
        return self._connection.state.width

    @property
    def moving(self) -> bool:
        """Whether a command is still being executed."""
        return self._busy

    @property
    def gripping(self) -> bool:
        """Whether its last command was to close."""
        return self._closing

    @property
    def is_open(self) -> bool:
        """Whether it is fully open, and has released its object."""
        return not self._closing and not self._busy and self.width > self._open - SLIPPED

    @property
    def steady(self) -> bool:
        """Whether it holds an object."""
        return self._closing and not self._busy and self._held is not None

    @property
    def closed_on_nothing(self) -> bool:
        """Whether it has closed and does not hold an object."""
        return self._closing and not self._busy and self._held is None

    @property
    def is_free(self) -> bool:
        """Whether it holds no object, and the released object is falling."""
        return self._held is None and self._steps_released >= FALLING

    @property
    def held(self) -> tuple[str, ...]:
        """Name of the object that is assumed to be held."""
        return () if self._held is None or self._joint() is None else (self._held,)

    @property
    def forces(self) -> tuple[float, float]:
        """The commanded force while an object is held [N]."""
        force = self._asked if self._held is not None else 0.0
        return force, force

    @property
    def status(self) -> str:
        """The width, and the device's problem if any."""
        problem = self._connection.state.problem or self._connection.problem
        text = f"fingers {1e3 * self.width:.0f} of {1e3 * self._open:.0f} mm apart"
        return f"{text}: {problem}" if problem else text

    def held_root(self) -> int:
        """Return the root body of the held object; 0 for none."""
        joint = self._joint()
        return int(self.robot.mj_model.jnt_bodyid[joint[0]]) if joint else 0

    # The simulated cell

    def follow_tool(self, T_wt: pin.SE3) -> None:
        """Move the fingers to their measured positions, and the held object with the tool."""
        self._steps_released += 1
        data, width = self.robot.mj_data, self.width
        if np.isfinite(width):
            self.mechanism.set_width(data.qpos, min(max(width, self._min), self._open))
        self.mechanism.rest(data.qvel)
        if (joint := self._joint()) is not None:
            _, qpos, dof = joint
            T_wo = T_wt * self._T_to
            data.qpos[qpos : qpos + 3] = T_wo.translation
            data.qpos[qpos + 3 : qpos + 7] = quat_wxyz(T_wo)
            data.qvel[dof : dof + 6] = 0.0

    def _attach(self) -> None:
        """Attach the nearest free object."""
        model, data = self.robot.mj_model, self.robot.mj_data
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        tool = self.robot.tool_pose
        free = np.flatnonzero(model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE))
        bodies = model.jnt_bodyid[free]
        if not len(bodies):
            return
        away = np.linalg.norm(data.subtree_com[bodies] - tool.translation, axis=1)
        nearest = int(away.argmin())
        if away[nearest] > NEAR_WIDTH:
            return
        self._held = entity_of(self.body_names.of_body[int(bodies[nearest])])
        joint = self._joint()
        assert joint is not None
        q = data.qpos[joint[1] : joint[1] + 7]
        self._T_to = tool.actInv(pose(q[:3], q[3:]))

    def _release(self) -> None:
        assert self._held is not None
        self.assumed.add(self._held)
        self._held, self._steps_released = None, 0

    def _joint(self) -> tuple[int, int, int] | None:
        """Return the held object's free joint with its addresses; None without one."""
        model = self.robot.mj_model
        joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, f"{self._held}/")
        if self._held is None or joint < 0:  # removed
            return None
        return joint, int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])

    # Composer's hooks

    def initialize_episode(
        self, physics: mjcf.Physics, random_state: np.random.RandomState
    ) -> None:
        """Move the fingers to their measured positions."""
        self.mechanism.set_width(self.robot.mj_data.qpos, self._open)

    def before_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Do nothing: the simulated motors are not used."""

    def after_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Do nothing: `follow_tool` is called with the measured pose of the tool."""

    def get_state(self) -> dict[str, Any]:
        """Return the known state of the gripper, for recordings and `set_state`."""
        state = {"width": self.width, "held": self.held, "assumed": sorted(self.assumed)}
        if self._connection.restorable:
            state["hold"] = {name: getattr(self, name) for name in _HOLD}
            state["T_to"] = self._T_to.homogeneous.tolist()
        return state

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore the state of a simulated device; that of a real one cannot be.

        Raises:
            GripperError: If the device is real.
        """
        if not self._connection.restorable:
            raise GripperError("a real gripper cannot return to an earlier state")
        for name in _HOLD:
            setattr(self, name, state["hold"][name])
        self._T_to, self.assumed = pin.SE3(np.array(state["T_to"])), {*state["assumed"]}

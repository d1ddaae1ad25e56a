"""A robot as a composer entity: arm joints with torque motors, a gripper, a tool."""

from typing import Any

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import composer, mjcf

from .addresses import reader
from .assembly import assemble, find_element
from .errors import RobotError
from .finger_travel import FingerTravel, direct_travel, is_direct, measure_travel
from .limit_reading import effort_limit, read_limits
from .model_building import find
from .motors import ensure_motors
from .robot_description import GripperDescription, RobotDescription
from .robot_model import RobotModel
from .robot_observables import RobotObservables
from .sensing import WristWrench, tool_velocity, wrist_of, wrist_wrench

_JOINT = int(mujoco.mjtObj.mjOBJ_JOINT)


class Robot(composer.Entity):
    """An arm from an MJCF file, commanded by torques.

    What the file says of the world (options, keyframes) is left out: the world is the arena's.
    Position servos and other actuators of the arm and gripper joints are replaced by motors with
    the same effort limits, so that any arm that MuJoCo loads takes the same controllers.

    Attributes:
        qpos_adr: Addresses of the arm's positions in ``qpos``.  # (nq,)
        dof_adr: Addresses of the arm's degrees of freedom in ``qvel``.  # (nq,)
        ctrl_adr: Addresses of the arm's motors in ``ctrl``.  # (nq,)
        gripper_qpos_adr: Like ``qpos_adr``, of the gripper.
        gripper_dof_adr: Like ``dof_adr``, of the gripper.
        gripper_ctrl_adr: Like ``ctrl_adr``, of the gripper.
        gripper_travel: How the fingers move with the gripper's joints; only where there is one.
        finger_body_ids: The finger bodies in the compiled model.
        finger_geom_ids: Geoms of each finger that collide, in the compiled model.
        tool_site_id: The tool in the compiled model.
        wrist_body_id: What is mounted on the last link, in the compiled model.
    """

    def _build(self, description: RobotDescription, name: str | None = None) -> None:
        self.description = description
        self._where = f"robot '{description.name}'"
        root, alone, hand, self.tool_site = assemble(description, name or description.name)
        self.limits = read_limits(alone, description)
        self._mjcf_root = root
        self.arm_joints = [self._find(root, "joint", n) for n in description.arm_joints]
        gripper = description.gripper
        names = gripper.joints if gripper else ()
        self.gripper_joints = [self._find(hand, "joint", n) for n in names]
        fingers = gripper.fingers if gripper else ()
        self.finger_bodies = [self._find(hand, "body", n) for n in fingers]
        self._moving = self.gripper_joints
        driven = [*self.arm_joints, *self.gripper_joints]
        efforts = list(self.limits.effort)
        if gripper is not None:
            motor = self._motor(hand, gripper)
            self.gripper_travel = self._travel(alone, motor)
            self._moving = [root.find("joint", n) for n in self.gripper_travel.joints]
            if motor is not None:
                driven[-len(names) :] = [motor]
            efforts += self._gripper_efforts(alone, motor)
        motors = ensure_motors(root, alone, driven, efforts, freed=self.gripper_joints)
        self.arm_actuators = motors[: len(self.arm_joints)]
        self.gripper_actuators = motors[len(self.arm_joints) :]

    def _build_observables(self) -> RobotObservables:
        return RobotObservables(self)

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        """The model that composer attaches."""
        return self._mjcf_root

    def _find(self, root: mjcf.RootElement, kind: str, name: str) -> Any:
        return find_element(root, kind, name, self._where)

    def _motor(self, hand: mjcf.RootElement, gripper: GripperDescription) -> Any:
        """Find the joint or tendon that the gripper's one motor moves; None where it has two."""
        if gripper.motor is None:
            return None
        return hand.find("tendon", gripper.motor) or self._find(hand, "joint", gripper.motor)

    def _travel(self, alone: mujoco.MjModel, motor: Any) -> FingerTravel:
        gripper = self.description.gripper
        assert gripper is not None
        joints = [joint.full_identifier for joint in self.gripper_joints]
        if is_direct(alone, gripper, joints):
            return direct_travel(gripper, joints)
        return measure_travel(
            alone,
            gripper,
            joints=joints,
            fingers=[finger.full_identifier for finger in self.finger_bodies],
            motor=motor.full_identifier if motor else None,
            arm_joints=[joint.full_identifier for joint in self.arm_joints],
            where=self._where,
        )

    def _gripper_efforts(self, alone: mujoco.MjModel, motor: Any) -> list[float]:
        """Give the greatest effort of each motor of the gripper.

        A slide's motor makes what the model and the description both allow. The servo that a model
        puts on a mechanism says little of the real one's force: there, the description decides.
        """
        gripper, travel = self.description.gripper, self.gripper_travel
        assert gripper is not None
        if not travel.mass:
            joints = [joint.full_identifier for joint in self.gripper_joints]
            bounds = [effort_limit(alone, find(alone, _JOINT, name)) for name in joints]
            return [min(bound, gripper.max_force) for bound in bounds]
        return travel.efforts(gripper.max_force, together=motor is not None)

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind addresses and raw views of the compiled model (composer's hook)."""
        del random_state
        self.mj_model = model = physics.model.ptr
        self.mj_data = physics.data.ptr

        def joints(elements: list[Any]) -> list[int]:
            return [find(model, _JOINT, e.full_identifier) for e in elements]

        def motors(elements: list[Any]) -> np.ndarray:
            ids = [model.actuator(e.full_identifier).id for e in elements]
            return np.array(ids, dtype=np.intp)

        arm, gripper = joints(self.arm_joints), joints(self.gripper_joints)
        self.qpos_adr, self.dof_adr = model.jnt_qposadr[arm], model.jnt_dofadr[arm]
        data = self.mj_data
        self._q = reader(data.qpos, self.qpos_adr)
        self._v, self._a, self._tau = [
            reader(x, self.dof_adr) for x in (data.qvel, data.qacc, data.qfrc_actuator)
        ]
        self.gripper_qpos_adr = model.jnt_qposadr[gripper]
        moving = joints(self._moving)
        self._moving_qpos_adr = model.jnt_qposadr[moving]
        self._moving_dof_adr = model.jnt_dofadr[moving]
        self.gripper_dof_adr = model.jnt_dofadr[gripper]
        self.ctrl_adr = motors(self.arm_actuators)
        self.gripper_ctrl_adr = motors(self.gripper_actuators)
        self.tool_site_id = int(model.site(self.tool_site.full_identifier).id)
        self.wrist_body_id = wrist_of(model, self.tool_site_id, arm)
        self.finger_body_ids = tuple(
            int(model.body(body.full_identifier).id) for body in self.finger_bodies
        )
        collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
        self.finger_geom_ids = tuple(
            tuple(int(g) for g in np.flatnonzero((model.geom_bodyid == body) & collides))
            for body in self.finger_body_ids
        )

    def initialize_episode(
        self, physics: mjcf.Physics, random_state: np.random.RandomState
    ) -> None:
        """Put the arm home and open the gripper (composer's hook)."""
        del physics, random_state
        self.set_configuration(np.array(self.description.home))
        if self.description.gripper is not None:
            self.set_opening(self.mj_data.qpos, self.gripper_travel.open_width)
            self.mj_data.qvel[self._moving_dof_adr] = 0.0

    def set_opening(self, qpos: np.ndarray, width: float) -> None:
        """Write the positions that the gripper's joints have at an opening [m] into a ``qpos``."""
        qpos[self._moving_qpos_adr] = self.gripper_travel.configuration(width)

    def set_configuration(self, q: np.ndarray) -> None:
        """Put the arm at a configuration, at rest; the caller calls ``mj_forward``."""
        self.mj_data.qpos[self.qpos_adr] = q
        self.mj_data.qvel[self.dof_adr] = 0.0

    @property
    def q(self) -> np.ndarray:
        """Positions of the arm's joints, a copy [rad]."""  # (nq,)
        return self._q().copy()

    @property
    def v(self) -> np.ndarray:
        """Velocities of the arm's joints, a copy [rad/s]."""  # (nq,)
        return self._v().copy()

    @property
    def a(self) -> np.ndarray:
        """Accelerations of the arm's joints in the last step, a copy [rad/s2]."""  # (nq,)
        return self._a().copy()

    @property
    def tau(self) -> np.ndarray:
        """Efforts that the arm's motors made in the last step, a copy [N m]."""  # (nq,)
        return self._tau().copy()

    @property
    def tool_pose(self) -> pin.SE3:
        """Pose T_wt of the tool as simulated, at the last ``mj_forward`` or step."""
        data, site = self.mj_data, self.tool_site_id
        return pin.SE3(data.site_xmat[site].reshape(3, 3).copy(), data.site_xpos[site].copy())

    @property
    def tool_velocity(self) -> np.ndarray:
        """Velocity of the tool: linear, then angular, in the world, as of the last step."""
        return tool_velocity(self.mj_model, self.mj_data, self.tool_site_id)  # (6,) [m/s, rad/s]

    def wrist_wrench(self, frame: pin.SE3 | None = None) -> WristWrench:
        """Give the wrench that the last link exerts on what is mounted on it, as of the last step.

        Args:
            frame: The wrench is taken about its origin, along its axes; default: the tool's.
        """
        body = self.wrist_body_id
        return wrist_wrench(self.mj_model, self.mj_data, body, frame or self.tool_pose)

    def make_model(self) -> RobotModel:
        """Build the model for planning and control; the robot must be compiled into a world.

        The gripper is locked half open. Each caller gets a model of its own.
        """
        if not hasattr(self, "mj_model"):
            raise RobotError(
                f"robot '{self.description.name}' is not compiled yet: attach it to an arena and "
                "compile, or add it to a cell"
            )
        qpos = self.mj_model.qpos0.copy()
        if self.description.gripper is not None:
            travel = self.gripper_travel
            middle = 0.5 * (travel.open_width + travel.min_width)
            qpos[self._moving_qpos_adr] = travel.configuration(middle)
        return RobotModel(
            self.mj_model,
            joints=[joint.full_identifier for joint in self.arm_joints],
            tool_frame=self.tool_site.full_identifier,
            limits=self.limits,
            home=self.description.home,
            tool_limits=self.description.tool_limits,
            qpos=qpos,
        )


def compile_alone(robot: Robot) -> mjcf.Physics:
    """Compile a robot that stands alone at the origin, at home: for planning without a cell."""
    physics = mjcf.Physics.from_mjcf_model(robot.mjcf_model)
    state = np.random.RandomState(0)
    robot.after_compile(physics, state)
    robot.initialize_episode(physics, state)
    physics.forward()
    return physics

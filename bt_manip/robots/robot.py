"""A robot as a composer entity: an arm with torque motors, a tool and an optional gripper."""

from collections.abc import Callable, Sequence
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import mjcf

from bt_manip.cell import MonitoredEntity, Wrench
from bt_manip.exceptions import MotionError
from bt_manip.spatial import cross

from .addresses import reader
from .assembly import assemble, find_element
from .bounds import ArmBounds
from .configurations import Configuration, find_configuration
from .errors import GripperError, RobotError
from .gripper import Gripper
from .motion_limits import read_limits
from .motors import ensure_motors
from .robot_description import RobotDescription
from .robot_model import RobotModel
from .robot_observables import RobotObservables


class Robot(MonitoredEntity):
    """An arm from an MJCF file, commanded by torques.

    World settings in the file (options, keyframes) are dropped: the arena defines them. Position
    servos and other actuators of the arm's joints are replaced by motors with the same effort
    limits, so that every arm that MuJoCo loads accepts the same controllers.

    Attributes:
        gripper: Its gripper; None if it has none or was built without a gripper class.
        alone: The robot's model compiled on its own, as in its files.
        gripper_root: The part of the model that contains the gripper's elements.
        warnings: What is strange in its model files, or was lost in their conversion.
        qpos_adr: Addresses of the arm's positions in ``qpos``.  # (nq,)
        dof_adr: Addresses of the arm's degrees of freedom in ``qvel``.  # (nq,)
        ctrl_adr: Addresses of the arm's motors in ``ctrl``.  # (nq,)
        read_q: Returns the measured positions without a copy [rad]; each compile sets it to the
            true ones. Arm and controller measure by it, so that faults of sensors replace it.
        read_v: Returns the measured velocities, likewise [rad/s].
        read_a: Returns the accelerations in the last step without a copy [rad/s2].
        read_tau: Returns the efforts of the motors in the last step without a copy [N m].
        read_tau_external: Returns the external torques that a real arm measures [N m], NaN if it
            knows none; None in simulation, where they are estimated.
        tool_site_id: Id of the tool site in the compiled model.
        wrist_body_id: Id of the body mounted on the last link, in the compiled model.
    """

    def _build(
        self,
        description: RobotDescription,
        gripper: Callable[["Robot"], Gripper] | None = None,
        bounds: ArmBounds | None = None,
    ) -> None:
        """Build the robot's model.

        Args:
            description: The robot's description.
            gripper: Factory of its gripper, of the description's kind; None leaves the gripper's
                parts in the model passive. Ignored if the description has no gripper.
            bounds: Bounds of its motions, within the position limits.

        Raises:
            RobotError: If the description and its model do not match.
        """
        self.description = description
        self.configurations: dict[str, Configuration] = {
            "home": description.home,
            **description.configurations,
        }
        self._where = description.where
        self.read_tau_external: Callable[[], np.ndarray] | None = None
        root, alone, hand, self.tool_site, self.warnings = assemble(description)
        self.limits = read_limits(alone, description)
        if bounds is not None:
            self.limits = bounds.narrowed(self.limits, description)
        try:
            self.limits.checked(np.array(description.home))
        except MotionError as error:
            raise RobotError(f"{self._where}: home: {error}") from None
        self._mjcf_root = root
        self.alone, self.gripper_root = alone, hand
        self.arm_joints = [self.find("joint", n, root) for n in description.arm_joints]
        efforts = list(self.limits.effort)
        self.arm_actuators = ensure_motors(root, alone, self.arm_joints, efforts)
        self.gripper: Gripper | None = None
        if gripper is not None and description.gripper is not None:
            self.gripper = gripper(self)
            self.attach(self.gripper)

    def _build_observables(self) -> RobotObservables:
        return RobotObservables(self)

    def configuration(self, name: str) -> tuple[float, ...]:
        """Return the joint positions of a named configuration [rad].

        Raises:
            MotionError: If the name is unknown or the configuration is for other joints.
        """
        return find_configuration(name, self.configurations, self.description.arm_joints)

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        """The model that composer attaches."""
        return self._mjcf_root

    def find(self, kind: str, name: str, root: mjcf.RootElement | None = None) -> Any:
        """Return a named element of the gripper's part of the model, or of another part.

        Args:
            kind: ``"joint"``, ``"body"``, ``"tendon"``, ...
            name: Its name in that part.
            root: Part of the model to search; default: `gripper_root`.

        Raises:
            RobotError: If there is no such element; the message suggests the nearest names.
        """
        return find_element(root or self.gripper_root, kind, name, self._where)

    @property
    def needed_gripper(self) -> Gripper:
        """Its gripper.

        Raises:
            GripperError: If it has none.
        """
        if self.gripper is None:
            raise GripperError(f"robot '{self.description.name}' has no gripper")
        return self.gripper

    @property
    def contact_bodies(self) -> Sequence[Any]:
        """Bodies (PyMJCF elements) that may touch objects: those of the gripper."""
        return self.gripper.contact_bodies if self.gripper is not None else ()

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind addresses and raw views of the compiled model (composer's hook)."""
        del random_state
        self.mj_model = model = physics.model.ptr
        self.mj_data = physics.data.ptr

        arm = [model.joint(joint.full_identifier).id for joint in self.arm_joints]
        self.qpos_adr, self.dof_adr = model.jnt_qposadr[arm], model.jnt_dofadr[arm]
        data = self.mj_data
        self.read_q = reader(data.qpos, self.qpos_adr)
        self.read_v = reader(data.qvel, self.dof_adr)
        self.read_a = reader(data.qacc, self.dof_adr)
        motors = [model.actuator(motor.full_identifier).id for motor in self.arm_actuators]
        self.ctrl_adr = np.array(motors, dtype=np.intp)
        # qfrc_actuator would add the torque of other actuators on these joints, such as adhesion.
        self.read_tau = reader(data.actuator_force, self.ctrl_adr)
        self.tool_site_id = int(model.site(self.tool_site.full_identifier).id)
        self.wrist_body_id = _wrist(model, self.tool_site_id, arm)

    def initialize_episode(
        self, physics: mjcf.Physics, random_state: np.random.RandomState
    ) -> None:
        """Set the arm to its home configuration (composer's hook)."""
        del physics, random_state
        self.set_configuration(np.array(self.description.home))

    def set_configuration(self, q: np.ndarray) -> None:
        """Set the arm's configuration, with zero velocity; the caller calls ``mj_forward``."""
        self.mj_data.qpos[self.qpos_adr] = q
        self.mj_data.qvel[self.dof_adr] = 0.0

    @property
    def q(self) -> np.ndarray:
        """Measured positions of the arm's joints, a copy [rad]."""  # (nq,)
        return self.read_q().copy()

    @property
    def v(self) -> np.ndarray:
        """Measured velocities of the arm's joints, a copy [rad/s]."""  # (nq,)
        return self.read_v().copy()

    @property
    def a(self) -> np.ndarray:
        """Accelerations of the arm's joints in the last step, a copy [rad/s2]."""  # (nq,)
        return self.read_a().copy()

    @property
    def tau(self) -> np.ndarray:
        """Efforts of the arm's motors in the last step, a copy [N m]."""  # (nq,)
        return self.read_tau().copy()

    @property
    def measurement_problem(self) -> str:
        """Which measured position or velocity is not finite; empty when all are."""
        for name, values in (("position", self.q), ("velocity", self.v)):
            for joint in np.flatnonzero(~np.isfinite(values)).tolist():
                return f"the measured {name} of joint {joint + 1} is {values[joint]}"
        return ""

    @property
    def tool_pose(self) -> pin.SE3:
        """Pose T_wt of the tool as simulated, at the last ``mj_forward`` or step."""
        data, site = self.mj_data, self.tool_site_id
        return pin.SE3(data.site_xmat[site].reshape(3, 3).copy(), data.site_xpos[site].copy())

    @property
    def tool_velocity(self) -> np.ndarray:
        """Velocity of the tool: linear, then angular, in the world, as of the last step."""
        velocity, site = np.zeros(6), mujoco.mjtObj.mjOBJ_SITE
        mujoco.mj_objectVelocity(self.mj_model, self.mj_data, site, self.tool_site_id, velocity, 0)
        return np.concatenate([velocity[3:], velocity[:3]])  # (6,) [m/s, rad/s]

    def wrist_wrench(self, frame: pin.SE3 | None = None) -> Wrench:
        """Return the wrench of the last link on the bodies mounted on it, as of the last step.

        The forces between bodies are computed on demand; a force sensor in the model would make
        MuJoCo compute them in every step.

        Args:
            frame: Frame in which the wrench is expressed, torque about its origin; default: the
                tool frame.
        """
        model, data, body = self.mj_model, self.mj_data, self.wrist_body_id
        T = frame or self.tool_pose
        mujoco.mj_rnePostConstraint(model, data)
        # cfrc_int: torque over force, in the world's axes, about the centre of mass of the tree.
        torque, force = data.cfrc_int[body, :3].copy(), data.cfrc_int[body, 3:].copy()
        torque += cross(data.subtree_com[model.body_rootid[body]] - T.translation, force)
        return Wrench(T.rotation.T @ force, T.rotation.T @ torque)

    def make_model(self) -> RobotModel:
        """Build the model for planning and control; the robot must be compiled into a world.

        The gripper is locked half open. Each call returns a new model.
        """
        if not hasattr(self, "mj_model"):
            raise RobotError(
                f"robot '{self.description.name}' is not compiled yet: attach it to an arena and "
                "compile, or add it to a cell"
            )
        qpos = self.mj_model.qpos0.copy()
        if self.gripper is not None:
            self.gripper.set_opening(qpos, 0.5)
        return self._model_of(self.mj_model, qpos)

    def model_alone(self) -> RobotModel:
        """Build the model before the robot is compiled into a world, the gripper as in its file."""
        root = self._mjcf_root
        model = mujoco.MjModel.from_xml_string(root.to_xml_string(), root.get_assets())
        return self._model_of(model, model.qpos0)

    def _model_of(self, mj_model: mujoco.MjModel, qpos: np.ndarray) -> RobotModel:
        return RobotModel(
            mj_model,
            joints=[joint.full_identifier for joint in self.arm_joints],
            tool_frame=self.tool_site.full_identifier,
            limits=self.limits,
            home=self.description.home,
            tolerance=self.description.tolerance,
            qpos=qpos,
        )


def _wrist(model: mujoco.MjModel, site: int, joints: list[int]) -> int:
    """Return the body that is mounted on the last link, where a wrist sensor would be.

    This is the last link itself if no separate body is mounted on it.

    Args:
        model: The compiled model.
        site: Id of the tool site.
        joints: Ids of the arm's joints.
    """
    links = {int(body) for body in model.jnt_bodyid[joints]}
    body = mounted = int(model.site_bodyid[site])
    while body and body not in links:
        mounted, body = body, int(model.body_parentid[body])
    return mounted


def compile_alone(robot: Robot) -> mjcf.Physics:
    """Compile a robot on its own, at its home configuration, for planning without a cell."""
    physics = mjcf.Physics.from_mjcf_model(robot.mjcf_model)
    state = np.random.RandomState(0)
    for entity in robot.iter_entities():
        entity.after_compile(physics, state)
    for entity in robot.iter_entities():
        entity.initialize_episode(physics, state)
    physics.forward()
    return physics

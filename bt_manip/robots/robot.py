"""A robot as a composer entity: arm joints with torque motors, a gripper, a tool."""

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import composer, mjcf

from bt_manip.exceptions import did_you_mean

from .errors import RobotError
from .limit_reading import effort_limit, is_motor, read_limits
from .model_building import find
from .robot_description import RobotDescription
from .robot_model import RobotModel
from .robot_observables import RobotObservables

_JOINT = int(mujoco.mjtObj.mjOBJ_JOINT)
_WORLD_SETTINGS = ("option", "visual", "statistic", "size")


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
        finger_body_ids: The finger bodies in the compiled model.
        finger_geom_ids: Geoms of each finger that collide, in the compiled model.
        tool_site_id: The tool in the compiled model.
    """

    def _build(self, description: RobotDescription, name: str | None = None) -> None:
        if not Path(description.model).is_file():
            raise RobotError(f"robot '{description.name}': no model file {description.model}")
        try:
            alone = mujoco.MjModel.from_xml_path(description.model)
        except ValueError as error:
            raise RobotError(f"robot '{description.name}': {description.model}: {error}") from error
        self.description = description
        self.limits = read_limits(alone, description)
        root = mjcf.from_path(description.model, escape_separators=True)
        root.model = name or description.name
        self._mjcf_root = root
        self.arm_joints = [self._find("joint", n) for n in description.arm_joints]
        self.tool_site = self._find("site", description.tool_frame)
        gripper = description.gripper
        names = gripper.joints if gripper else ()
        self.gripper_joints = [self._find("joint", n) for n in names]
        self.finger_bodies = [self._find("body", n) for n in (gripper.fingers if gripper else ())]
        _drop_world(root)
        efforts = [*self.limits.effort, *(self._gripper_effort(alone, n) for n in names)]
        motors = _ensure_motors(root, alone, [*self.arm_joints, *self.gripper_joints], efforts)
        self.arm_actuators = motors[: len(self.arm_joints)]
        self.gripper_actuators = motors[len(self.arm_joints) :]

    def _build_observables(self) -> RobotObservables:
        return RobotObservables(self)

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        """The model that composer attaches."""
        return self._mjcf_root

    def _find(self, kind: str, name: str) -> Any:
        element = self._mjcf_root.find(kind, name)
        if element is None:
            known = sorted(e.name for e in self._mjcf_root.find_all(kind) if e.name)
            raise RobotError(
                f"robot '{self.description.name}': {self.description.model} has no {kind} "
                f"'{name}'{did_you_mean(name, known)}"
            )
        return element

    def _gripper_effort(self, alone: mujoco.MjModel, joint: str) -> float:
        assert self.description.gripper is not None
        bound = effort_limit(alone, find(alone, _JOINT, joint))
        return min(bound, self.description.gripper.max_force)

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
        self.gripper_qpos_adr = model.jnt_qposadr[gripper]
        self.gripper_dof_adr = model.jnt_dofadr[gripper]
        self.ctrl_adr = motors(self.arm_actuators)
        self.gripper_ctrl_adr = motors(self.gripper_actuators)
        self.tool_site_id = int(model.site(self.tool_site.full_identifier).id)
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
        gripper = self.description.gripper
        if gripper is not None:
            opening = gripper.open_width / len(gripper.joints)
            self.mj_data.qpos[self.gripper_qpos_adr] = opening
            self.mj_data.qvel[self.gripper_dof_adr] = 0.0

    def set_configuration(self, q: np.ndarray) -> None:
        """Put the arm at a configuration, at rest; the caller calls ``mj_forward``."""
        self.mj_data.qpos[self.qpos_adr] = q
        self.mj_data.qvel[self.dof_adr] = 0.0

    @property
    def q(self) -> np.ndarray:
        """Positions of the arm's joints, a copy [rad]."""  # (nq,)
        return self.mj_data.qpos[self.qpos_adr]

    @property
    def v(self) -> np.ndarray:
        """Velocities of the arm's joints, a copy [rad/s]."""  # (nq,)
        return self.mj_data.qvel[self.dof_adr]

    @property
    def tau(self) -> np.ndarray:
        """Efforts that the arm's motors made in the last step, a copy [N m]."""  # (nq,)
        return self.mj_data.qfrc_actuator[self.dof_adr]

    @property
    def tool_pose(self) -> pin.SE3:
        """Pose T_wt of the tool as simulated, at the last ``mj_forward`` or step."""
        data, site = self.mj_data, self.tool_site_id
        return pin.SE3(data.site_xmat[site].reshape(3, 3).copy(), data.site_xpos[site].copy())

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
        gripper = self.description.gripper
        if gripper is not None:
            middle = 0.5 * (gripper.open_width + gripper.min_width)
            qpos[self.gripper_qpos_adr] = middle / len(gripper.joints)
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


def _drop_world(root: mjcf.RootElement) -> None:
    """Leave out what belongs to the world, and gravity compensation, which is the controller's."""
    for name in _WORLD_SETTINGS:
        element = getattr(root, name)
        for attribute in list(element.get_attributes()):
            delattr(element, attribute)
    for key in list(root.keyframe.all_children()):
        key.remove()
    for body in root.find_all("body"):
        if body.gravcomp is not None:
            del body.gravcomp


def _ensure_motors(
    root: mjcf.RootElement, alone: mujoco.MjModel, joints: list[Any], efforts: list[float]
) -> list[Any]:
    """Give each joint exactly one motor and take all other actuators off them."""
    kept: dict[str, Any] = {}
    names = {joint.name for joint in joints}
    for actuator in list(root.find_all("actuator")):
        joint = getattr(actuator, "joint", None)
        tendon = getattr(actuator, "tendon", None)
        if joint is not None and joint.name in names:
            i = _index(alone, actuator)
            plain = i is not None and is_motor(alone, i) and alone.actuator_gear[i, 0] == 1.0
            if plain and joint.name not in kept:
                kept[joint.name] = actuator
                continue
        elif tendon is None or not _pulls_only(tendon, names):
            continue
        actuator.remove()
    motors = []
    for joint, effort in zip(joints, efforts, strict=True):
        motor = kept.get(joint.name)
        if motor is None:
            motor = root.actuator.add(
                "motor", name=f"{joint.name}_motor", joint=joint, gear=[1.0, 0, 0, 0, 0, 0]
            )
        motor.ctrllimited = motor.forcelimited = "true"
        motor.ctrlrange = motor.forcerange = [-float(effort), float(effort)]
        motors.append(motor)
    return motors


def _index(alone: mujoco.MjModel, actuator: Any) -> int | None:
    found = mujoco.mj_name2id(alone, int(mujoco.mjtObj.mjOBJ_ACTUATOR), actuator.name or "")
    return int(found) if found >= 0 else None


def _pulls_only(tendon: Any, names: set[str]) -> bool:
    pulled = [getattr(child, "joint", None) for child in tendon.all_children()]
    return bool(pulled) and all(joint is not None and joint.name in names for joint in pulled)

"""What a learner or a recorder can observe of a robot, by composer's means."""

from dm_control import composer
from dm_control.composer.observation import observable


class RobotObservables(composer.Observables):
    """Joint positions, velocities and torques, the gripper's joints, the tool's pose."""

    @composer.observable
    def joint_positions(self) -> observable.Observable:
        """Positions of the arm's joints [rad]."""
        return observable.MJCFFeature("qpos", self._entity.arm_joints)

    @composer.observable
    def joint_velocities(self) -> observable.Observable:
        """Velocities of the arm's joints [rad/s]."""
        return observable.MJCFFeature("qvel", self._entity.arm_joints)

    @composer.observable
    def joint_torques(self) -> observable.Observable:
        """Efforts that the motors make at the arm's joints [N m]."""
        return observable.MJCFFeature("qfrc_actuator", self._entity.arm_joints)

    @composer.observable
    def gripper_positions(self) -> observable.Observable:
        """Positions of the gripper's joints [m]."""
        return observable.MJCFFeature("qpos", self._entity.gripper_joints)

    @composer.observable
    def tool_position(self) -> observable.Observable:
        """Position of the tool in the world [m]."""
        return observable.MJCFFeature("xpos", self._entity.tool_site)

    @composer.observable
    def tool_rotation(self) -> observable.Observable:
        """Rotation matrix of the tool in the world, row by row."""
        return observable.MJCFFeature("xmat", self._entity.tool_site)

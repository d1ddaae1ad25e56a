"""Composer observables of a robot, for learning and recording."""

from dm_control import composer
from dm_control.composer.observation import observable


class RobotObservables(composer.Observables):
    """Joint states, the tool's pose and velocity, and the wrist wrench."""

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
        """Efforts of the motors of the arm's joints [N m]."""
        return observable.MJCFFeature("force", self._entity.arm_actuators)

    @composer.observable
    def tool_position(self) -> observable.Observable:
        """Position of the tool in the world [m]."""
        return observable.MJCFFeature("xpos", self._entity.tool_site)

    @composer.observable
    def tool_rotation(self) -> observable.Observable:
        """Rotation matrix of the tool in the world, row by row."""
        return observable.MJCFFeature("xmat", self._entity.tool_site)

    @composer.observable
    def tool_velocity(self) -> observable.Observable:
        """Velocity of the tool: linear, then angular, in the world [m/s, rad/s]."""
        return observable.Generic(lambda physics: self._entity.tool_velocity)

    @composer.observable
    def wrist_force(self) -> observable.Observable:
        """Force of the last link on the bodies mounted on it, in the tool's axes [N]."""
        return observable.Generic(lambda physics: self._entity.wrist_wrench().force)

    @composer.observable
    def wrist_torque(self) -> observable.Observable:
        """Torque of the same wrench about the tool's origin, in the tool's axes [N m]."""
        return observable.Generic(lambda physics: self._entity.wrist_wrench().torque)

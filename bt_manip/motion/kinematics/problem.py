"""Inverse kinematics as one states it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..checks import check_pose
from ..collision import CollisionWorld
from ..errors import MotionError
from .targets import Target, positive

POSTURE_WEIGHT = 1e-2  # [1/s2]


@dataclass(frozen=True, eq=False, kw_only=True)
class IKProblem:
    """What a configuration has to meet, and what it should be like beside that.

    Targets with a tolerance are constraints. Where they leave freedom, the sum of all costs is
    made least: of the targets with a weight, of `posture` and of `manipulability`.

    Attributes:
        targets: What frames shall do; any number of them, also none.
        joints: Names of the joints that may move, by default all; the others stay where the
            search starts.
        base: Pose T_wb of the robot's base in the world that targets are given in; by default
            where it stands.
        margin: How far to stay from the limits [rad], for all joints or for each.
        posture: A configuration to be near to [rad].  # (nq,)
        posture_weight: What half the squared distance from it costs [1/s2]; distances are those of
            `InverseKinematics.distance`.
        manipulability: What a unit less of the logarithm of the tool's manipulability costs.
        free: What the arm shall not touch; by default it does not look.
        clearance: How far from that it shall be [m].
    """

    targets: Sequence[Target] = ()
    joints: Sequence[str] | None = None
    base: pin.SE3 | None = None
    margin: float | Sequence[float] | np.ndarray = 0.0
    posture: Sequence[float] | np.ndarray | None = None
    posture_weight: float = POSTURE_WEIGHT
    manipulability: float = 0.0
    free: CollisionWorld | None = None
    clearance: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what can be seen to be wrong without the arm.

        Raises:
            MotionError: Naming what is wrong.
        """
        targets = [self.targets] if isinstance(self.targets, Target) else list(self.targets)
        for target in targets:
            if not isinstance(target, Target):
                raise MotionError(
                    "a target is a PositionTarget, RotationTarget or PoseTarget, "
                    f"got {type(target).__name__}",
                    reason="target",
                )
        object.__setattr__(self, "targets", tuple(targets))
        if not targets and self.posture is None and not self.manipulability:
            raise MotionError("the problem asks for nothing: it has no target", reason="target")
        if not positive(self.posture_weight):
            raise MotionError(
                f"posture_weight is above 0, got {self.posture_weight!r}", reason="target"
            )
        for name in ("manipulability", "clearance"):
            value = getattr(self, name)
            if value != 0.0 and not positive(value):
                raise MotionError(f"{name} is 0 or above, got {value!r}", reason="target")
        if self.base is not None:
            try:
                check_pose(self.base)
            except MotionError as error:
                raise MotionError(f"the base: {error}", reason="target") from None
            if self.free is not None:
                raise MotionError(
                    "what the arm touches is known where its base stands only: "
                    "a problem has a base or something to be free of",
                    reason="target",
                )

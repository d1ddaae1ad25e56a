"""The geometric reach of an arm, to refuse at once what no configuration can attain."""

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel


class Reach:
    """Upper bound of the distance between the arm's first and last points that do not turn.

    The first joint's axis does not move and the last joint's origin is fixed in the tool, so for
    a target the last origin is known. From the second joint's origin it is no farther than the
    links between are long.
    """

    def __init__(self, model: RobotModel) -> None:
        """Measure the links of an arm."""
        self._usable = False
        joints = model.model
        kinds = [joint.shortname() for joint in joints.joints.tolist()[1:]]
        serial = list(joints.parents)[1:] == list(range(joints.njoints - 1))
        if not serial or joints.njoints < 4 or any("JointModelR" not in kind for kind in kinds):
            return
        self._usable = True
        last = joints.njoints - 1
        self._T_tl = model.model.frames[model.tool_frame_id].placement.inverse()
        self._T_w1 = joints.jointPlacements[1]
        self._second = joints.jointPlacements[2].translation.copy()
        self._axis = _first_axis(joints)
        lengths = [
            float(np.linalg.norm(joints.jointPlacements[i].translation)) for i in range(3, last + 1)
        ]
        self.longest = sum(lengths)

    def refuse(self, T_wt: pin.SE3) -> str:
        """Say why a pose is beyond the reach; empty when it may be within."""
        if not self._usable:
            return ""
        wrist = self._T_w1.actInv((T_wt * self._T_tl).translation)
        along = float(self._axis @ wrist) - float(self._axis @ self._second)
        across = float(np.linalg.norm(wrist - self._axis * (self._axis @ wrist)))
        offset = float(np.linalg.norm(self._second - self._axis * (self._axis @ self._second)))
        distance = float(np.hypot(max(0.0, across - offset), along))
        if distance <= self.longest + 1e-9:
            return ""
        return f"{distance - self.longest:.3f} m out of reach"


def _first_axis(joints: pin.Model) -> np.ndarray:
    data = joints.createData()
    q = pin.neutral(joints)
    pin.forwardKinematics(joints, data, q, np.eye(joints.nv)[0])
    return data.v[1].angular.copy()

"""The geometric reach of an arm, to refuse at once what no configuration attains."""

from collections.abc import Callable

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

SLACK = 5e-4  # [m]
_STARTS = 6
_SWEEPS = 12


class Reach:
    """Greatest distance between a point that no joint moves and one that the tool fixes.

    The first is on the first joint's axis, the second is the last joint's origin: for a target
    pose both are known, and their distance does not depend on these two joints. Its greatest over
    the joints between is found once. Arms with other than revolute joints are not judged.
    """

    def __init__(self, model: RobotModel, samples: np.ndarray) -> None:
        """Search the greatest distance.

        Args:
            model: The arm.
            samples: Configurations to start the search from.  # (n, nq)
        """
        arm, self._data = model.model, model.data
        self._arm = arm
        self._last = arm.njoints - 1
        serial = list(arm.parents)[1:] == list(range(arm.njoints - 1))
        revolute = all("JointModelR" in joint.shortname() for joint in arm.joints.tolist()[1:])
        self._usable = serial and revolute and arm.njoints > 3
        if not self._usable:
            return
        frame = model.model.frames[model.tool_frame_id]
        self._last_origin = frame.placement.inverse().translation  # in the tool
        self._fixed = _foot(arm, self._data)
        lower = np.maximum(model.limits.lower, -np.pi)
        upper = np.minimum(model.limits.upper, np.pi)
        distances = np.array([self._distance(q) for q in samples])
        far = np.argsort(-distances, kind="stable")[:_STARTS]
        self.greatest = max(_climb(self._distance, samples[i], lower, upper) for i in far)

    def refuse(self, T_wt: pin.SE3) -> str:
        """Say why a pose is out of reach; empty when it may be within."""
        if not self._usable:
            return ""
        offset = T_wt.act(self._last_origin) - self._fixed
        distance = float(offset.dot(offset)) ** 0.5
        if distance > self.greatest + SLACK:
            return f"{distance - self.greatest:.3f} m out of reach"
        return ""

    def _distance(self, q: np.ndarray) -> float:
        pin.forwardKinematics(self._arm, self._data, q)
        offset = self._data.oMi[self._last].translation - self._fixed
        return float(offset.dot(offset)) ** 0.5


def _foot(arm: pin.Model, data: pin.Data) -> np.ndarray:
    """Give the point of the first axis that is nearest to the second joint."""
    q = pin.neutral(arm)
    pin.forwardKinematics(arm, data, q, np.eye(arm.nv)[0])
    first, second = data.oMi[1], data.oMi[2]
    axis = first.rotation @ data.v[1].angular
    along = float(axis.dot(second.translation - first.translation))
    return first.translation + along * axis


def _climb(
    distance: Callable[[np.ndarray], float],
    start: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
) -> float:
    """Climb joint by joint: along one, the squared distance is a constant plus a cosine."""
    q = start.copy()
    best = distance(q)
    for _ in range(_SWEEPS):
        before = best
        for i in range(1, len(q) - 1):
            kept = q[i]
            at = []
            for angle in (0.0, 0.5 * np.pi, np.pi):
                q[i] = angle
                at.append(distance(q) ** 2)
            constant = 0.5 * (at[0] + at[2])
            peak = np.arctan2(at[1] - constant, 0.5 * (at[0] - at[2]))
            turns = [peak, peak - 2.0 * np.pi, peak + 2.0 * np.pi]
            inside = [angle for angle in turns if lower[i] <= angle <= upper[i]]
            value, angle = -np.inf, kept
            for candidate in (kept, lower[i], upper[i], *inside):
                q[i] = candidate
                there = distance(q)
                if there > value:
                    value, angle = there, candidate
            q[i] = angle
            best = max(best, value)
        if best - before < 1e-9:
            break
    return best

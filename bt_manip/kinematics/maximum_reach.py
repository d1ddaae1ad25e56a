"""The maximum reach of an arm, to reject poses beyond it without a search."""

from collections.abc import Callable

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

from .targets import PoseTarget

REACH_MARGIN = 5e-4  # [m] accepted distance of a pose beyond the computed reach
_GUESSES = 6
_MAX_SWEEPS = 12
_MIN_IMPROVEMENT = 1e-9  # [m] per sweep


class MaximumReach:
    """Maximum distance between a fixed point of the first axis and the origin of the last joint.

    A target pose determines the origin of the last joint. The distance does not depend on the first
    and the last joint. There is no bound for arms other than serial chains of revolute joints.

    Args:
        model: The arm; its data are written to.
        samples: Configurations; those with the largest distance are initial guesses.  # (n, nq)

    Attributes:
        distance: The maximum distance [m]; infinite without a bound.
    """

    def __init__(self, model: RobotModel, samples: np.ndarray) -> None:
        arm, self._data = model.model, model.data
        self._arm, self._last = arm, arm.njoints - 1
        self.distance = np.inf
        serial = list(arm.parents)[1:] == list(range(arm.njoints - 1))
        if not serial or "m" in model.units or arm.njoints <= 3:
            return
        placement = arm.frames[model.tool_frame_id].placement
        self._last_origin = placement.inverse().translation  # in the tool frame
        self._fixed = _foot(arm, self._data)
        lower, upper = model.limits.sampling_bounds()
        distances = np.array([self.distance_at(q) for q in samples])
        far = np.argsort(-distances, kind="stable")[:_GUESSES]
        self.distance = max(_maximize(self.distance_at, samples[i], lower, upper) for i in far)

    def excess(self, target: pin.SE3 | PoseTarget) -> float:
        """Return the distance of a tool target beyond the reach [m]; 0 if it may be within."""
        if self.distance == np.inf:
            return 0.0
        point, free = self._last_origin, 0.0
        if isinstance(target, pin.SE3):
            T_wt = target
        else:
            # The last joint's origin is on a circle about the axis, which tilts inside the cone.
            T_wt, pivot, axis = target.pose, np.asarray(target.pivot), np.asarray(target.free_axis)
            tolerance, cone = target.tolerances
            cone = min(cone, 0.5 * np.pi)
            along = axis.dot(point - pivot)
            beside = float(np.linalg.norm(point - pivot - along * axis))
            free = tolerance + beside + abs(along) * np.sin(cone)
            point = pivot + np.cos(cone) * along * axis
        offset = T_wt.act(point) - self._fixed
        excess = float(offset.dot(offset)) ** 0.5 - self.distance - free
        return excess if excess > REACH_MARGIN else 0.0

    def distance_at(self, q: np.ndarray) -> float:
        """Return the distance at a configuration [m]."""
        pin.forwardKinematics(self._arm, self._data, q)
        offset = self._data.oMi[self._last].translation - self._fixed
        return float(offset.dot(offset)) ** 0.5


def _foot(arm: pin.Model, data: pin.Data) -> np.ndarray:
    """Return the point of the first axis nearest to the second joint."""
    pin.forwardKinematics(arm, data, pin.neutral(arm), np.eye(arm.nv)[0])
    first, second = data.oMi[1], data.oMi[2]
    axis = first.rotation @ data.v[1].angular
    return first.translation + axis * axis.dot(second.translation - first.translation)


def _maximize(
    distance: Callable[[np.ndarray], float],
    guess: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
) -> float:
    """Maximize by coordinate ascent; the squared distance is a sinusoid of each joint."""
    q = guess.copy()
    best = distance(q)
    for _ in range(_MAX_SWEEPS):
        before = best
        for i in range(1, len(q) - 1):
            values = {q[i]: best}
            squared = []
            for angle in (0.0, 0.5 * np.pi, np.pi):
                q[i] = angle
                squared.append(distance(q) ** 2)
            mean = 0.5 * (squared[0] + squared[2])
            peak = np.arctan2(squared[1] - mean, 0.5 * (squared[0] - squared[2]))
            turns = [peak, peak - 2.0 * np.pi, peak + 2.0 * np.pi]
            inside = [angle for angle in turns if lower[i] <= angle <= upper[i]]
            for angle in (lower[i], upper[i], *inside):
                q[i] = angle
                values[angle] = distance(q)
            q[i] = max(values, key=values.__getitem__)
            best = max(best, values[q[i]])
        if best - before < _MIN_IMPROVEMENT:
            break
    return best

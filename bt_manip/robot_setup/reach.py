"""Positions that the tool of a robot reaches from above."""

from collections import Counter
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.collision import CollisionWorld
from bt_manip.kinematics import IKProblem, InverseKinematics, PoseTarget, manipulability
from bt_manip.robots import Robot, RobotModel

_SAMPLES = 500  # random configurations from which the size of the arm is estimated
_AZIMUTHS = np.arange(8) * np.pi / 4  # [rad] in which the front of the arm is searched
_AHEAD = 0.5  # [rad] by which the first hinge has to be nearer to the middle of its range
_RADII = np.linspace(0.05, 1.0, 20)  # of the farthest position
_HEIGHTS = np.linspace(-0.5, 0.8, 14)  # of the farthest position
_FEW, _MANY = 20, 60  # initial guesses of a search, besides the last solution or the middle
_ROUNDING = 1e-3  # [m] of the height of a joint
_SELF_CLEARANCE = 5e-3  # [m] of the arm from itself at home


class RadialReach(NamedTuple):
    """Positions of a tool that points down, in front of the arm.

    The same is assumed for all directions about the vertical through `axis`.

    Attributes:
        axis: Position of the first vertical hinge in the base [m].  # (2,)
        front: Direction in which the arm points in the middle of that hinge's range [rad].
        radii: Distances from the axis [m].  # (n,)
        heights: Heights above the origin of the base [m].  # (m,)
        lowest: Height of the lowest joint when each position is reached without self-collision,
            -inf where it is not [m].  # (m, n)
    """

    axis: np.ndarray
    front: float
    radii: np.ndarray
    heights: np.ndarray
    lowest: np.ndarray

    def reached(self, floor: float) -> np.ndarray:
        """Return whether each position is reached with all joints above a height [m]."""  # (m, n)
        return np.array(self.lowest > floor - _ROUNDING)

    def covers(self, radius: np.ndarray, height: np.ndarray, floor: float) -> np.ndarray:
        """Return whether the measured positions next to each position are reached.

        Args:
            radius: Distances from the axis [m].  # (k,)
            height: Heights above the origin of the base [m].  # (k,)
            floor: Height above which all joints stay [m].
        """  # (k,)
        reached = self.reached(floor)
        inside = np.ones(radius.shape, dtype=bool)
        cells = []
        for values, grid in ((radius, self.radii), (height, self.heights)):
            inside &= (values >= grid[0]) & (values <= grid[-1])
            cells.append(np.clip(np.searchsorted(grid, values) - 1, 0, len(grid) - 2))
        column, row = cells
        for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
            inside &= reached[row + i, column + j]
        return inside


class DownwardReach:
    """Finds configurations free of self-collision in which the tool points down."""

    def __init__(self, robot: Robot, model: RobotModel) -> None:
        """Prepare for a robot that is compiled alone.

        Args:
            robot: The robot.
            model: Its model.
        """
        self._robot, self._model = robot, model
        self._ik = InverseKinematics(model)
        self._world = CollisionWorld(robot, model)
        lower, upper = model.limits.sampling_bounds()
        self._colliding: Counter[tuple[str, str]] = Counter()
        self._middle, self._half = 0.5 * (lower + upper), 0.5 * (upper - lower)

    def configuration(self, position: np.ndarray) -> np.ndarray | None:
        """Return a configuration far from limits and singularities, or None.

        Args:
            position: Of the tool [m].  # (3,)
        """  # (nq,)
        best, least = None, np.inf
        for result in self._ik.solutions(_down(self._ik, position), self._middle, restarts=_MANY):
            q = np.array(result.q)
            if self._lowest(q) > -_ROUNDING and self._is_free(q, _SELF_CLEARANCE):
                off = (q - self._middle) / self._half
                volume = manipulability(self._model.jacobian(q))
                cost = float(np.sum(2.0 * off**2 + off**8) - 0.3 * np.log(volume + 1e-9))
                if cost < least - 1e-9:
                    best, least = q, cost
        return best

    def measure(self) -> RadialReach:
        """Measure the reach in front of the arm."""
        axis = self._axis()
        size = self._size(axis)
        front, q = self._front(axis, size)
        direction = np.array([np.cos(front), np.sin(front)])
        lowest = np.full((len(_HEIGHTS), len(_RADII)), -np.inf)
        for i, height in enumerate(size * _HEIGHTS):
            for j, radius in enumerate(size * _RADII):
                position = np.array([*(axis + radius * direction), height])
                found = self.solve(position, q, floor=-np.inf)
                if found is not None:
                    lowest[i, j], q = self._lowest(found), found
        return RadialReach(axis, front, size * _RADII, size * _HEIGHTS, lowest)

    def _axis(self) -> np.ndarray:
        model, data = self._robot.mj_model, self._robot.mj_data
        joints = model.dof_jntid[self._robot.dof_adr]
        vertical = np.abs(data.xaxis[joints, 2]) > 0.99
        hinges = vertical & (model.jnt_type[joints] == int(mujoco.mjtJoint.mjJNT_HINGE))
        return np.array(data.xanchor[joints[int(np.argmax(hinges))], :2])

    def _size(self, axis: np.ndarray) -> float:
        """Return the distance of the farthest position of the tool from the axis [m]."""
        rng = np.random.default_rng(0)
        draws = self._middle + self._half * rng.uniform(-1.0, 1.0, (_SAMPLES, len(self._middle)))
        return max(float(np.linalg.norm(self._model.pose(q).translation[:2] - axis)) for q in draws)

    def _front(self, axis: np.ndarray, size: float) -> tuple[float, np.ndarray]:
        """Return the front of the arm, and a configuration there."""
        best, front, nearest = self._middle, 0.0, np.inf
        for azimuth in _AZIMUTHS:
            radial = 0.5 * size * np.array([np.cos(azimuth), np.sin(azimuth)])
            q = self.solve(np.array([*(axis + radial), 0.2 * size]), self._middle)
            if q is not None and abs(q[0] - self._middle[0]) < nearest - _AHEAD:
                best, front, nearest = q, float(azimuth), abs(q[0] - self._middle[0])
        return front, best

    def solve(self, position: np.ndarray, q0: np.ndarray, floor: float = 0.0) -> np.ndarray | None:
        """Return a configuration with the tool at a position, or None.

        Args:
            position: Of the tool [m].  # (3,)
            q0: The first initial guess.  # (nq,)
            floor: Height above which all joints have to be [m]; those above 0 are preferred.
        """  # (nq,)
        problem = _down(self._ik, position)
        result = self._ik.solve(problem, q0, restarts=0)
        if result.solved and self._lowest(result.q) > -_ROUNDING and self._is_free(result.q):
            return np.array(result.q)
        free = (r.q for r in self._ik.solutions(problem, q0, restarts=_FEW) if self._is_free(r.q))
        best = max(free, key=lambda q: min(self._lowest(q), 0.0), default=None)
        if best is None or self._lowest(best) < floor - _ROUNDING:
            return None
        return np.array(best)

    def _lowest(self, q: np.ndarray) -> float:
        """Return the height of the lowest joint [m]."""
        model = self._model
        pin.forwardKinematics(model.model, model.data, q)
        return float(min(T.translation[2] for T in list(model.data.oMi)[1:]))

    def blocking(self, most: int) -> list[tuple[str, str]]:
        """Return the pairs of bodies that collided in most configurations, at most so many."""
        return [pair for pair, _ in self._colliding.most_common(most)]

    def _is_free(self, q: np.ndarray, within: float = 0.0) -> bool:
        collisions = self._world.collisions(q, within)
        self._colliding.update((one.first, one.second) for one in collisions)
        return not collisions


def _down(ik: InverseKinematics, position: np.ndarray) -> IKProblem:
    """Return the problem of a tool at a position [m] that points down, with any yaw."""
    target = PoseTarget(ik.tool, spatial.pointing_down(position), free_axis="z")
    return IKProblem(targets=[target])

"""Reach of a robot whose tool points down."""

from collections import Counter
from typing import NamedTuple

import mujoco
import numpy as np

from bt_manip import spatial
from bt_manip.cell.objects import geom_box
from bt_manip.collision import CollisionWorld, moved_bodies
from bt_manip.kinematics import IKProblem, InverseKinematics, PoseTarget, manipulability
from bt_manip.robots import Robot, RobotModel

GRASP_HEIGHT = 0.04
"""Height of the tool over the table at a grasp in the pick and place task [m]."""

_SAMPLES = 500  # random configurations to estimate the size of the arm
_AZIMUTHS = np.arange(8) * np.pi / 4  # [rad] candidate directions of the arm's front
_AHEAD = 0.5  # [rad] margin by which the first hinge must be nearer to its mid-range
_RADII = np.linspace(0.05, 1.0, 20)  # relative to the size of the arm
_HEIGHTS = np.linspace(-0.5, 0.8, 14)  # relative to the size of the arm
_FEW, _MANY = 20, 60  # initial guesses of a search, besides the last solution or the middle
_ROUNDING = 1e-3  # [m] tolerance of heights
_SELF_CLEARANCE = 5e-3  # [m] self-clearance at home
_VERTICAL = 0.999  # least cosine between a vertical hinge axis and the vertical


class RadialReach(NamedTuple):
    """Reach of a tool that points down, measured in a vertical plane in front of the arm.

    It is assumed to be equal in all directions about the vertical through `axis`.

    Attributes:
        axis: Position of the first vertical hinge in the base [m].  # (2,)
        front: Azimuth of the arm at the mid-range of that hinge [rad].
        radii: Distances from the axis [m].  # (n,)
        heights: Heights above the origin of the base [m].  # (m,)
        lowest: Height of the lowest point of all links but the last at each position [m]; -inf if
            it is not reached without self-collision.  # (m, n)
        below_tool: Height of the tool above the lowest point of last link and gripper [m].
    """

    axis: np.ndarray
    front: float
    radii: np.ndarray
    heights: np.ndarray
    lowest: np.ndarray
    below_tool: float = 0.0

    def reached(self, floor: float) -> np.ndarray:
        """Return whether each position is reached with the whole arm above a height [m]."""
        low = np.minimum(self.lowest, (self.heights - self.below_tool)[:, np.newaxis])
        return np.array(low > floor - _ROUNDING)  # (m, n)

    def covers(self, radius: np.ndarray, height: np.ndarray, floor: float) -> np.ndarray:
        """Return whether positions are reached with gripper and links above a height.

        Args:
            radius: Distances from the axis [m].  # (k,)
            height: Heights above the origin of the base [m].  # (k,)
            floor: The height [m]; for the links it is checked at adjacent measured positions.
        """  # (k,)
        reached = self.lowest > floor - _ROUNDING
        inside = np.array(height - self.below_tool > floor - _ROUNDING)
        cells = []
        for values, grid in ((radius, self.radii), (height, self.heights)):
            inside &= (values >= grid[0]) & (values <= grid[-1])
            cells.append(np.clip(np.searchsorted(grid, values) - 1, 0, len(grid) - 2))
        column, row = cells
        for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
            inside &= reached[row + i, column + j]
        return inside


class LowestPoint:
    """Measures the lowest points of a robot with its gripper open; its foot does not count."""

    def __init__(self, robot: Robot) -> None:
        self._robot, self._model = robot, robot.mj_model
        model = self._model
        self._data = mujoco.MjData(model)
        if robot.gripper is not None:
            robot.gripper.set_opening(self._data.qpos)
        collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
        carried = moved_bodies(model, robot.dof_adr[-1:])
        links = moved_bodies(model, robot.dof_adr) & ~carried & ~foot_bodies(robot)
        self._carried, self._links = (
            np.flatnonzero(collides & bodies[model.geom_bodyid]) for bodies in (carried, links)
        )

    def of_links(self, q: np.ndarray) -> float:
        """Return the height of the lowest point of all links but the last [m]."""
        self._place(q)
        joints = self._data.xanchor[self._model.dof_jntid[self._robot.dof_adr], 2]
        return min(float(joints.min()), self._lowest(self._links))

    def below_tool(self, q: np.ndarray) -> float:
        """Return the height of the tool above the lowest point of last link and gripper [m]."""
        self._place(q)
        tool = float(self._data.site_xpos[self._robot.tool_site_id, 2])
        return tool - min(tool, self._lowest(self._carried))

    def _place(self, q: np.ndarray) -> None:
        self._data.qpos[self._robot.qpos_adr] = q
        mujoco.mj_kinematics(self._model, self._data)

    def _lowest(self, geoms: np.ndarray) -> float:
        boxes = (geom_box(self._model, self._data, int(geom)) for geom in geoms)
        return min((float(lower[2]) for lower, _ in boxes), default=np.inf)


def foot_bodies(robot: Robot) -> np.ndarray:
    """Return a mask of the bodies of constant height: fixed, or turning about the vertical only."""
    # (nbody,)
    model = robot.mj_model
    turning = model.jnt_type == int(mujoco.mjtJoint.mjJNT_HINGE)
    turning &= np.abs(robot.mj_data.xaxis[:, 2]) > _VERTICAL
    return ~moved_bodies(model, np.flatnonzero(~turning[model.dof_jntid]))


class DownwardReach:
    """Finds configurations without self-collision in which the tool points down."""

    def __init__(self, robot: Robot, model: RobotModel) -> None:
        self._robot, self._model = robot, model
        self._ik = InverseKinematics(model)
        self._world = CollisionWorld(robot, model)
        self._world.refresh(fixed_only=True)  # with the gripper open
        self.lowest = LowestPoint(robot)
        lower, upper = model.limits.sampling_bounds()
        self._colliding: Counter[tuple[str, str]] = Counter()
        self._middle, self._half = 0.5 * (lower + upper), 0.5 * (upper - lower)

    def configuration(self, position: np.ndarray, floor: float) -> np.ndarray | None:
        """Return a configuration far from limits and singularities; None if there is none.

        The tool is at the position, and the whole arm above the floor [m].
        """
        best, least = None, np.inf
        for result in self._ik.solutions(
            downward_problem(self._ik, position), self._middle, restarts=_MANY
        ):
            q = np.array(result.q)
            if self._is_above(q, floor) and self._is_free(q, _SELF_CLEARANCE):
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
        front, q = self.front(axis, size)
        direction = np.array([np.cos(front), np.sin(front)])
        lowest, below = np.full((len(_HEIGHTS), len(_RADII)), -np.inf), 0.0
        for i, height in enumerate(size * _HEIGHTS):
            for j, radius in enumerate(size * _RADII):
                position = np.array([*(axis + radius * direction), height])
                found = self.solve(position, q, floor=-np.inf)
                if found is not None:
                    lowest[i, j], q = self.lowest.of_links(found), found
                    below = self.lowest.below_tool(found)
        return RadialReach(axis, front, size * _RADII, size * _HEIGHTS, lowest, below)

    def _axis(self) -> np.ndarray:
        model, data = self._robot.mj_model, self._robot.mj_data
        joints = model.dof_jntid[self._robot.dof_adr]
        vertical = np.abs(data.xaxis[joints, 2]) > 0.99
        hinges = vertical & (model.jnt_type[joints] == int(mujoco.mjtJoint.mjJNT_HINGE))
        return np.array(data.xanchor[joints[int(np.argmax(hinges))], :2])

    def _size(self, axis: np.ndarray) -> float:
        """Return the largest distance of the tool from the axis [m]."""
        rng = np.random.default_rng(0)
        draws = self._middle + self._half * rng.uniform(-1.0, 1.0, (_SAMPLES, len(self._middle)))
        return max(float(np.linalg.norm(self._model.pose(q).translation[:2] - axis)) for q in draws)

    def front(self, axis: np.ndarray, size: float) -> tuple[float, np.ndarray]:
        """Return the azimuth of the front of the arm [rad], and a configuration there [rad].

        The tool is at half of its largest distance, ``size``, from the first vertical hinge [m].
        """
        best, front, nearest = self._middle, 0.0, np.inf
        for azimuth in _AZIMUTHS:
            radial = 0.5 * size * np.array([np.cos(azimuth), np.sin(azimuth)])
            q = self.solve(np.array([*(axis + radial), 0.2 * size]), self._middle)
            if q is not None and abs(q[0] - self._middle[0]) < nearest - _AHEAD:
                best, front, nearest = q, float(azimuth), abs(q[0] - self._middle[0])
        return front, best

    def solve(self, position: np.ndarray, q0: np.ndarray, floor: float = 0.0) -> np.ndarray | None:
        """Return a configuration with the tool at a position; None if there is none.

        Args:
            position: Position of the tool [m].  # (3,)
            q0: The first initial guess [rad].  # (nq,)
            floor: Height above which all links but the last must be [m]; heights above 0 are
                preferred.
        """  # (nq,)
        problem, height = downward_problem(self._ik, position), self.lowest.of_links
        result = self._ik.solve(problem, q0, restarts=0)
        if result.solved and height(result.q) > -_ROUNDING and self._is_free(result.q):
            return np.array(result.q)
        free = (r.q for r in self._ik.solutions(problem, q0, restarts=_FEW) if self._is_free(r.q))
        best = max(free, key=lambda q: min(height(q), 0.0), default=None)
        if best is None or height(best) < floor - _ROUNDING:
            return None
        return np.array(best)

    def _is_above(self, q: np.ndarray, floor: float) -> bool:
        height = float(self._model.pose(q).translation[2]) - self.lowest.below_tool(q)
        return min(height, self.lowest.of_links(q)) > floor - _ROUNDING

    def blocking(self) -> list[tuple[str, str]]:
        """Return the three pairs of bodies that collided most often."""
        return [pair for pair, _ in self._colliding.most_common(3)]

    def _is_free(self, q: np.ndarray, within: float = 0.0) -> bool:
        collisions = self._world.collisions(q, within)
        self._colliding.update((one.first, one.second) for one in collisions)
        return not collisions


def downward_problem(ik: InverseKinematics, position: np.ndarray) -> IKProblem:
    """Return the IK problem of a tool that points down at a position [m], with any yaw."""
    target = PoseTarget(ik.tool, spatial.pointing_down(position), free_axis="z")
    return IKProblem(targets=[target])

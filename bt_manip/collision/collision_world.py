"""The arm among everything in its world."""

from typing import NamedTuple

import mujoco
import numpy as np

from bt_manip.cell import BodyNames
from bt_manip.robots import Robot, RobotModel

from .arm_motion import part_of_body
from .collision_model import CollisionModel
from .conservative_advancement import ConservativeAdvancement
from .geom_pairs import comparable
from .inter_robot_distance import INTER_ROBOT_CLEARANCE
from .neighbours import never_touching
from .other_robot import OtherRobot
from .robot_geometry import RobotGeometry

PADDING = 8e-3  # [m] how far away contacts are seen


class CollisionPair(NamedTuple):
    """Two bodies that are near each other, or touch."""

    first: str  # entity/body
    second: str
    distance: float  # [m], negative inside each other


class CollisionWorld:
    """Tells what the arm would be near to, with its gripper and what it holds.

    MuJoCo's own collision detection answers, in a `CollisionModel`. Everything that the arm
    does not move stands where it stood at the last `refresh`.

    What all fingers touch is held: it goes with the tool, and fingers may touch it.

    Attributes:
        joints: Full names of the arm's joints.
        counts: Pairs of geoms that shall not touch.  # (ngeom, ngeom)
        own: Pairs of geoms of the robot.  # (ngeom, ngeom)
        others: Other robots: they stand where they will come to rest, and are taken for thicker
            than they are by what robots keep from each other.
    """

    def __init__(self, robot: Robot, model: RobotModel) -> None:
        """Look at the world that a robot is compiled into.

        Args:
            robot: The robot; what it is compiled into later is found by `refresh`.
            model: Its model, for where the tool is.
        """
        self._robot = robot
        self.joints = tuple(model.model.names)[1:]
        self._figure = RobotGeometry(robot, model)
        self._watched: np.ndarray | None = None
        self._source: mujoco.MjModel | None = None
        self.other_robots: tuple[OtherRobot, ...] = ()
        self.refresh()

    def refresh(self) -> None:
        """Take over where everything is now, and what is held."""
        robot, figure = self._robot, self._figure
        figure.refresh()
        if robot.mj_model is not self._source:
            self._source = robot.mj_model
            adr = np.array(robot.qpos_adr)
            self._near = CollisionModel(self._source, PADDING, adr)
            self._joints = self._source.dof_jntid[np.array(robot.dof_adr)]
            self._parts = part_of_body(self._source, self._joints)
            self._may_touch = self._pairs_that_may_touch(self._source)
            self._proof = ConservativeAdvancement(self._source, self._near, self._joints)
            self._labels = BodyNames(self._source)
        if figure.bodies is not self._watched:
            self._watched = figure.bodies
            self._watch()
        self._near.take(robot.mj_data)
        if self.other_robots:
            self._place_others()
        self._proof.take()

    def _place_others(self) -> None:
        """Let the other robots be where they will come to rest, with room around them."""
        bodies = np.zeros(self._near.model.nbody, dtype=bool)
        for other in self.other_robots:
            other.figure.refresh()
            other.figure.spread(self._near.data.qpos)
            other.figure.put(self._near.data.qpos, other.arm.target)
            bodies |= other.figure.bodies
        self._near.widen(bodies, INTER_ROBOT_CLEARANCE)

    def other_robot(self, body: str) -> str:
        """Name the other robot whose arm moves a body, or holds it; empty where none does."""
        label = self._labels.of_body
        for other in self.other_robots:
            if any(label[i] == body for i in np.flatnonzero(other.figure.bodies)):
                return other.name
        return ""

    @property
    def held(self) -> str | None:
        """Name of the object that was held at the last `refresh`; None where there was none."""
        return self._figure.held or None

    def _watch(self) -> None:
        """Look at what moves, and at what of it may touch."""
        model, figure = self._source, self._figure
        assert model is not None
        of_geom = model.geom_bodyid
        fingers = np.isin(of_geom, self._robot.finger_body_ids)
        moving, own = figure.bodies[of_geom], figure.arm[of_geom]
        self._moving, carried = moving, moving & ~own
        # Fingers that have closed on nothing touch each other, however the arm moves.
        gripping = fingers | carried
        allowed = gripping[:, np.newaxis] & gripping
        self.counts = (moving[:, np.newaxis] | moving) & ~allowed & self._may_touch
        self.own = own[:, np.newaxis] & own
        part = self._part_of_geom()
        if part is not None:
            self.counts &= (part != part[:, np.newaxis]) | ~(moving[:, np.newaxis] & moving)
        self._near.watch(self.counts, figure.held_root)
        self._proof.watch(self.counts, part)

    def _pairs_that_may_touch(self, model: mujoco.MjModel) -> np.ndarray:
        """Mark the pairs of geoms that MuJoCo compares, but for neighbours that never touch."""
        pairs = comparable(model)  # (ngeom, ngeom)
        if self._parts is None:
            return pairs
        return pairs & ~never_touching(model, self._joints, self._parts[model.geom_bodyid], pairs)

    def _part_of_geom(self) -> np.ndarray | None:
        """Number the geoms by how many of the arm's joints move them."""  # (ngeom,)
        model, held = self._source, self._figure.held_root
        if model is None or self._parts is None:
            return None
        last = (model.body_rootid == held) & (held > 0)
        return np.where(last, len(self._joints), self._parts)[model.geom_bodyid]

    def look(self, q: np.ndarray) -> int:
        """Put the arm at a configuration and find what is near.

        Returns:
            How many contacts were seen; `seen` has them.
        """
        return self._near.look(q, self._figure.carried(q))

    @property
    def seen(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Geoms on both sides of each contact last seen, and their distance [m]."""
        return self._near.seen

    def proven(self, path: np.ndarray, needed: np.ndarray) -> np.ndarray:
        """Tell which configurations of a path keep their distances, without a look at all of them.

        Args:
            path: Configurations [rad].  # (n, nq)
            needed: Distance of each pair of geoms that is asked for [m], -inf where none.
                # (ngeom, ngeom)

        Returns:
            Where this is False, nothing is known.  # (n,)
        """
        return self._proof.proven(path, needed, self._figure.carried)

    def collisions(self, q: np.ndarray, within: float = 0.0) -> list[CollisionPair]:
        """Name what the arm would touch at a configuration, or be near to; the nearest first.

        Args:
            q: Positions of the arm's joints [rad].  # (nq,)
            within: Distance up to which bodies are near [m], up to `PADDING`.
        """
        found: dict[tuple[str, str], float] = {}
        if self.look(q):
            for first, second, distance in zip(*(x.tolist() for x in self.seen), strict=True):
                if self.counts[first, second] and distance < within:
                    pair = self.names(first, second)
                    found[pair] = min(distance, found.get(pair, distance))
        return sorted(
            (CollisionPair(*pair, d) for pair, d in found.items()), key=lambda near: near.distance
        )

    def describe_contacts(self) -> str:
        """Say what the arm touches in the physics, that it should not; empty when nothing."""
        self.refresh()
        contact = self._robot.mj_data.contact
        pressing = contact.geom[contact.efc_address >= 0].tolist()
        pairs = sorted({self.names(a, b) for a, b in pressing if self.counts[a, b]})
        return " and ".join(f"'{first}' touches '{second}'" for first, second in pairs)

    def names(self, first: int, second: int) -> tuple[str, str]:
        """Name the bodies of two geoms, that which the arm moves first."""
        label = self._labels.of_geom
        if not self._moving[first]:
            first, second = second, first
        return label[first], label[second]

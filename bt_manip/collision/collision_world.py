"""Collision checking of an arm in its cell."""

from typing import NamedTuple

import mujoco
import numpy as np

from bt_manip.cell import BodyNames
from bt_manip.robots import Robot, RobotModel, check_number

from .adjacent_links import never_colliding_pairs
from .collision_model import CollisionModel, GeomContacts, collidable_pairs
from .conservative_advancement import ConservativeAdvancement
from .inter_robot_distance import INTER_ROBOT_CLEARANCE
from .motion_bounds import link_of_body
from .robot_geometry import OtherRobot, RobotGeometry

PADDING = 8e-3  # [m] distance up to which contacts are detected
FAR = 1e3  # [m] displacement of ignored objects


class CollisionPair(NamedTuple):
    """Two bodies that touch or are near each other."""

    first: str  # entity/body
    second: str
    distance: float  # [m], negative in penetration


class CollisionWorld:
    """Checks configurations of an arm, its gripper and its held object for collisions.

    MuJoCo detects the contacts in a scratch copy of the compiled model. Bodies that the arm does
    not move are at their poses of the last `refresh`. The held object moves with the tool and may
    touch the gripper.

    Args:
        model: The robot's kinematic model.

    Attributes:
        robot: The robot.
        joints: Full names of the arm's joints.
        checked_pairs: Mask of the geom pairs that must not touch.  # (ngeom, ngeom)
        self_pairs: Mask of the geom pairs within the arm.  # (ngeom, ngeom)
        other_robots: Obstacles at their final configurations, inflated by the clearance between
            robots.
    """

    def __init__(self, robot: Robot, model: RobotModel) -> None:
        self.robot = robot
        self.joints = tuple(model.model.names)[1:]
        self._geometry = RobotGeometry(robot, model)
        self._bodies: np.ndarray | None = None
        self._source: mujoco.MjModel | None = None
        self.other_robots: tuple[OtherRobot, ...] = ()
        self.refresh()

    def refresh(self, *, fixed_only: bool = False) -> None:
        """Update the compiled model, the state of the cell and the held object.

        Args:
            fixed_only: Whether to use a state that does not depend on the present one: without free
                objects, all other joints as compiled, other robots at home, grippers open and
                empty.
        """
        robot, geometry = self.robot, self._geometry
        geometry.refresh(empty=fixed_only)
        if robot.mj_model is not self._source:
            self._source = source = robot.mj_model
            joints = source.dof_jntid[np.array(robot.dof_adr)]
            self._scratch = CollisionModel(source, PADDING)
            self._advancement = ConservativeAdvancement(source, self._scratch, geometry, joints)
            self._links = link_of_body(source, joints)
            self._collidable = collidable_pairs(source)
            if self._links is not None:
                self._collidable &= ~never_colliding_pairs(
                    source, joints, self._links[source.geom_bodyid], self._collidable
                )
            self._labels = BodyNames(source)
        if geometry.bodies is not self._bodies:
            self._bodies = geometry.bodies
            self._select_pairs(robot.mj_model)
        self._scratch.copy_state(robot.mj_data)
        if fixed_only:
            model = robot.mj_model
            free = model.jnt_qposadr[model.jnt_type == mujoco.mjtJoint.mjJNT_FREE]
            self._scratch.data.qpos[:] = model.qpos0
            self._scratch.data.qpos[free + 2] += FAR
            geometry.write_open_gripper(self._scratch.data.qpos)
        if self.other_robots:
            self._place_other_robots(at_home=fixed_only)
        self._advancement.refresh()

    def collisions(self, q: np.ndarray, within: float = 0.0) -> list[CollisionPair]:
        """Return the pairs of bodies in collision at a configuration, the deepest first.

        Args:
            q: Configuration of the arm [rad].  # (nq,)
            within: Distance up to which pairs are returned [m], at most `PADDING`.

        Raises:
            MotionError: If `within` is larger than `PADDING`.
        """
        check_number(within, "within", "m", at_most=PADDING)
        found: dict[tuple[str, str], float] = {}
        if self.collide(q):
            for first, second, distance in zip(*(x.tolist() for x in self.contacts), strict=True):
                if self.checked_pairs[first, second] and distance < within:
                    pair = self._body_names(first, second)
                    found[pair] = min(distance, found.get(pair, distance))
        pairs = (CollisionPair(*pair, distance) for pair, distance in found.items())
        return sorted(pairs, key=lambda pair: pair.distance)

    def collide(self, q: np.ndarray) -> int:
        """Detect contacts at a configuration and return their number.

        Args:
            q: Configuration of the arm [rad].  # (nq,)
        """
        self._geometry.write(self._scratch.data.qpos, q)
        return self._scratch.collide()

    @property
    def contacts(self) -> GeomContacts:
        """The contacts of the last `collide`."""
        return self._scratch.contacts

    def known_free(self, path: np.ndarray, clearance: np.ndarray) -> np.ndarray:
        """Return which configurations of a path are certainly free, see `ConservativeAdvancement`.

        Args:
            path: Configurations [rad].  # (n, nq)
            clearance: Required distance of each pair of geoms [m].  # (ngeom, ngeom)
        """  # (n,) bool
        return self._advancement.known_free(path, clearance)

    def present_contacts(self) -> list[tuple[str, str]]:
        """Return unexpected contacts of the arm and the held object."""
        self.refresh()
        contact = self.robot.mj_data.contact
        pressing = contact.geom[contact.efc_address >= 0].tolist()
        return sorted({self._body_names(a, b) for a, b in pressing if self.checked_pairs[a, b]})

    @property
    def held(self) -> str | None:
        """Name of the object held at the last `refresh`, or None."""
        return self._geometry.held or None

    def other_robot(self, body: str) -> str:
        """Return the name of the other robot that moves or holds a body; empty without one."""
        label = self._labels.of_body
        for other in self.other_robots:
            if any(label[i] == body for i in np.flatnonzero(other.geometry.bodies)):
                return other.name
        return ""

    def _place_other_robots(self, *, at_home: bool) -> None:
        """Place and inflate the other robots at their final configurations, or at home."""
        bodies = np.zeros(self._scratch.model.nbody, dtype=bool)
        for other in self.other_robots:
            other.geometry.refresh(empty=at_home)
            other.geometry.write_open_gripper(self._scratch.data.qpos)
            home = np.array(other.geometry.robot.description.home)
            other.geometry.write(self._scratch.data.qpos, home if at_home else other.arm.target)
            bodies |= other.geometry.bodies
        self._scratch.inflate(bodies, INTER_ROBOT_CLEARANCE)

    def _select_pairs(self, model: mujoco.MjModel) -> None:
        geometry, of_geom = self._geometry, model.geom_bodyid
        moving, own = geometry.bodies[of_geom], geometry.arm[of_geom]
        self._moving = moving
        # The gripper may touch the held object, and itself after closing on nothing.
        gripping = geometry.gripping[of_geom]
        allowed = gripping[:, np.newaxis] & gripping
        self.checked_pairs = (moving[:, np.newaxis] | moving) & ~allowed & self._collidable
        self.self_pairs = own[:, np.newaxis] & own
        link = None
        if self._links is not None:
            held = (model.body_rootid == geometry.held_root) & (geometry.held_root > 0)
            link = np.where(held, len(self.joints), self._links)[of_geom]
            same_link = (link == link[:, np.newaxis]) & moving[:, np.newaxis] & moving
            self.checked_pairs &= ~same_link
        self._scratch.restrict_to(self.checked_pairs)
        self._advancement.select(self.checked_pairs, link)

    def _body_names(self, first: int, second: int) -> tuple[str, str]:
        """Return the names of two geoms' bodies, the arm's body first."""
        label = self._labels.of_geom
        if not self._moving[first]:
            first, second = second, first
        return label[first], label[second]

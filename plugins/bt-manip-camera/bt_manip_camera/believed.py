"""A believed cell beside the physics: measured joints, and objects as a source reports them."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple, cast

import numpy as np
import pinocchio as pin
from dm_control import composer, mjcf

from bt_manip.cell import Cell, CellError, as_object
from bt_manip.control import MeasuredArm
from bt_manip.registry import Parts
from bt_manip.robots import Gripper, GripperState, Robot
from bt_manip.runner import Believed, CommandedRobot, FilledCell, Hardware, RobotBuilder, make_robot
from bt_manip.scenes import ExpectedObjects, Scene, SceneObject, SceneRobot

from .camera import depth_cameras
from .perception import Perception
from .renderer import check_opengl

PATIENCE = 1.0
"""Simulated time for which a tree waits until an object is seen that it has added [s]."""


class _Reading(NamedTuple):
    """Measured positions [rad], velocities [rad/s] and torques [N m] after a control step."""

    q: np.ndarray
    v: np.ndarray
    tau: np.ndarray
    tau_external: None = None


class _MeasuredJoints:
    """What is measured of a simulated arm, in place of an `ArmConnection`."""

    def __init__(self, robot: Robot) -> None:
        self._robot, self._taken = robot, deque[_Reading]()

    @property
    def latest(self) -> _Reading:
        return _Reading(self._robot.q, self._robot.v, self._robot.tau)

    def note(self) -> None:
        """Keep the reading of a control step."""
        self._taken.append(self.latest)

    def take(self) -> _Reading:
        """Return the reading of the next control step."""
        return self._taken.popleft()

    def read_by(self, robot: Robot) -> None:
        """Let another robot have these sensors; those of the simulated one change with compiles."""
        measured = self._robot
        robot.read_q, robot.read_v = lambda: measured.read_q(), lambda: measured.read_v()
        robot.read_a, robot.read_tau = lambda: measured.read_a(), lambda: measured.read_tau()
        robot.read_tau_external = None


class _MeasuredFingers:
    """The width and the flag of a simulated gripper, in place of a `GripperConnection`."""

    problem = ""
    restorable = True

    def __init__(self, gripper: Gripper) -> None:
        self._gripper: Any = gripper

    @property
    def state(self) -> GripperState:
        gripper = self._gripper
        return GripperState(gripper.width, gripper.gripping and not gripper.closed_on_nothing)

    @property
    def busy(self) -> bool:
        return bool(self._gripper.moving)

    def command(self, kind: str, width: float, speed: float, force: float = 0.0) -> None:
        """Close with a force [N], or open."""
        if kind == "grasp":
            self._gripper.close(force)
        else:
            self._gripper.open()

    def update(self) -> None:
        """Do nothing: it is read when asked."""


class _BelievedArm(MeasuredArm):
    """The arm of the believed cell, at the measured positions of the simulated one."""

    kind = "believed_arm"

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        super().after_compile(physics, random_state)
        cast(_MeasuredJoints, self._connection).read_by(self.robot)


class _BelievedBuilder(RobotBuilder):
    """Builds the twin of a simulated robot."""

    def __init__(self, chosen: SceneRobot, parts: Parts, physical: CommandedRobot) -> None:
        self._physical, self.joints = physical, _MeasuredJoints(physical.robot)
        super().__init__(chosen, parts)

    def _make_robot(self, parts: Parts) -> Robot:
        return make_robot(self._chosen, parts, lambda kind: partial(self._gripper, parts, kind))

    def _gripper(self, parts: Parts, kind: str, robot: Robot) -> Gripper:
        made: Any = parts.grippers.get(kind)
        assert self._physical.gripper is not None
        return cast(Gripper, made.on_device(_MeasuredFingers(self._physical.gripper))(robot))

    def _controller_factories(self, parts: Parts) -> dict[str, Any]:
        return {str(self._chosen.controller): partial(_BelievedArm, connection=self.joints)}


class SeenObjects(ExpectedObjects):
    """The objects that are there once they were seen: of the scene, and those that the tree adds.

    Args:
        source: The `SeenPoses`.
        cell: The cell of the tree.
        models: Makes the objects.
        physics: The cell of the physics.
    """

    def __init__(self, source: Any, cell: Cell, models: Any, physics: Cell) -> None:
        super().__init__(source, cell, models)
        self.physics: Cell = physics
        self._models, self._scene = models, source.expected
        self._spawned: dict[str, list[Any]] = {}

    def spawned(self, name: str) -> None:
        """Expect an object that the tree has added to the physics; its pose is not known."""
        entity = self.physics.find(name)
        one = as_object(entity)
        height = float(self.physics.pose(name).translation[2])
        self._spawned[name] = [one.kind, dict(one.parameters), height]
        self._expect()

    def taken(self, name: str) -> None:
        """Forget an object; remove it from the physics if the tree has added it."""
        self.source.taken(name)
        if self._spawned.pop(name, None) is not None:
            self._expect()
            if name in self.physics.entities:
                self.physics.remove(name)

    def _expect(self) -> None:
        self.source.expected = (*self._scene, *(
            SceneObject(kind, name, pin.SE3(np.eye(3), np.array([0.0, 0.0, height])), given, True)
            for name, (kind, given, height) in self._spawned.items()
        ))  # fmt: skip

    def get_state(self) -> Any:
        """Return the names of the used objects, and those that the tree has added."""
        return [super().get_state(), dict(self._spawned)]

    def set_state(self, state: Any) -> None:
        """Restore what `get_state` returned."""
        used, self._spawned = state[0], dict(state[1])
        super().set_state(used)
        self._expect()


class BelievedCell(Believed):
    """What the tree knows and plans with, while the physics decides and judges.

    It is a second cell of the same scene. In each control step the robots there get the joint
    positions and finger widths that are measured in the physics; the controllers in the physics
    follow the arms here. Expected objects are absent until the source reports them; a held one
    moves with the hand. All other objects are where they are in the physics at the start of a
    cycle.

    Args:
        scene: The scene.
        chosen: Its robots, with all optional names filled in.
        cell: The cell of the physics.
        robots: The robots in the physics, by name.
        source: The `SeenPoses`, which report the expected objects.
        parts: The registered parts.
        catalogue: Makes the objects.
        seed: Seed of sampled poses.

    Raises:
        BtManipError: If a gripper has no twin, the scene has no `DepthCamera`, or no OpenGL backend
            works.

    Attributes:
        cell: The believed cell.
        robots: Its robots with their arms, and the controllers in the physics, by name.
        poses: The expected objects.
    """

    def __init__(
        self, *, scene: Scene, chosen: Sequence[SceneRobot], cell: Cell,
        robots: Mapping[str, CommandedRobot], source: Any, parts: Parts,
        catalogue: Any, seed: int,
    ) -> None:  # fmt: skip
        if not depth_cameras(cell.entities):
            raise CellError("--poses seen needs a scene with a depth_camera")
        check_opengl()
        pairs = zip(chosen, robots.values(), strict=True)
        builders = [_BelievedBuilder(one, parts, real) for one, real in pairs]
        filled = FilledCell(scene, builders, catalogue, seed)
        self.cell, self._physics, self._hardware = filled.cell, cell, Hardware(filled.cell)
        self._joints = [builder.joints for builder in builders]
        self._known = [one.name for one in scene.objects if not one.expected]
        self.robots = {}
        for name, one in filled.robots.items():
            one.controllers.reference = None  # the arm advances with the physics
            robots[name].controllers.reference = one.arm
            self.robots[name] = replace(one, controllers=robots[name].controllers)
        self._source, self._seed, self._robots = source, seed, robots
        self.poses = SeenObjects(source, self.cell, catalogue, cell)
        self._perception = Perception(self.cell, self.poses, self.robots, catalogue)
        self._awaited, self._since = "", 0.0
        source.look = self._look

    def _look(self, name: str, T_wo: pin.SE3) -> None:
        """Look for an object that the tree waits for, with all cameras where they are.

        Args:
            name: Its name.
            T_wo: A pose of its height.

        Raises:
            CellError: If it is not seen within `PATIENCE`.
        """
        now = self._physics.time
        if name != self._awaited:
            self._awaited, self._since = name, now
        surface = float(T_wo.translation[2]) - as_object(self._perception.entity(name)).rest_height
        reasons: list[str] = []
        for label, one in depth_cameras(self._physics.entities).items():
            if one.next_exposure(now) > now + 1e-6:
                continue
            rng = np.random.default_rng((self._seed, round(1e6 * now), len(reasons)))
            seen = self._perception.see(one.expose(rng, self._robots), surface, [name])
            one.detections = seen.detections
            if name in seen.found:
                self._source.report(replace(seen.found[name], camera=label))
                self._awaited = ""
                return
            reasons.append(seen.missing[name])
        if now > self._since + PATIENCE and reasons:
            self._awaited = ""
            raise CellError(
                f"'{name}' was not seen: look first, by WaitUntilSeen ({'; '.join(reasons)})"
            )

    def begin(self) -> None:
        """Put the objects that are not expected where they are in the physics."""
        cell, physics = self.cell, self._physics
        both = [name for name in self._known if name in cell.entities and name in physics.entities]
        moved = [name for name in both if not cell.pose(name).isApprox(physics.pose(name), 1e-9)]
        if moved:
            with cell.editing():
                made = {name: (cell.is_free(name), cell.remove(name)) for name in moved}
                for name, (free, entity) in made.items():
                    cell.add(entity, physics.pose(name), name=name, free=free)

    def measure(self) -> None:
        """Take the measurements of a control step of the physics."""
        for joints in self._joints:
            joints.note()

    def follow(self, steps: int) -> None:
        """Make control steps with the measurements of as many steps of the physics."""
        self._hardware.step(steps)
        self.cell.data.time = self._physics.time
        for robot in self.robots.values():
            if robot.gripper is not None:
                robot.gripper.update()

    def get_state(self) -> dict[str, Any]:
        """Return its state besides those of the arms, as plain data."""
        return {
            "cell": self.cell.snapshot(),
            "poses": self.poses.get_state(),
            "seen": self._source.get_state(),
            "awaited": [self._awaited, self._since],
            "robots": {
                name: (one.gripper and one.gripper.get_state(), one.grasp_planner.get_state())
                for name, one in self.robots.items()
            },
        }

    def set_state(
        self, state: Mapping[str, Any], make: Callable[[Mapping[str, Any]], composer.Entity]
    ) -> None:
        """Restore a state of `get_state`, at the present time of the physics.

        Args:
            state: The state.
            make: Makes an object of its cell's snapshot.
        """
        self.cell.restore(state["cell"], make, time=self._physics.time)
        for name, (gripper, planned) in state["robots"].items():
            one = self.robots[name]
            if one.gripper is not None:
                one.gripper.set_state(gripper)
            one.grasp_planner.set_state(planned)
        self.poses.set_state(state["poses"])
        self._source.set_state(state["seen"])
        self._awaited, self._since = state["awaited"]

"""Adding objects to the cell and removing them."""

import contextlib
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from dm_control import composer

from bt_manip.bt import Input, Output, Status, Traits
from bt_manip.cell import CellError, CellObject, Region, as_object, nearest_free, unique_name
from bt_manip.cell.objects import Catalogue
from bt_manip.exceptions import PortError
from bt_manip.grasping import REFERENCE_AREA
from bt_manip.models import is_address

from .arm_behaviour import CellBehaviour
from .automatic import AUTO, numbers_or_auto
from .object_port import ObjectInput
from .poses import centre_pose, pose_output
from .robot_port import ENTRY

if TYPE_CHECKING:
    from bt_manip.runner import CommandedRobot

CUBE = "cube"  # registered name of the reference task's object
CUBE_SIZE = 0.05  # [m] length of its edges
SLACK = 0.006  # [m] total clearance of an open gripper on both sides of an object
WIDTH_PART = 0.8  # size of a smaller cube relative to the largest width that fits, for any yaw
TOOL_HEIGHT = 0.015  # [m] height of the tool over an object's centre at a grasp
ATTEMPTS = 100  # maximum number of random positions


class SpawnObject(CellBehaviour):
    """Add a new object at a random free position on another one, with a random yaw.

    In runs with a pose source (``--poses``), it waits for the scene's next expected object instead.
    With seen poses and none left to expect, it adds one to the physics, and waits until it is seen.
    """

    drawn = ("pose",)

    traits = Traits()
    model = Input(
        str,
        default=AUTO,
        doc="Registered name of the object (bt-manip list objects), or the address of a model; "
        "auto: the cube, in a size that fits the gripper.",
    )
    on = ObjectInput(str, default="table", doc="Name of its support.")
    region = numbers_or_auto(
        "Region for its centre in the world: x_min;x_max;y_min;y_max [m]; auto: 0.2;0.4;-0.3;0.3, "
        "or if that is out of reach, the part of the surface that the robot reaches from above.",
    )
    gap = Input(float, default=0.0, doc="Smallest distance to other free objects [m].")
    within = Input(
        float, default=np.inf, doc="Largest distance to the nearest other free object [m]."
    )
    name_hint = Input(
        str, default="", doc="Name for it, made unique; by default that of the model."
    )
    robot = Input(
        str,
        default="",
        doc="Name of the robot that can reach it; by default that of the scope's entry 'robot', "
        "or the only one.",
    )
    object = Output(str, doc="Its unique name.")
    pose = pose_output("Pose of its origin in the world, x;y;z;qw;qx;qy;qz [m].")

    memory = (*CellBehaviour.memory, "_awaited")

    _awaited = ""  # name of the awaited object

    def setup(self, **infrastructure: Any) -> None:
        """Store the cell, its random generator and the registered objects.

        Raises:
            UnknownPartError: If the model is already known and not registered.
            ModelError: If there is no model at its address.
        """
        super().setup(**infrastructure)
        self.rng: np.random.Generator = infrastructure["rng"]
        self.models: Catalogue = infrastructure["models"]
        self._robots: Mapping[str, CommandedRobot] = infrastructure.get("robots", {})
        self._made: dict[tuple[Any, ...], composer.Entity] = {}
        with contextlib.suppress(PortError):  # the entry is not written yet
            if is_address(self.model):
                self.models.nominal(self.model)  # its warnings are known before the run
            elif self.model != AUTO:
                self.models.get(self.model)

    @property
    def adds_objects(self) -> list[str]:  # type: ignore[override]
        """Names of the objects that it adds, as patterns."""
        name = "*"
        with contextlib.suppress(PortError):  # the entry is not written yet
            model = CUBE if self.model == AUTO else self.model
            name = self.name_hint or ("*" if is_address(model) else model)
        return [name, f"{name}_*"]

    def start(self) -> None:
        """Create and add the object, or begin to wait for an expected one."""
        self._awaited = ""
        if self.expected is not None:
            try:
                self._awaited = self.expected.next("" if self.model == AUTO else self.model).name
                return
            except CellError:
                if self.expected.physics is None:
                    raise
        given = self._given_region()
        entity, hint = self._make()
        declared = as_object(entity)
        region = given or self._area(declared)
        z = self.physics.surface_height(self.on) + declared.rest_height
        middle_x, middle_y, _ = declared.centre_offset
        region = replace(region, z=(z, z), middle=(middle_x, middle_y))
        name = self._place(entity, region, self.name_hint or hint or None)
        if self.expected is not None:
            self.expected.spawned(name)
            self._awaited = name
            return
        self.object = name
        self._describe(name)
        if region.squares:
            square_metres = len(region.squares) * region.side**2
            self.feedback_message += f", on {square_metres:.2g} m2 that the robot reaches"

    def _describe(self, name: str) -> None:
        self.pose = self.cell.pose(name)
        x, y, _ = centre_pose(self.cell, name).translation
        self.feedback_message = f"'{name}' at ({x:.3f}, {y:.3f}) m"

    def _make(self) -> tuple[composer.Entity, str]:
        """Create the object; return it with its name, which is empty for the model's name."""
        model = self.model
        if model != AUTO:
            return self._object(model), "" if is_address(model) else model
        widest = [
            robot.gripper.max_object_width
            for robot in self._robots.values()
            if robot.gripper is not None
        ]
        fitting = min(widest, default=np.inf) - SLACK
        parameters = {} if fitting >= CUBE_SIZE else {"size": round(WIDTH_PART * fitting, 3)}
        return self._object(CUBE, **parameters), CUBE

    def _area(self, declared: CellObject) -> Region:
        """Return the region in which the robot reaches the object from above."""
        name = self.robot or str(self.scope[ENTRY] if ENTRY in self.scope else "")
        if not name and len(self._robots) == 1:
            name = next(iter(self._robots))
        if name not in self._robots:
            x_min, x_max, y_min, y_max = REFERENCE_AREA
            return Region((x_min, x_max), (y_min, y_max), (0.0, 0.0))
        height = declared.rest_height + float(declared.centre_offset[2]) + TOOL_HEIGHT
        return self._robots[name].reach.area(self.cell, self.on, height)

    def _object(self, model: str, **parameters: Any) -> composer.Entity:
        """Return the removed object that this node added before, or a new one."""
        key = (model, *parameters.items())
        made = self._made.get(key)
        randomized = self.models.sample_parameters is not None
        if made is None or randomized or not self.physics.is_reusable(made):
            made = self._made[key] = self.models.get(model)(**parameters)
        return made

    def _place(self, entity: composer.Entity, region: Region, hint: str | None) -> str:
        """Add it at a random position of the region with the required distances to others.

        Raises:
            CellError: If none of `ATTEMPTS` positions has them.
        """
        gap, within = self.gap, self.within
        limit = gap if np.isinf(within) else max(gap, within)
        for _ in range(ATTEMPTS):
            name = hint and unique_name(hint, self.physics.entities)
            name = self.physics.place(entity, region, self.rng, name=name)
            distance = nearest_free(self.physics, name, limit) if limit > 0.0 else 0.0
            if gap <= distance < within:
                return name
            self.physics.remove(name)
        near = "" if np.isinf(within) else f" and at most {1e3 * within:g} mm from one"
        raise CellError(
            f"no position at least {1e3 * gap:g} mm from other objects{near} in {ATTEMPTS} attempts"
        )

    def _given_region(self) -> Region | None:
        numbers = self.region
        if numbers is None:
            return None
        if len(numbers) != 4 or numbers[0] > numbers[1] or numbers[2] > numbers[3]:
            raise CellError(f"a region is x_min;x_max;y_min;y_max [m], got {numbers}")
        x_min, x_max, y_min, y_max = numbers
        return Region((x_min, x_max), (y_min, y_max), (0.0, 0.0))

    def update(self) -> Status:
        """Succeed once the object is in the cell."""
        if self._awaited and self.expected is not None:
            if not self.expected.add(self._awaited):
                self.feedback_message = f"waiting for '{self._awaited}'"
                return Status.RUNNING
            self.object = name = self._awaited
            self._describe(name)
            self._awaited = ""
        return Status.SUCCESS


class RemoveObject(CellBehaviour):
    """Wait until an object is at rest, then remove it from the cell.

    An object that does not come to rest is removed too, and the behaviour fails.
    """

    object = ObjectInput(str, doc="Name of the object.")
    patience = Input(
        float,
        default=2.0,
        doc="Longest simulated time to wait until it is at rest [s].",
        at_least=0.0,
    )

    def start(self) -> None:
        """Check that the object exists."""
        self.cell.find(self.object)

    def update(self) -> Status:
        """Remove the object once it is at rest, or after the timeout."""
        name = self.object
        status = self.wait_for_rest(name, self.patience, self._started)
        if status is not Status.RUNNING and name in self.cell.entities:
            self.cell.remove(name)
            if self.expected is not None:
                self.expected.taken(name)
            if status is Status.SUCCESS:
                self.feedback_message = f"'{name}' removed"
        return status

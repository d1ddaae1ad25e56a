"""Scenes: the robots and objects at the start of a run."""

import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from functools import cache, wraps
from typing import Annotated, Any, ClassVar

import pinocchio as pin

from bt_manip import spatial
from bt_manip.cell import Region
from bt_manip.cell.randomization import Randomization, parse_variation
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.robots import ArmBounds, Configuration, Configurations, RobotDescription
from bt_manip.toml import (
    Key,
    KeyField,
    OtherKeys,
    Tables,
    TomlTable,
    documented,
    read_part,
)

from .levels import Level
from .scene_keys import (
    BoundsTable,
    CameraPose,
    EntityName,
    LevelsTable,
    ObjectModel,
    ObjectName,
    PartName,
    PlacedPose,
    RandomizationTable,
    RegionTable,
    RobotAddress,
    WithinReach,
    check_object,
)

MAX_ROBOTS = 16
MAX_OBJECTS = 250
"""Largest number of objects, and of cameras, of a scene file; 250 free objects compile in 10 s."""


@documented
@dataclass(frozen=True)
class SceneObject:
    """An object of a scene."""

    model: Annotated[str, Key("The object", values=ObjectModel())]
    name: Annotated[
        str,
        Key(
            "Its name in the cell; by default that of the model", needed=False, values=ObjectName()
        ),
    ]
    T_wo: Annotated[
        pin.SE3,
        Key(
            "Its pose in the world; with `on`, x and y are enough, and z is the height above "
            "its pose at rest on the support",
            "m, rad",
            needed=False,
            values=PlacedPose(),
        ),
    ]
    parameters: Annotated[
        Mapping[str, Any], Key("Parameters of the object", values=OtherKeys("keyword arguments"))
    ] = field(default_factory=dict)
    free: Annotated[
        bool | None,
        Key("Whether it moves freely; None, the default in a file: as the object's class declares"),
    ] = False
    on: Annotated[str, Key("Name of its support: an earlier object")] = ""
    region: Annotated[
        Region | None,
        Key(
            "Region in which a collision-free pose is sampled with the run's seed; replaces the "
            "pose",
            values=RegionTable(),
        ),
    ] = None
    within_reach: Annotated[
        bool | str,
        Key(
            "Whether it is moved within reach of the first robot, and sampled poses out of its "
            "reach are rejected; or the name of the robot",
            values=WithinReach(),
        ),
    ] = False
    expected: Annotated[
        bool,
        Key(
            "Whether it is absent at first; a pose source (`bt-manip run --poses`) reports its "
            "arrival"
        ),
    ] = False


Fixture = SceneObject
"""Former name."""


@documented
@dataclass(frozen=True)
class ObjectTable(SceneObject):
    """An object of a scene file, or several that are alike."""

    count: Annotated[
        int | None,
        Key(
            "Number of such objects, called NAME_1, NAME_2, ...; keys of only one of them are in "
            "a table of its name: `NAME_2.mass = 0.3`",
            at_least=1,
            at_most=MAX_OBJECTS,
        ),
    ] = None

    def scene_object(self, name: str) -> SceneObject:
        """Return one of the objects."""
        given = {field.name: getattr(self, field.name) for field in fields(SceneObject)}
        return SceneObject(**given | {"name": name})


@documented
@dataclass(frozen=True)
class FixedCamera:
    """A camera of a scene file."""

    name: Annotated[str, Key("Its name in the cell", values=EntityName())] = "camera"
    T_wc: Annotated[
        pin.SE3,
        Key(
            "Its pose in the world, or its position and a point to look at",
            "m, rad",
            values=CameraPose(),
        ),
    ] = field(default_factory=pin.SE3.Identity)
    fovy: Annotated[float | None, Key("Vertical angle of view; by default 45", "degrees")] = None
    width: Annotated[int | None, Key("Width of its images; by default 320", "pixels")] = None
    height: Annotated[int | None, Key("Height of its images; by default 240", "pixels")] = None

    def scene_object(self) -> SceneObject:
        """Return the camera as an object; the fields after its pose are the object's parameters."""
        given = {field.name: getattr(self, field.name) for field in fields(self)[2:]}
        parameters = {key: value for key, value in given.items() if value is not None}
        return SceneObject("camera", self.name, self.T_wc, parameters)


_REPLACED = {"position": ("region",), "region": ("position", "quat_wxyz", "rpy")}
"""Keys of several objects that a key of one of them replaces besides its own."""


class ObjectTables:
    """The objects of a scene file, its cameras included."""

    type, names = "tables", "objects, cameras"
    tables: ClassVar[Mapping[str, Any]] = {"[objects]": ObjectTable, "[cameras]": FixedCamera}

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> tuple[SceneObject, ...]:
        """Return the objects in the order in which they are added."""
        found: list[SceneObject] = []
        robots = [part.text("name") or "" for part in table.tables("robots", MAX_ROBOTS)]
        for part in table.tables("objects", MAX_OBJECTS):
            for each, scene_object in self._numbered(part):
                reached_by = scene_object.within_reach
                if isinstance(reached_by, str) and reached_by not in robots:
                    near = did_you_mean(reached_by, robots)
                    text = f"is true or the name of a robot, got '{reached_by}'{near}"
                    each.reject("within_reach", text)
                if scene_object.expected and scene_object.region is not None:
                    each.reject("region", "and 'expected' exclude each other: give a 'position'")
                self._add(found, each, scene_object)
            if len(found) > MAX_OBJECTS:
                text = f"makes {len(found)} objects; a file has at most {MAX_OBJECTS}"
                part.reject("count", text)
                break
        for part in table.tables("cameras", MAX_OBJECTS):
            if camera := read_part(FixedCamera, part):
                scene_object = camera.scene_object()
                self._add(found, part, scene_object)
                check_object(part, scene_object.model, scene_object.parameters, FixedCamera)
        return tuple(found)

    def _numbered(self, table: TomlTable) -> Iterator[tuple[TomlTable, SceneObject]]:
        """Yield the objects of a table, each with the table of its keys."""
        count = min(table.whole_number("count") or 0, MAX_OBJECTS)
        name = table.text("name") or table.text("model")
        names = [f"{name}_{number}" for number in range(1, count + 1)]
        own = {}
        for key in names:
            if part := table.table(key):
                without = [k for given in part.keys() for k in _REPLACED.get(given, ())]
                own[key] = table.variant(key, (*without, *names, "count"), name=key)
        common = read_part(ObjectTable, table, free=None)
        if common is None:
            return
        check_object(table, common.model, common.parameters, ObjectTable)
        for key in names or (common.name,):
            if key not in own:
                yield table, common.scene_object(key)
            elif single := read_part(SceneObject, own[key], free=None):
                check_object(own[key], single.model, single.parameters, SceneObject)
                yield own[key], single

    def _add(self, found: list[SceneObject], table: TomlTable, scene_object: SceneObject) -> None:
        """Add an object; reject keys that conflict with the other objects."""
        names = [known.name for known in found]
        if scene_object.name in names:
            table.reject("name", f"is taken: there is already a '{scene_object.name}'")
        if scene_object.on and scene_object.on not in names:
            near = did_you_mean(scene_object.on, names)
            table.reject(
                "on", f"is the name of an object further up, got '{scene_object.on}'{near}"
            )
        found.append(scene_object)


@documented
@dataclass(frozen=True)
class SceneRobot:
    """A robot of a scene, in its home configuration."""

    T_wb: Annotated[pin.SE3, Key("Pose of its base in the world", "m, rad", needed=False)]
    name: Annotated[
        str,
        Key(
            "Its name in the cell; by default that of its description. Required in scenes with "
            "several robots; a role such as `arm` fits any `--robot`",
            values=EntityName(),
        ),
    ] = ""
    description: Annotated[
        str | RobotDescription | None,
        Key(
            "The robot, in Python also a `RobotDescription`; by default that of the run",
            name="robot",
            values=RobotAddress(),
        ),
    ] = None
    controller: Annotated[
        str | None,
        Key("Its controller; by default that of the run", values=PartName("controllers")),
    ] = None
    planner: Annotated[
        str | None, Key("Its planner; by default that of the run", values=PartName("planners"))
    ] = None
    bounds: Annotated[
        ArmBounds, Key("Bounds of its motions; by default none", values=BoundsTable())
    ] = field(default_factory=ArmBounds)
    tool_speed: Annotated[
        float | None,
        Key(
            "Maximum speed of its tool in every motion; by default that of its description",
            "m/s",
            above=0.0,
        ),
    ] = None
    for_reach: Annotated[
        float | None,
        Key(
            "Reach of the arm for which the position was chosen. For an arm with another reach, "
            "the distance of its first joint from the world's origin is scaled in proportion, and "
            "so that the tool at home stays 0.15 m away from the origin. By default the position "
            "holds for any arm",
            "m",
            above=0.0,
        ),
    ] = None


@documented
@dataclass(frozen=True)
class Scene:
    """The robots and objects at the start of a run.

    Fields that are not keys: `source` is the path of its file, `name` its name in reports.
    """

    robots: Annotated[
        tuple[SceneRobot, ...],
        Key("The robots, at least one", values=Tables("robots", SceneRobot, MAX_ROBOTS)),
    ]
    objects: Annotated[
        tuple[SceneObject, ...],
        Key(
            "The objects, in the order in which they are added",
            name="objects",
            values=ObjectTables(),
        ),
    ] = ()
    randomization: Annotated[
        Randomization, Key("Variations from cycle to cycle", values=RandomizationTable())
    ] = field(default_factory=Randomization)
    levels: Annotated[
        Mapping[str, Mapping[int, Level]],
        Key("Levels of the randomization, by name and number", values=LevelsTable()),
    ] = field(default_factory=dict)
    seed: Annotated[int | None, Key("Seed of runs that give none", at_least=0)] = None
    about: Annotated[str, Key("Description in one sentence")] = ""
    source: str = ""
    configurations: Annotated[
        Mapping[str, Configuration],
        Key(
            "Named configurations of its robots, besides those of their descriptions",
            "rad",
            values=Configurations(),
        ),
    ] = field(default_factory=dict)
    name: str = ""

    def __str__(self) -> str:
        """Return the path of its file, or its name."""
        return self.source or self.name or "built in Python"

    def __post_init__(self) -> None:
        """Check the robots' names.

        Raises:
            BtManipError: If there is no robot, or two have the same name.
        """
        if not self.robots:
            raise BtManipError("a scene needs at least one robot")
        names = [robot.name for robot in self.robots]
        for name in names:
            if len(names) > 1 and not name:
                raise BtManipError("where a scene has several robots, each needs a name")
            if names.count(name) > 1:
                raise BtManipError(f"two robots of the scene are called '{name}'")

    @property
    def T_wb(self) -> pin.SE3:
        """Pose of the first robot's base in the world."""
        return self.robots[0].T_wb

    @property
    def fixtures(self) -> tuple[SceneObject, ...]:
        """Former name of `objects`."""
        warnings.warn("Scene.fixtures is now Scene.objects", DeprecationWarning, stacklevel=2)
        return self.objects


_initialize: Callable[..., None] = Scene.__init__


@wraps(_initialize)
def _accept_fixtures(scene: Scene, *args: Any, **kwargs: Any) -> None:
    if "fixtures" in kwargs:  # former name
        text = "the argument 'fixtures' of Scene is now 'objects'"
        warnings.warn(text, DeprecationWarning, stacklevel=2)
        kwargs["objects"] = kwargs.pop("fixtures")
    _initialize(scene, *args, **kwargs)


Scene.__init__ = _accept_fixtures  # type: ignore[method-assign, assignment]


def _cube(**varied: Any) -> Level:
    parsed = {quantity: parse_variation(data) for quantity, data in varied.items()}
    return Level(Randomization(objects={"cube": parsed}))


@cache
def table_and_basket() -> Scene:
    """Return the scene of the pick-and-place task: a robot on a table, and a basket beside it.

    Dimensions of gym-gz's Panda pick and place, but the base is on the table's surface, not 15 mm
    inside it. The basket is moved within reach of the robot.
    """
    surface = 1.015  # [m] above the floor
    quarter_turn = (0.5**0.5, 0.0, 0.0, 0.5**0.5)
    return Scene(
        robots=(SceneRobot(spatial.pose((-0.1, 0.0, surface))),),
        objects=(
            SceneObject("table", "table", spatial.pose((0.0, 0.0, 0.0))),
            SceneObject(
                "basket",
                "basket",
                spatial.pose((0.68, 0.0, surface), quarter_turn),
                within_reach=True,
            ),
        ),
        levels={
            "pose": {1: Level(), 2: Level(settings={"region": "0.2;0.5;-0.4;0.4"})},
            "size": {
                1: _cube(size={"uniform": [0.045, 0.055]}),
                2: _cube(size={"uniform": [0.03, 0.06]}),
            },
            "colour": {1: _cube(colour={"uniform": [0.1, 0.9]})},
        },
        name="table_and_basket",
    )


@cache
def two_arms() -> Scene:
    """Return the scene of two robots that face each other on a table, each with a basket."""
    surface = 1.015  # [m] above the floor
    half_turn = (0.0, 0.0, 0.0, 1.0)
    return Scene(
        robots=(
            SceneRobot(spatial.pose((-0.55, 0.0, surface)), "left"),
            SceneRobot(spatial.pose((0.55, 0.0, surface), half_turn), "right"),
        ),
        objects=(
            SceneObject("table", "table", spatial.pose((0.0, 0.0, 0.0))),
            SceneObject("basket", "left_basket", spatial.pose((-0.3, 0.3, surface))),
            SceneObject("basket", "right_basket", spatial.pose((0.3, -0.3, surface), half_turn)),
        ),
        name="two_arms",
    )

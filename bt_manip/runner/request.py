"""The request of a run."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from bt_manip.bt import ReadingOptions
from bt_manip.exceptions import BtManipError
from bt_manip.registry import Parts, TreeDefaults
from bt_manip.robots import Configuration, RobotDescription
from bt_manip.scenes import PHYSICS, Scene
from bt_manip.trajectories import CONTROL_STEP

from .real_robot import find_backend
from .tree_source import TreeSource, find_tree
from .xml_tree import READING

CONTROLLER = "computed_torque"
"""Default controller."""

SCENE = "table_and_basket"
"""Default scene."""

PLANNER = "rrt_connect"
"""Default planner."""

REAL_SPEED = 0.1
"""Default factor of all speed scales on a real robot."""

TICK = 0.010
"""Default time between two ticks of a tree [s]."""

EPISODE_TIMEOUT = 120.0
"""Default simulated time after which an episode has failed [s]."""


ParameterSet = Mapping[str, Any]
"""Values of varied parameters, by name."""


@dataclass(frozen=True)
class RunRequest:
    """A tree and the parts and settings to run it with.

    The same request gives the same run, bit for bit, with any observers.

    Reports and recordings say what it says.

    Attributes:
        tree: The tree to run; default: none.
        robot: Name of a registered robot, path of a TOML file that describes one, or a description;
            for each robot of the scene that has no description of its own.
        controller: Name of the registered controller that each cycle begins with.
        scene: Name of a registered scene, path of a TOML file that describes one, or a scene.
        planner: Name of a registered planner.
        cycles: Number of runs of the root from idle to SUCCESS or FAILURE; 0 runs until stopped.
        seed: Seed of all randomness.
        tick: Simulated time between two ticks of the tree [s], a whole number of control steps.
        modifiers: Texts of each modifier of the run, by its registered name, as in ``bt-manip run
            --NAME TEXT``.
        settings: Values of keys that the tree declares at its root, as text.
        real_time: Simulated seconds per second of wall time; None runs as fast as possible.
        configurations: Named configurations of the robots, besides those of their descriptions and
            of the scene.
        poses: Name of a registered source of poses of the objects that the scene expects, or
            `bt_manip.scenes.PHYSICS`.
        backend: ``NAME=ADDRESS`` of a registered backend and a real robot; empty simulates it.
        speed: Factor of all speed scales of the arms, above 0 and up to 1; None: `REAL_SPEED` on a
            real robot, else 1.
        tool_speed: Limit of the speed of the robots' tools in every motion [m/s]; infinity for
            none. None: that of the scene or the description, or 0.25 m/s on a real robot.
        varied: Values of parameters of tree, controller, scene and robot, by name, as in ``bt-manip
            run --vary``.
        reading: How the document of the tree is read.
    """

    tree: TreeSource = field(default_factory=lambda: TreeSource("", "python"))
    robot: str | RobotDescription = "panda"
    controller: str = CONTROLLER
    scene: str | Scene = SCENE
    planner: str = PLANNER
    cycles: int = 1
    seed: int = 0
    tick: float = TICK
    modifiers: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: MappingProxyType({}))
    settings: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    real_time: float | None = None
    configurations: Mapping[str, Configuration] = field(
        default_factory=lambda: MappingProxyType({})
    )
    poses: str = PHYSICS
    backend: str = ""
    speed: float | None = None
    tool_speed: float | None = None
    varied: ParameterSet = field(default_factory=lambda: MappingProxyType({}))
    reading: ReadingOptions = READING

    def __post_init__(self) -> None:
        """Raise a `BtManipError` for a number that is out of range."""
        if self.cycles < 0:
            raise BtManipError(
                f"cycles must be 0 (until interrupted) or a positive number, got {self.cycles}"
            )
        if self.seed < 0:
            raise BtManipError(f"seed must be 0 or a positive number, got {self.seed}")
        if not 0.0 < self.tick < 60.0:
            raise BtManipError(f"tick must be positive and below 60 s, got {self.tick:g} s")
        if abs(self.tick / CONTROL_STEP - self.steps_per_tick) > 1e-6 or self.steps_per_tick < 1:
            raise BtManipError(
                f"tick must be a whole number of control steps of {CONTROL_STEP * 1e3:g} ms, "
                f"got {self.tick * 1e3:g} ms"
            )
        if not 0.0 < self.speed_factor <= 1.0:
            raise BtManipError(f"speed must be above 0 and at most 1, got {self.speed_factor:g}")
        if self.tool_speed is not None and not self.tool_speed > 0.0:
            raise BtManipError(f"tool speed must be positive, got {self.tool_speed:g} m/s")
        if self.real_time is not None and not 0.0 < self.real_time < float("inf"):
            raise BtManipError(f"real-time factor must be positive, got {self.real_time:g}")

    @property
    def station(self) -> tuple[Any, ...]:
        """The part of the request that a station is built from, as a key."""
        return (
            self.scene, self.robot, self.controller, self.planner, self.seed,
            tuple(self.settings.items()), self.poses, self.backend, self.speed_factor,
            self.tool_speed, tuple(self.varied.items()),
        )  # fmt: skip

    @property
    def speed_factor(self) -> float:
        """Factor of all speed scales of the arms."""
        if self.speed is None:
            return REAL_SPEED if self.backend else 1.0
        return self.speed

    @property
    def steps_per_tick(self) -> int:
        """Number of control steps per tick."""
        return round(self.tick / CONTROL_STEP)


def check_modifiers(names: Iterable[str], backend: str | None, parts: Parts) -> None:
    """Check that modifiers are for real robots, if there is a backend."""
    for name in names if backend else ():
        if not getattr(parts.modifiers.get(name), "real", False):
            raise BtManipError(f"--{name} needs a simulation, not --backend {backend}")


def request_of(tree: str, parts: Parts, **options: Any) -> RunRequest:
    """Return the request of a tree, with its own scene and controller where none is given.

    Args:
        tree: The tree as the user names it.
        parts: The registered parts.
        **options: Fields of `RunRequest`; None: the default.

    Raises:
        BtManipError: If there is no such tree, or an option is out of range.
    """
    wants = parts.tree_defaults.get(tree, TreeDefaults())
    check_modifiers(options.get("modifiers") or (), options.get("backend"), parts)
    backend = find_backend(options.get("backend") or "", parts)
    controller = wants.controller or backend.default_controller
    defaults = {"scene": wants.scene, "controller": controller}
    given = {key: value for key, value in options.items() if value is not None}
    chosen = {key: value for key, value in defaults.items() if value is not None}
    registered = parts.trees.copies()
    return RunRequest(find_tree(tree, registered), **(chosen | given))

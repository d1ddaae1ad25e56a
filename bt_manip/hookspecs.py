"""The hooks through which parts come in, the built-in ones too, and those that watch a run.

A plugin is a module (or any object) that an entry point of the group ``bt_manip`` names. It marks
functions with the names and arguments below with ``bt_manip.hookimpl``. The hooks that begin with
``register_`` are called once, when bt-manip loads its plugins, and call `register` for every part
that the plugin brings. The others are called during runs; they may look at everything and change
nothing, and take only those of the arguments that they need.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pluggy

GROUP = "bt_manip"
"""Name of the entry-point group, and of the project in pluggy's eyes."""

hookspec = pluggy.HookspecMarker(GROUP)
hookimpl = pluggy.HookimplMarker(GROUP)


@hookspec
def register_objects(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Bring objects: things that stand or lie in the cell.

    Args:
        register: ``register(name, factory)``, where ``factory(**parameters)`` makes a new
            composer entity each time.
    """


@hookspec
def register_robots(register: Callable[[Any], None]) -> None:
    """Bring robots: an arm with its gripper.

    Args:
        register: ``register(description)`` with a `bt_manip.robots.RobotDescription`, which
            carries its name.
    """


@hookspec
def register_grippers(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Bring kinds of grippers, which robots' descriptions name.

    Args:
        register: ``register(name, factory)``, where ``factory(robot)`` makes a new
            `bt_manip.robots.Gripper` for a `bt_manip.robots.Robot` that is not compiled yet.
    """


@hookspec
def register_controllers(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Bring controllers, which turn an arm's reference into torques.

    Args:
        register: ``register(name, factory)``, where ``factory(robot)`` makes a new
            `bt_manip.control.Controller` for a `bt_manip.robots.Robot`.
    """


@hookspec
def register_planners(register: Callable[[str, Callable[[], Any]], None]) -> None:
    """Bring planners, which find collision-free paths around obstacles.

    Args:
        register: ``register(name, factory)``, where ``factory()`` makes a
            `bt_manip.planning.Planner`.
    """


@hookspec
def register_behaviours(register: Callable[..., None]) -> None:
    """Bring behaviours: leaves, decorators and control nodes of trees.

    Args:
        register: ``register(cls)`` or ``register(cls, name)`` with a class of `bt_manip.bt`; the
            name in trees is the class's own unless another is given.
    """


@hookspec
def register_trees(register: Callable[[str, Any], None]) -> None:
    """Bring trees that ``bt-manip run`` knows by name.

    Args:
        register: ``register(name, place)``, where the place is the path of an XML file, or
            ``"path.py:function"`` for a function that returns a tree. A tree that only works
            somewhere says where: ``register(name, place, scene="...", controller="...")``, by
            registered names, which ``--scene`` and ``--controller`` override.
    """


@hookspec
def register_scenes(register: Callable[[str, Callable[[], Any]], None]) -> None:
    """Bring scenes: what stands in the cell before a tree begins.

    Args:
        register: ``register(name, factory)``, where ``factory()`` makes a
            `bt_manip.runner.Scene`.
    """


@hookspec
def register_model_sources(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Bring sources of models: kinds of addresses that objects can be made from.

    Args:
        register: ``register(kind, find)``, where ``find(address, progress)`` gives the
            `bt_manip.models.FoundModel` or the path of the file for an address ``kind:...``;
            ``progress(name, done, total)`` is told how far a download is [bytes].
    """


@hookspec
def register_recorders(register: Callable[[str, Callable[[Path | None], Any]], None]) -> None:
    """Bring recorders, which ``bt-manip run --record NAME=FILE`` writes a file with.

    Args:
        register: ``register(name, factory)``, where ``factory(path)`` makes a
            `bt_manip.runner.RunObserver`; the path is None where the user gave no file.
    """


@hookspec
def after_compile(station: Any) -> None:
    """Look at the cell after it was compiled: before the first step, and after each change.

    Args:
        station: The `bt_manip.runner.Station` of the run.
    """


@hookspec
def cycle_started(station: Any, tree: Any, cycle: int) -> None:
    """Look at the beginning of a cycle: one run of the tree from idle to SUCCESS or FAILURE.

    Args:
        station: The `bt_manip.runner.Station` of the run.
        tree: The `bt_manip.bt.Tree` that runs.
        cycle: Number of the cycle; the first has 0.
    """


@hookspec
def before_tick(station: Any, tree: Any) -> None:
    """Look at the state that the tree is about to be ticked in.

    Args:
        station: The `bt_manip.runner.Station` of the run.
        tree: The `bt_manip.bt.Tree` that runs.
    """


@hookspec
def after_tick(station: Any, tree: Any) -> None:
    """Look at the state after a tick and the control steps that belong to it.

    Args:
        station: The `bt_manip.runner.Station` of the run.
        tree: The `bt_manip.bt.Tree` that runs.
    """


@hookspec
def cycle_ended(station: Any, tree: Any, cycle: int, status: str, reason: str) -> None:
    """Look at the end of a cycle; not called for one that is interrupted or raises.

    Args:
        station: The `bt_manip.runner.Station` of the run.
        tree: The `bt_manip.bt.Tree` that ran.
        cycle: Number of the cycle; the first has 0.
        status: ``"SUCCESS"`` or ``"FAILURE"``.
        reason: Why it failed, with the path of the node; empty on success.
    """


REGISTERING = tuple(name for name in vars() if name.startswith("register_"))
"""Names of the hooks through which parts come in."""

OBSERVING = (
    "after_compile",
    "cycle_started",
    "before_tick",
    "after_tick",
    "cycle_ended",
)
"""Names of the hooks that watch runs, in the order in which they are called."""

RENAMED = {"initialize_episode": "cycle_started", "episode_ended": "cycle_ended"}
"""New names of hooks by their earlier ones."""

"""Hooks that register parts, built-in ones included, and hooks that observe runs.

A plugin is a module (or any object) that an entry point of the group ``bt_manip`` names. It
implements hooks as functions with the names and arguments below, marked with ``bt_manip.hookimpl``.
Hooks whose names begin with ``register_`` are called once, when bt-manip loads its plugins; an
implementation calls `register` for every part that the plugin provides. The other hooks are called
during runs. They may read everything but must not change anything, and may omit arguments that they
do not use.
"""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pluggy

GROUP = "bt_manip"
"""Name of the entry-point group and of the pluggy project."""

hookspec = pluggy.HookspecMarker(GROUP)
hookimpl = pluggy.HookimplMarker(GROUP)


@hookspec
def register_objects(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register objects that can be added to the cell.

    Args:
        register: ``register(name, factory)``, where ``factory(**parameters)`` returns a
            new composer entity.
    """


@hookspec
def register_robots(register: Callable[[Any], None]) -> None:
    """Register robots: an arm with an optional gripper.

    Args:
        register: ``register(description)`` with a `bt_manip.robots.RobotDescription`, which
            includes its name.
    """


@hookspec
def register_grippers(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register kinds of grippers, which robot descriptions refer to by name.

    Args:
        register: ``register(name, factory)``, where ``factory(robot)`` returns a new
            `bt_manip.robots.Gripper` for a `bt_manip.robots.Robot` that is not compiled yet.
    """


@hookspec
def register_controllers(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register controllers, which compute torques from an arm's reference.

    Args:
        register: ``register(name, factory)``, where ``factory(robot)`` returns a new
            `bt_manip.control.Controller` for a `bt_manip.robots.Robot`.
    """


@hookspec
def register_planners(register: Callable[[str, Callable[[], Any]], None]) -> None:
    """Register planners, which find collision-free paths around obstacles.

    Args:
        register: ``register(name, factory)``, where ``factory()`` returns a
            `bt_manip.planning.Planner`.
    """


@hookspec
def register_behaviours(register: Callable[..., None]) -> None:
    """Register behaviours: leaves, decorators and control nodes of trees.

    Args:
        register: ``register(cls)`` or ``register(cls, name)`` with a subclass of a `bt_manip.bt`
            node class; the name in trees defaults to the name of the class.
    """


@hookspec
def register_dialects(register: Callable[[Any], None]) -> None:
    """Register dialects of trees: how documents of other engines and editors are read.

    Args:
        register: ``register(dialect)`` with a `bt_manip.bt.Dialect`, which includes its name.
    """


@hookspec
def register_conversions(register: Callable[[str, Callable[..., str]], None]) -> None:
    """Register languages that ``bt-manip tree convert --to NAME`` writes.

    Args:
        register: ``register(name, write)``, where ``write(reading, stubs)`` returns the text of a
            `bt_manip.bt.Reading` without errors; the stubs are those with which it was read.
    """


@hookspec
def register_trees(register: Callable[[str, Any], None]) -> None:
    """Register trees that ``bt-manip run`` accepts by name.

    Args:
        register: ``register(name, place)``, where the place is the path of an XML file, or
            ``"path.py:function"`` for a function that returns a tree. A tree that requires a scene
            or controller names it, as registered: ``register(name, place, scene="...",
            controller="...")``. ``--scene`` and ``--controller`` override these names.
    """


@hookspec
def register_scenes(register: Callable[[str, Callable[[], Any]], None]) -> None:
    """Register scenes: the contents of the cell before a tree starts.

    Args:
        register: ``register(name, factory)``, where ``factory()`` returns a
            `bt_manip.scenes.Scene`.
    """


@hookspec
def register_model_sources(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register sources of models: kinds of addresses from which objects can be created.

    Args:
        register: ``register(kind, find)``, where ``find(address, progress)`` returns
            the `bt_manip.models.FoundModel` or the path of the file for an address ``kind:...``,
            and calls ``progress(name, done, total)`` during a download [bytes]. An attribute
            ``checks_downloads = True`` of the function says that it calls
            `bt_manip.models.check_downloads` before each download. Only such functions find the
            models of a snapshot.
    """


@hookspec
def register_model_formats(register: Callable[[str, Any], None]) -> None:
    """Register formats of model files, which are converted to MJCF.

    Args:
        register: ``register(name, format)`` with a `bt_manip.models.ModelFormat`, whose suffixes
            and root element no other format has.
    """


@hookspec
def register_model_caches(register: Callable[[str, Callable[[], Any]], None]) -> None:
    """Register caches of models, which ``bt-manip models list``, ``fetch`` and ``clear`` manage.

    Args:
        register: ``register(name, factory)``, where ``factory()`` returns a
            `bt_manip.models.ModelCache`.
    """


@hookspec
def register_recorders(register: Callable[[str, Callable[[Path | None], Any]], None]) -> None:
    """Register recorders, which write the file of ``bt-manip run --record NAME=FILE``.

    Args:
        register: ``register(name, factory)``, where ``factory(path)`` makes a
            `bt_manip.runner.RunObserver`; the path is None if the user gave no file. Keyword-only
            arguments are its options, ``--record "FILE KEY=VALUE"``, declared by a
            `bt_manip.parameters.Parameter`, or by their default alone. An attribute ``suffix`` of
            the factory, a text or several, lets ``--record FILE`` choose it.
    """


@hookspec
def register_views(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register views of runs, which an option of ``bt-manip run`` opens: ``--NAME``.

    The command line calls this hook alone, also for ``--help``, of the modules in which its name
    stands: such a module, and the hook, import nothing expensive.

    Args:
        register: ``register(name, factory)``, where ``factory(session)`` makes a
            `bt_manip.runner.RunView` for the runs of a `bt_manip.cli.Session`. An attribute
            ``controls_runs = True`` of the factory says that the view paces runs itself, and that
            its ``serve(session)`` starts others after the first one. The first line of its
            documentation is the help of ``--NAME``. Keyword-only arguments are its options
            ``--NAME-KEY``, declared by a `bt_manip.parameters.Parameter`, or by their default
            alone.
    """


@hookspec
def register_pools(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register pools of workers, on which the option ``--NAME`` of ``bt-manip evaluate`` runs.

    ``sweep`` has the option, too. It is found as those of `register_views`.

    Args:
        register: ``register(name, factory)``, where ``factory(make_worker, address, workers)``
            returns a pool with the methods and ``cpus`` of `bt_manip.evaluation.ProcessPool`. The
            address is the value of the option, ``"local"`` without one; 0 workers are as many as
            it has CPUs. ``make_worker()`` makes a `bt_manip.evaluation.Worker`; it can be pickled.
    """


@hookspec
def register_commands(register: Callable[..., None]) -> None:
    """Register commands of the program, or of one of its groups, such as ``tree``.

    The command line calls this hook alone, also for ``--help``, of the modules in which its name
    stands: such a module, and the hook, import nothing expensive.

    Args:
        register: ``register(name, target, group="")``, where the target is the place of a click
            command, ``"module:function"``, or the command itself. Of a place, the module is
            imported only when the command runs. Its group is the name of a group of commands, if it
            is not a command of the program. Commands that exist are not replaced.
    """


@hookspec
def register_modifiers(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register modifiers of runs, which the option ``--NAME TEXT`` of ``bt-manip run`` adds.

    ``evaluate`` and ``sweep`` have the option, too. It is found as those of `register_views`.

    Args:
        register: ``register(name, factory)``, where ``factory(run, texts, warn)`` makes a
            `bt_manip.runner.RunModifier` for a `bt_manip.runner.Run` from the values of the option,
            and ``warn`` takes warnings. The first line of its documentation is the help of
            ``--NAME``. It may have attributes: ``metavar``, the form of the values; ``group`` of
            options, under which it is listed; ``real``, whether it goes with ``--backend``.
    """


@hookspec
def register_contracts(register: Callable[[str, Callable[..., Iterable[Any]]], None]) -> None:
    """Register contracts: checks of the parts of all plugins.

    Args:
        register: ``register(name, checks)``, where ``checks(parts, provides, settings)`` yields a
            `bt_manip.testing.Check` for each check of the parts that a plugin provides: all
            `Parts`, the plugin's names of parts by kind, and the settings of its trees by name.
    """


@hookspec
def register_backends(register: Callable[[str, Any], None]) -> None:
    """Register backends, by which ``bt-manip run --backend NAME=ADDRESS`` runs on a real robot.

    Args:
        register: ``register(name, backend)`` with a `bt_manip.robots.Backend`.
    """


@hookspec
def register_pose_sources(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register sources of poses, which ``bt-manip run --poses NAME`` asks where objects are.

    Args:
        register: ``register(name, factory)``, where ``factory(expected)`` gets the
            `bt_manip.scenes.SceneObject` of each expected object and returns a
            `bt_manip.scenes.PoseSource`.
    """


@hookspec
def after_compile(station: Any) -> None:
    """Observe the cell after each compilation: before the first step, and after each change.

    Args:
        station: The `bt_manip.runner.Station` of the run.
    """


@hookspec
def cycle_started(station: Any, tree: Any, cycle: int) -> None:
    """Observe the start of a cycle: one run of the tree from idle to SUCCESS or FAILURE.

    Args:
        station: The `bt_manip.runner.Station` of the run.
        tree: The running `bt_manip.bt.Tree`.
        cycle: Number of the cycle, from 0.
    """


@hookspec
def before_tick(station: Any, tree: Any) -> None:
    """Observe the state before a tick.

    Args:
        station: The `bt_manip.runner.Station` of the run.
        tree: The running `bt_manip.bt.Tree`.
    """


@hookspec
def after_tick(station: Any, tree: Any) -> None:
    """Observe the state after a tick and its control steps.

    Args:
        station: The `bt_manip.runner.Station` of the run.
        tree: The running `bt_manip.bt.Tree`.
    """


@hookspec
def cycle_ended(station: Any, tree: Any, cycle: int, status: str, reason: str) -> None:
    """Observe the end of a cycle; not called if the cycle is interrupted or raises.

    Args:
        station: The `bt_manip.runner.Station` of the run.
        tree: The `bt_manip.bt.Tree` that ran.
        cycle: Number of the cycle, from 0.
        status: ``"SUCCESS"`` or ``"FAILURE"``.
        reason: Why it failed, with the path of the node; empty on success.
    """


REGISTERING = tuple(name for name in vars() if name.startswith("register_"))
"""Names of the hooks that register parts; plugins declare further ones."""

OBSERVING = (
    "after_compile",
    "cycle_started",
    "before_tick",
    "after_tick",
    "cycle_ended",
)
"""Names of the hooks that observe runs, in the order of their calls."""

RENAMED = {"initialize_episode": "cycle_started", "episode_ended": "cycle_ended"}
"""New names of renamed hooks, by their former names."""

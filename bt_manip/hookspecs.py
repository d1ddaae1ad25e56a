"""The hooks through which parts come in, the built-in ones too.

A plugin is a module (or any object) that an entry point of the group ``bt_manip`` names. It marks
functions with the names and arguments below with ``bt_manip.hookimpl``; each is called once, when
bt-manip loads its plugins, and calls `register` for every part that it brings.
"""

from collections.abc import Callable
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
def register_controllers(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Bring controllers, which turn an arm's reference into torques.

    Args:
        register: ``register(name, factory)``, where ``factory(robot)`` makes a new
            `bt_manip.control.Controller` for a `bt_manip.robots.Robot`.
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
            ``"path.py:function"`` for a function that returns a tree.
    """

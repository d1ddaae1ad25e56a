"""Hooks that plugins declare, for kinds of parts of their own."""

import inspect
from collections.abc import Callable
from typing import Any, TypeVar

from bt_manip import hookspecs
from bt_manip.exceptions import BtManipError
from bt_manip.registry import Parts, Registry

F = TypeVar("F", bound=Callable[..., Any])
Check = Callable[[str, Any], None]


def hookspec(kind: str, check: Check | None = None) -> Callable[[F], F]:
    """Mark a function ``register_KINDS(register)`` as the specification of a new hook.

    The module of the plugin has the function as an attribute. All plugins may implement the hook;
    the parts that they register are in ``parts.of("KINDS")``. A plugin that also works without the
    declaring one implements it with ``hookimpl(optionalhook=True)``.

    Args:
        kind: Kind of the parts, in the singular, for messages.
        check: ``check(name, part)`` raises a `BtManipError` for an invalid part; default: a part is
            callable.
    """

    def mark(function: F) -> F:
        vars(function).update(kind=kind, check=check)
        return hookspecs.hookspec(function)

    return mark


def declare_hooks(plugin: object, parts: Parts, hooks: dict[str, Callable[..., None]]) -> None:
    """Add the hooks that a plugin declares, with an empty registry for the parts of each.

    Raises a `BtManipError` if there is a hook of this name already, or it is not of this form.
    """
    for name in dir(plugin):
        hook = getattr(plugin, name)
        marked = inspect.isfunction(hook) and hasattr(hook, f"{hookspecs.GROUP}_spec")
        if not marked or hooks.get(name) is hook:
            continue
        if name in hooks:
            raise BtManipError(f"it declares the hook '{name}', which there is already")
        kind = name.removeprefix("register_")
        if kind == name or [*inspect.signature(hook).parameters] != ["register"]:
            raise BtManipError(f"'{name}' cannot be declared: hooks are register_KINDS(register)")
        hooks[name] = hook
        parts.declared[kind] = Registry(vars(hook).get("kind", kind))

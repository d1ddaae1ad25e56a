"""Check the functions of one plugin against the specifications of the hooks."""

import inspect
from collections.abc import Callable
from typing import Any

import pluggy

from bt_manip import hookspecs
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.plugins.plugin import Implementation


def implementations(plugin: object) -> list[Implementation]:
    """Return the hook implementations of a plugin, in the order of the specifications.

    Raises:
        BtManipError: When a hook is misspelt, takes unknown arguments, is not a plain function,
            or wraps others; when there is no hook.
    """
    manager = pluggy.PluginManager(hookspecs.GROUP)
    manager.add_hookspecs(hookspecs)
    known = (*hookspecs.REGISTERING, *hookspecs.OBSERVING)
    for attribute in dir(plugin):
        options = manager.parse_hookimpl_opts(plugin, attribute)
        if options is None:
            continue
        name = options.get("specname") or attribute
        if name in hookspecs.RENAMED:
            raise BtManipError(f"the hook '{name}' is now called '{hookspecs.RENAMED[name]}'")
        if name not in known:
            raise BtManipError(f"there is no hook '{name}'{did_you_mean(name, known)}")
        if options.get("wrapper") or options.get("hookwrapper"):
            raise BtManipError(f"'{name}' wraps other plugins' hooks; hooks only register")
        _check_function(name, getattr(plugin, attribute))
    manager.register(plugin)
    found = [
        Implementation(name, impl.function, tuple(_taken(impl.function)))
        for name in known
        for impl in getattr(manager.hook, name).get_hookimpls()
    ]
    if not found:
        raise BtManipError("it implements no hook; mark its functions with bt_manip.hookimpl")
    return found


def _check_function(name: str, function: Callable[..., Any]) -> None:
    """Raise an error for a function that cannot be called as this hook."""
    if inspect.isgeneratorfunction(function) or inspect.isasyncgenfunction(function):
        raise BtManipError(f"'{name}' has a yield in it; a hook is a plain function")
    if inspect.iscoroutinefunction(function):
        raise BtManipError(f"'{name}' is async; a hook is a plain function")
    offered = tuple(inspect.signature(getattr(hookspecs, name)).parameters)
    taken = _taken(function)
    for argument in taken:
        if argument not in offered:
            what = did_you_mean(argument, offered)
            raise BtManipError(f"'{name}' is not given '{argument}', which it takes{what}")
    if name in hookspecs.REGISTERING and not taken:
        raise BtManipError(f"'{name}' does not take 'register', which it is called with")


def _taken(function: Callable[..., Any]) -> list[str]:
    """Return the names of a function's arguments without a default."""
    return [
        name
        for name, parameter in inspect.signature(function).parameters.items()
        if parameter.default is parameter.empty
        and parameter.kind not in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD)
    ]

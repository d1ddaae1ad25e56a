"""Check the functions of one plugin against the specifications of the hooks."""

from collections.abc import Callable
from typing import Any, NamedTuple

import pluggy

from bt_manip import hookspecs
from bt_manip.exceptions import BtManipError, did_you_mean


class Implementation(NamedTuple):
    """What a plugin has for a hook."""

    hook: str
    function: Callable[..., Any]
    arguments: tuple[str, ...]  # those that it takes, of those that are offered


def implementations(plugin: object) -> list[Implementation]:
    """Find a plugin's hooks, in the order of the specifications.

    Raises:
        BtManipError: When a hook is misspelt or wraps others, or there is none.
        pluggy.PluginValidationError: When a hook takes what is not offered.
    """
    manager = pluggy.PluginManager(hookspecs.GROUP)
    manager.add_hookspecs(hookspecs)
    known = (*hookspecs.REGISTERING, *hookspecs.OBSERVING)
    for attribute in dir(plugin):
        options = manager.parse_hookimpl_opts(plugin, attribute)
        if options is None:
            continue
        name = options.get("specname") or attribute
        if name not in known:
            raise BtManipError(f"there is no hook '{name}'{did_you_mean(name, known)}")
        if options.get("wrapper") or options.get("hookwrapper"):
            raise BtManipError(f"'{name}' wraps other plugins' hooks; hooks only register")
    manager.register(plugin)
    found = [
        Implementation(name, impl.function, tuple(impl.argnames))
        for name in known
        for impl in getattr(manager.hook, name).get_hookimpls()
    ]
    if not found:
        raise BtManipError("it implements no hook; mark its functions with bt_manip.hookimpl")
    return found

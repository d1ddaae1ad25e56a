"""The hook that this package declares."""

from collections.abc import Callable
from typing import Any

from bt_manip import hookspec


@hookspec("panel")
def register_panels(register: Callable[[str, Callable[[Any], Any]], None]) -> None:
    """Register panels of the page of a run.

    Args:
        register: ``register(name, factory)``, where ``factory(page)`` returns a new
            `bt_manip_view.Panel` of a page. It gets a tab with its name, unless an attribute
            ``place`` of the factory says another place.
    """

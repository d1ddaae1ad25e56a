"""Parts of installed plugins for functions below the runner, which get no parts."""

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bt_manip.registry import Parts

_load: "Callable[[], Parts]"


def set_loader(load: "Callable[[], Parts]") -> None:
    """Set the function behind `installed_parts`; ``bt_manip`` does so when it is imported."""
    global _load
    _load = load


def installed_parts() -> "Parts":
    """Load the parts of all installed plugins."""
    return _load()

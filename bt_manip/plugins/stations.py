"""Stations of registered parts, for scripts."""

from typing import Any

from bt_manip.registry import Parts
from bt_manip.runner import RunRequest, Station, make_station

from .loading import load_plugins


def build_station(parts: Parts | None = None, **request: Any) -> Station:
    """Build a cell with its robots at home and under control.

    Args:
        parts: The registered parts; default: those of all installed plugins.
        **request: Fields of `bt_manip.runner.RunRequest`, such as ``robot``, ``controller``,
            ``planner``, ``scene`` or ``seed``; None: the default.

    Raises:
        BtManipError: If a name is not registered or a model does not compile.
    """
    given = {name: value for name, value in request.items() if value is not None}
    return make_station(RunRequest(**given), load_plugins().parts if parts is None else parts)

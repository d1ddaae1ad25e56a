"""The registered panels, isolated so that an exception in one does not end the run."""

from collections.abc import Callable
from typing import Any

from bt_manip.cli import print_warning
from bt_manip.plugins import Plugins, guarded
from bt_manip_view.plugin import PANELS

from .panel import Panel


def page_panels(plugins: Plugins) -> dict[str, Callable[[Any], Any]]:
    """Return the makers of the panels of the page, those of this package first.

    Exceptions in a panel do not end the run.
    """
    registered = plugins.parts.of("panels").in_order()
    names = sorted(registered, key=lambda name: name not in PANELS)
    return {name: _maker(plugins, name) for name in names}


def _maker(plugins: Plugins, name: str) -> Callable[[Any], Any]:
    panels = plugins.parts.of("panels")
    label, hint = plugins.origin(panels.owner(name))
    label = f"panel '{name}'{label}"

    def make(page: Any) -> Any:
        try:
            panel = panels.maker(name, "start", "draw", expected="a Panel")(page)
        except (Exception, SystemExit) as error:
            print_warning(f"{label} is left out: {error}{hint}")
            return Panel(page)
        return guarded(panel, label, print_warning, hint, base=Panel)

    kind: Any = panels.get(name)
    for attribute in ("place", "needs_run", "whole_run"):
        setattr(make, attribute, getattr(kind, attribute, getattr(Panel, attribute)))
    return make

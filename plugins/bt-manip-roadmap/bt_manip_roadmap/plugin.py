"""Hooks of this package."""

from collections.abc import Callable

from bt_manip import hookimpl


@hookimpl
def register_planners(register: Callable[..., None]) -> None:
    """Register the planner."""
    from bt_manip_roadmap.lazy_roadmap import LazyRoadmap

    register("lazy_roadmap", LazyRoadmap)

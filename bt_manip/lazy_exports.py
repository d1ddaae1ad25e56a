"""Packages that import what they export only when it is asked for."""

import importlib
from collections.abc import Callable, Mapping
from typing import Any


def lazy_exports(package: str, modules: Mapping[str, str]) -> Callable[[str], Any]:
    """Make a package's ``__getattr__`` (PEP 562), for exports that are expensive to import.

    Args:
        package: Full name of the package.
        modules: The module of each exported name, relative to the package if it starts with a dot.
    """

    def get(name: str) -> Any:
        if name not in modules:
            raise AttributeError(f"module '{package}' has no attribute {name!r}")
        return getattr(importlib.import_module(modules[name], package), name)

    return get

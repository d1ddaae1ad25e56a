"""Packages that import their exported names on first use."""

import importlib
from collections.abc import Callable, Mapping
from typing import Any


def lazy_exports(package: str, exports: Mapping[str, str]) -> Callable[[str], Any]:
    """Make a package's ``__getattr__`` (PEP 562), for exports that are expensive to import.

    Type checkers read the same imports under ``if TYPE_CHECKING``; a test compares the two.

    Args:
        package: Full name of the package.
        exports: The names exported from each module, separated by blanks.
    """
    modules = {name: module for module, names in exports.items() for name in names.split()}

    def get(name: str) -> Any:
        if name not in modules:
            raise AttributeError(f"module '{package}' has no attribute {name!r}")
        return getattr(importlib.import_module(modules[name]), name)

    return get

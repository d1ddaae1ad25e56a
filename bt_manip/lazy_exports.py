"""Packages that import their exported names on first use."""

import ast
import importlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any


def lazy_exports(package: str, file: str) -> Callable[[str], Any]:
    """Make a package's ``__getattr__`` (PEP 562), for exports that are expensive to import.

    They are the names that it imports under ``if TYPE_CHECKING``, as type checkers read them.

    Args:
        package: Full name of the package, its ``__name__``.
        file: Its ``__file__``, which is parsed when the first name is used.
    """

    @cache
    def modules() -> dict[str, str]:
        statements = ast.walk(ast.parse(Path(file).read_bytes()))
        imports = [one for one in statements if isinstance(one, ast.ImportFrom)]
        return {alias.name: str(one.module) for one in imports for alias in one.names}

    def get(name: str) -> Any:
        if name not in modules():
            raise AttributeError(f"module '{package}' has no attribute {name!r}")
        return getattr(importlib.import_module(modules()[name]), name)

    return get

"""Packages that import what they export only when it is asked for."""

import ast
import importlib
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any


def lazy_exports(package: str) -> Callable[[str], Any]:
    """Make a package's ``__getattr__`` (PEP 562), for exports that are expensive to import.

    The exports are the ``from module import name as name`` in the source of the package's
    ``__init__``, under ``if TYPE_CHECKING``: what type checkers see is what is exported.

    Args:
        package: Full name of the package.
    """

    @cache
    def modules() -> dict[str, str]:
        source = Path(str(sys.modules[package].__file__)).read_text(encoding="utf-8")
        imports = (n for n in ast.walk(ast.parse(source)) if isinstance(n, ast.ImportFrom))
        return {a.name: str(n.module) for n in imports for a in n.names if a.asname == a.name}

    def get(name: str) -> Any:
        if name not in modules():
            raise AttributeError(f"module '{package}' has no attribute {name!r}")
        return getattr(importlib.import_module(modules()[name], package), name)

    return get

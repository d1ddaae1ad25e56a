"""Names in packages that may be missing, to tell users which one to install."""

import sys
import tomllib
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from bt_manip.exceptions import did_you_mean


@cache
def packages() -> dict[str, dict[str, str]]:
    """Return the names of each package by kind, separated by blanks: ``packages.toml``."""
    return tomllib.loads(Path(__file__).with_name("packages.toml").read_text())


def missing(kind: str | None, name: str) -> str:
    """Return the end of an error message: the package of an unknown name, and its installation.

    Args:
        kind: A kind of `packages`; None for any.
        name: The name.

    Returns:
        ``"needs the package ..."``, or an empty string if no package has it.
    """
    for package, kinds in packages().items():
        known = kinds.keys() - {"requires"} if kind is None else kinds.keys() & {kind}
        if any(name in kinds[each].split() for each in known):
            both = (kinds.get("requires"), package)
            folders = " ".join(f"./plugins/{each}" for each in both if each)
            return f"needs the package {package}: pip install {folders} (in a clone)"
    return ""


def suggestion(kind: str | None, name: str, valid: Iterable[str]) -> str:
    """Return the package of an unknown name, or the nearest valid names, for an error message.

    Args:
        kind: A kind of `packages`; None for any.
        name: The unknown name.
        valid: The known names.

    Returns:
        ``"; it needs the package ..."``, or what `did_you_mean` returns.
    """
    package = missing(kind, name)
    return f"; it {package}" if package else did_you_mean(name, valid)


class MovedModules:
    """Finder of modules that names the package into which one has moved."""

    @staticmethod
    def find_spec(name: str, path: Any = None, target: Any = None) -> None:
        """Find nothing; raise an ImportError for a module, or a name in one, that has moved."""
        for package, kinds in packages().items():
            if name in kinds.get("module", "").split():
                root, last = package.replace("-", "_"), name.rpartition(".")[2]
                same = last.endswith(root.rpartition("_")[2])  # such as robot_setup
                new = root if same else f"{root}.{last}"
                problem = f"{name} is now {new}, and {missing('module', name)}"
                raise ModuleNotFoundError(problem, name=name)


def name_moved_modules() -> None:
    """Let imports of modules that have moved name their packages."""
    sys.meta_path.append(MovedModules)

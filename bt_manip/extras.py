"""Optional dependencies of the package."""

import importlib.util

from bt_manip.exceptions import BtManipError


def require_extra(extra: str, what: str, *packages: str) -> None:
    """Check that packages of an extra are installed, without importing them.

    Args:
        extra: Name of the extra: ``"view"``.
        what: What needs them, the first words of the message: ``"--view"``.
        packages: Names of their top-level modules.

    Raises:
        BtManipError: If one is missing; the message names the extra.
    """
    for package in packages:
        if importlib.util.find_spec(package) is None:
            raise BtManipError(f"{what} needs {package}: pip install 'bt-manip[{extra}]'")

"""The hook that this package declares."""

from collections.abc import Callable
from typing import Any

from bt_manip import hookspec
from bt_manip.exceptions import BtManipError


def _check(name: str, kind: Any) -> None:
    if not isinstance(getattr(kind, "make", None), str):
        raise BtManipError(f"a kind of policies is a PolicyKind, got {kind!r}")


@hookspec("kind of policies", _check)
def register_policies(register: Callable[[str, Any], None]) -> None:
    """Register kinds of learned policies, which `RunPolicy` runs in trees.

    Args:
        register: ``register(name, kind)`` with a `bt_manip_policy.PolicyKind`.
    """

"""The hook that this package declares, and the parts that it registers."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from bt_manip import hookimpl, hookspec
from bt_manip.exceptions import BtManipError

TREES = Path(__file__).parent / "trees"


def _check(name: str, kind: Any) -> None:
    if not isinstance(getattr(kind, "make", None), str):
        raise BtManipError(f"a kind of policies is a PolicyKind, got {kind!r}")


@hookspec("kind of policies", _check)
def register_policies(register: Callable[[str, Any], None]) -> None:
    """Register kinds of learned policies, which `RunPolicy` runs in trees.

    Args:
        register: ``register(name, kind)`` with a `bt_manip_policy.PolicyKind`.
    """


@hookimpl
def register_behaviours(register: Callable[..., None]) -> None:
    """Register the policy as a leaf, and a condition for its end."""
    from bt_manip_policy.is_above import IsAbove
    from bt_manip_policy.run_policy import RunPolicy

    register(RunPolicy)
    register(IsAbove)


@hookimpl(specname="register_policies")
def register_own_policies(register: Callable[..., None]) -> None:
    """Register policies in ONNX files."""
    from bt_manip_policy.policy_kind import ONNX

    register("onnx", ONNX)


@hookimpl
def register_trees(register: Callable[..., None]) -> None:
    """Register the pick-and-place task with a policy."""
    register("pick_place_policy", TREES / "pick_place_policy.xml")

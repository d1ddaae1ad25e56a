"""The hook that this package declares."""

import dataclasses
from collections.abc import Callable
from typing import Any

from bt_manip import hookspec
from bt_manip.exceptions import BtManipError


def check_fault(name: str, cls: Any) -> None:
    """Check that a class can be registered as a fault.

    Raises:
        BtManipError: If it is no dataclass that derives from `Fault`, or a parameter has no
            default.
    """
    own = isinstance(cls, type) and "__dataclass_fields__" in vars(cls)
    if not own or not hasattr(cls, "begin"):
        raise BtManipError(f"fault '{name}' is no dataclass that derives from Fault: {cls!r}")
    missing = ", ".join(sorted(getattr(cls, "__abstractmethods__", ())))
    if missing:
        raise BtManipError(f"fault '{name}' is incomplete: it lacks {missing}")
    for field in dataclasses.fields(cls):
        if not isinstance(field.default, str | int | float):
            problem = f"the default of '{field.name}' is no number or text"
            raise BtManipError(f"fault '{name}': {problem}")


@hookspec("fault", check_fault)
def register_faults(register: Callable[[str, type], None]) -> None:
    """Register faults, which disturb runs that test how a tree copes with them.

    Args:
        register: ``register(name, cls)`` with a dataclass that derives from `bt_manip_stress.Fault`
            and whose parameters all have defaults.
    """

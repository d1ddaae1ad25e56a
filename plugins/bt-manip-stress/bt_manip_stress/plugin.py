"""What the package brings; everything expensive is imported when it is needed."""

import dataclasses
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from bt_manip import hookimpl, hookspec
from bt_manip.exceptions import BtManipError

if TYPE_CHECKING:
    from bt_manip.runner import Run
    from bt_manip_stress import FaultInjector


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


def fault(run: "Run", texts: Sequence[str], warn: Callable[[str], None]) -> "FaultInjector":
    """Inject a fault when a node starts (see: bt-manip list faults); may be given repeatedly."""
    from bt_manip_stress import FaultInjector, parse_fault

    faults = run.station.parts.of("faults")
    planned = [parse_fault(text, faults) for text in texts]
    for one in planned:
        one.nodes(run.tree)  # raises an error if there are none
    return FaultInjector(planned, faults, None, warn)


fault.metavar = '"NAME at=NODE KEY=VALUE ..."'  # type: ignore[attr-defined]


@hookimpl
def register_modifiers(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register the option ``--fault``."""
    register("fault", fault)


@hookimpl
def register_commands(register: Callable[..., None]) -> None:
    """Register ``bt-manip stress``."""
    register("stress", "bt_manip_stress.commands:stress")


@hookimpl(specname="register_faults")
def register_own_faults(register: Callable[[str, type], None]) -> None:
    """Register faults of objects, of the robot and of the tree."""
    from bt_manip_stress.faults import object_faults, robot_faults, tree_faults

    register("vanish", object_faults.Vanish)
    register("move", object_faults.Displace)
    register("knock", object_faults.Knock)
    register("slippery", object_faults.Slippery)
    register("heavy", object_faults.Heavy)
    register("stuck", object_faults.Stuck)
    register("obstacle", object_faults.Obstacle)
    register("container_vanishes", object_faults.ContainerVanishes)
    register("push", robot_faults.Push)
    register("stuck_joint", robot_faults.StuckJoint)
    register("stuck_finger", robot_faults.StuckFinger)
    register("torque_loss", robot_faults.TorqueLoss)
    register("sensor_noise", robot_faults.SensorNoise)
    register("sensor_delay", robot_faults.SensorDelay)
    register("sensor_nan", robot_faults.SensorNaN)
    register("exception", tree_faults.BehaviourException)
    register("tick_delay", tree_faults.TickDelay)


@hookimpl
def register_contracts(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register the checks of faults."""
    register("faults", _fault_checks)


def _fault_checks(*arguments: Any) -> Any:
    from bt_manip_stress.fault_contract import fault_checks

    return fault_checks(*arguments)

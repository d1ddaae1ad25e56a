"""What the package brings; everything expensive is imported when it is needed."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from bt_manip import hookimpl
from bt_manip_stress.hooks import register_faults as register_faults

if TYPE_CHECKING:
    from bt_manip.runner import Run
    from bt_manip_stress.faults import FaultInjector


def fault(run: "Run", texts: Sequence[str], warn: Callable[[str], None]) -> "FaultInjector":
    """Inject a fault when a node starts (see: bt-manip list faults); may be given repeatedly."""
    from bt_manip_stress.faults import FaultInjector, parse_fault

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
    from bt_manip_stress import faults

    register("vanish", faults.Vanish)
    register("move", faults.Displace)
    register("knock", faults.Knock)
    register("slippery", faults.Slippery)
    register("heavy", faults.Heavy)
    register("stuck", faults.Stuck)
    register("obstacle", faults.Obstacle)
    register("container_vanishes", faults.ContainerVanishes)
    register("push", faults.Push)
    register("stuck_joint", faults.StuckJoint)
    register("stuck_finger", faults.StuckFinger)
    register("torque_loss", faults.TorqueLoss)
    register("sensor_noise", faults.SensorNoise)
    register("sensor_delay", faults.SensorDelay)
    register("sensor_nan", faults.SensorNaN)
    register("exception", faults.BehaviourException)
    register("tick_delay", faults.TickDelay)


@hookimpl
def register_contracts(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register the checks of faults."""
    register("faults", _fault_checks)


def _fault_checks(*arguments: Any) -> Any:
    from bt_manip_stress.fault_contract import fault_checks

    return fault_checks(*arguments)

"""Hooks that this package declares and implements."""

from collections.abc import Callable
from typing import Any

from bt_manip import hookimpl, hookspec


@hookspec("action kind")
def register_actions(register: Callable[[str, Callable[[Any], Any]], None]) -> None:
    """Register kinds of actions, by which agents act in episodes and environments.

    Args:
        register: ``register(name, factory)``, where ``factory(episodes)`` returns a new
            `bt_manip_learn.agents.ActionKind` for a `bt_manip_learn.agents.Episodes`.
    """


@hookimpl(specname="register_actions")
def register_own_actions(register: Callable[[str, Callable[[Any], Any]], None]) -> None:
    """Register torques and targets of joints, displacements of the tool, and parts of the tree."""
    from bt_manip_learn import agents

    for make in (
        agents.JointTorques, agents.JointTargets, agents.CartesianDeltas, agents.SubtreeChoice,
    ):  # fmt: skip
        register(make.kind, make)


@hookimpl
def register_controllers(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register the controller whose feedback is part of the model."""
    from bt_manip_learn.native import NativePD

    register(NativePD.kind, NativePD)


@hookimpl
def register_grippers(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register the gripper whose feedback is part of the model."""
    from bt_manip_learn.native import NativeTwoFingerGripper

    register(NativeTwoFingerGripper.kind, NativeTwoFingerGripper)


def ray(make_worker: Callable[[], Any], address: str, workers: int) -> Any:
    """Run on a Ray cluster, HOST:PORT; without an address, on a local one."""
    from bt_manip_learn.ray_pool import RayPool

    return RayPool(make_worker, address, workers)


ray.metavar = "[ADDRESS]"  # type: ignore[attr-defined]


@hookimpl
def register_pools(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register clusters of Ray."""
    register("ray", ray)


@hookimpl
def register_commands(register: Callable[..., None]) -> None:
    """Register ``bt-manip demos``."""
    register("demos", "bt_manip_learn.commands:demos")


@hookimpl
def register_contracts(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register the checks of kinds of actions, and of the environments of trees."""
    register("environments", _environment_checks)


def _environment_checks(*arguments: Any) -> Any:
    from bt_manip_learn.environment_contract import environment_checks

    return environment_checks(*arguments)

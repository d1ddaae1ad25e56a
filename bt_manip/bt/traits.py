"""What a kind of leaf declares of itself, for the checks that are made before a tree runs."""

from collections.abc import Mapping, Set
from dataclasses import dataclass, field
from typing import Final

from bt_manip.bt.status import FAILURE, RUNNING, SKIPPED, SUCCESS, NodeStatus

FACTS: Final = {
    "open": "the gripper is closed here; open it before, as OpenGripper does",
    "at_object": "nothing has moved the tool to an object; do so before, as Reach does",
    "holding": "the gripper holds nothing here; grasp the object before, as Grasp does",
}
"""The facts of a robot, and what to do where one is needed and does not hold."""


@dataclass(frozen=True)
class Traits:
    """What a leaf can answer, what it commands, and which facts it needs and leaves.

    ``Traits(commands={"gripper"}, needs={"at_object"}, leaves={"open": False, "holding": True})``

    Facts are ``open`` (the gripper is), ``at_object`` (the tool is where the gripper can grasp an
    object) and ``holding`` (the gripper holds an object).

    Attributes:
        returns: The statuses that its tick can have.
        commands: What it commands while it runs: ``arm``, ``gripper``.
        needs: Facts about its robot without which it cannot do its work.
        leaves: Facts about its robot after its success; None where either can be. After a failure,
            and while it runs, either can be. Other facts stay as they were.
    """

    returns: Set[NodeStatus] = frozenset({SUCCESS, FAILURE, RUNNING})
    commands: Set[str] = frozenset()
    needs: Set[str] = frozenset()
    leaves: Mapping[str, bool | None] = field(default_factory=dict)


UNDECLARED: Final = Traits(returns=frozenset({SUCCESS, FAILURE, RUNNING, SKIPPED}))
SUCCEEDS: Final = Traits(returns=frozenset({SUCCESS}))
YES_OR_NO: Final = Traits(returns=frozenset({SUCCESS, FAILURE}))

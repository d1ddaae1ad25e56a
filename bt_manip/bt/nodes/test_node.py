"""TestNode: replaces another node in tests."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from py_trees.behaviour import Behaviour

from bt_manip.bt.blackboard import EMPTY
from bt_manip.bt.nodes.action import Action
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.port_types import INT, cast
from bt_manip.bt.script.evaluation import Environment, Value
from bt_manip.bt.script.parser import ParsedScript, parse_script
from bt_manip.bt.status import FAILURE, IDLE, SUCCESS, NodeStatus, Status
from bt_manip.exceptions import ScriptError, TreeError


@dataclass(frozen=True)
class TestNodeConfig:
    """The behaviour of a TestNode.

    Attributes:
        return_status: Its result.
        return_status_script: A script whose value is its result; it knows the statuses by name.
        async_delay: How long it is running before [ms].
        success_script: Runs when it succeeds.
        failure_script: Runs when it fails.
        post_script: Runs in both cases, and after any other result.
        complete_func: Returns its result, in Python.
    """

    __test__: ClassVar = False  # not a test case of pytest's

    return_status: NodeStatus = SUCCESS
    return_status_script: str = ""
    async_delay: int = 0
    success_script: str = ""
    failure_script: str = ""
    post_script: str = ""
    complete_func: Callable[[], NodeStatus] | None = None


class TestNode(Action):
    """Return a configured status, in place of another node, whose ports and children it takes.

    | tick | RUNNING until async_delay has passed; then the asked status, after its scripts |
    |------|--------------------------------------------------------------------------------|
    | halt | the delay starts anew                                                          |
    """

    __test__: ClassVar = False
    memory: ClassVar = ("_completed",)

    def __init__(
        self,
        name: str | None = None,
        *,
        config: TestNodeConfig,
        replaced: type[Node] | None = None,
        orphans: tuple[Behaviour, ...] = (),
        **ports: Any,
    ) -> None:
        if replaced is not None:
            self.ports = replaced.ports  # type: ignore[misc]
            self.registration = replaced.registration
        super().__init__(name, **ports)
        self.config = config
        self.orphans = orphans
        self._completed = False
        if not config.return_status_script:
            _check(config.return_status)
        self._scripts: dict[str, ParsedScript] = {
            key: parse_script(text)
            for key in ("return_status_script", "success_script", "failure_script", "post_script")
            if (text := getattr(config, key))
        }

    def initialise(self) -> None:
        """Start the delay."""
        self._completed = False
        if self.config.async_delay > 0:
            self.runtime.start_timer(self, self.config.async_delay / 1000)

    def update(self) -> Any:
        """Wait for the delay, then complete."""
        if self._completed or (self.config.async_delay <= 0 and self._node_status is IDLE):
            return self._complete()
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Cancel the delay."""
        self.runtime.cancel_timer(self)

    def on_timer(self) -> None:
        """End the delay."""
        self._completed = True
        self.runtime.wake_up = True

    def _complete(self) -> NodeStatus:
        enums = self.runtime.enums
        if self.config.complete_func is not None:
            status = self.config.complete_func()
        elif "return_status_script" in self._scripts:
            names = {**enums, **{status.name: int(status) for status in NodeStatus}}
            script = self._scripts["return_status_script"]
            status = _status(script.evaluate(Environment(self.scope, names)))
        else:
            status = self.config.return_status
        _check(status)
        if status is SUCCESS:
            self._run("success_script", enums)
        elif status is FAILURE:
            self._run("failure_script", enums)
            self.feedback_message = "a test asked for it"
        self._run("post_script", enums)
        return status

    def _run(self, name: str, enums: Mapping[str, int]) -> None:
        if name in self._scripts:
            self._scripts[name].evaluate(Environment(self.scope, enums))


def _status(value: Value) -> NodeStatus:
    content, type = value
    if content is EMPTY:
        raise ScriptError("return_status_script gave a value that was never written")
    try:
        return NodeStatus[content] if isinstance(content, str) else NodeStatus(cast(*value, INT))
    except (KeyError, ValueError):
        raise ScriptError(f"return_status_script gave {content!r}, which is no status") from None


def _check(status: NodeStatus) -> None:
    if status is IDLE:
        raise TreeError("a TestNode cannot return IDLE")

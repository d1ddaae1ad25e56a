"""Reading and writing the ports of a node: literals, defaults and blackboard entries."""

import contextlib
from collections.abc import Callable, Mapping
from typing import Any

from py_trees.behaviour import Behaviour

from bt_manip.bt.blackboard import EMPTY, Blackboard
from bt_manip.bt.literals import parse_integer
from bt_manip.bt.nodes.binding import bind
from bt_manip.bt.nodes.tree_node import TreeNode
from bt_manip.bt.port_types import STRING, PortType, cast, fit, type_of
from bt_manip.bt.ports import Port, is_pointer, pointed_key
from bt_manip.bt.runtime import Runtime
from bt_manip.exceptions import BlackboardError, BoundsError, PortError, shown
from bt_manip.parameters import MISSING


class PortAccess(TreeNode, Behaviour):
    """The part of a node that reads and writes its ports.

    Attributes:
        given: The value given for each port: a text as in a document, or a Python value.
    """

    _node_scope: Blackboard | None = None

    @property
    def runtime(self) -> Runtime:
        """The clock, timers and enumerations that all nodes of the tree share."""
        if self._node_runtime is None:
            self._bind_alone()
        assert self._node_runtime is not None
        return self._node_runtime

    @property
    def scope(self) -> Blackboard:
        """The blackboard scope of the node's ports and scripts."""
        if self._node_scope is None:
            self._bind_alone()
        assert self._node_scope is not None
        return self._node_scope

    def _bind_alone(self) -> None:
        """Bind the tree around this node to a runtime and a scope of its own: no `Tree` did."""
        top: Behaviour = self
        while top.parent is not None:
            top = top.parent
        bind(top, Runtime(), Blackboard())

    def _start_ports(self, given: dict[str, Any]) -> None:
        self.given = given
        self._readers: dict[str, Callable[[], Any]] = {}
        for name, value in given.items():
            self._check_value(self.ports[name], value)

    def _check_value(self, port: Port, value: Any) -> None:
        type = port.type
        if not type.strong:
            return
        try:
            if not isinstance(value, str):
                self.given[port.name] = fit(value, type)
            elif type.converter is not None and pointed_key(port.name, value) is None:
                type.converter(value)
        except Exception as error:  # a parser of a behaviour's own may raise anything
            raise PortError(f"port '{port.name}' of {self.name}: {error}") from None

    def port_text(self, name: str) -> str | None:
        """Return a port's text as in a document: the given one, else its default, else None."""
        value = self.given.get(name, MISSING)
        port = self.ports.get(name)
        if value is MISSING:
            if port is None or not port.default_text:
                return None
            return port.default_text if port.reads or is_pointer(port.default_text) else None
        if isinstance(value, str):
            return value
        write = port.type.format if port is not None and port.type.strong else None
        write = write or type_of(value).format or str
        return write(value)

    def read_port(self, name: str, type: PortType | None = None) -> Any:
        """Read a port's value.

        Args:
            name: The port.
            type: The type of the result, if not the port's own type.

        Raises:
            PortError: If nothing was given, if the entry is missing or was never written, or if
                the value does not become the type.
            BoundsError: If the value is outside the port's bounds.
        """
        if type is not None:
            return self._reader(name, type)()
        reader = self._readers.get(name)
        if reader is None:
            reader = self._readers[name] = self._checked(self.ports.get(name), self._reader(name))
        return reader()

    def key_of(self, name: str) -> str | None:
        """Return the key of the entry that a port reads; None if it has a value of its own."""
        given = self.given.get(name, self.ports[name].default)
        return pointed_key(name, given) if isinstance(given, str) else None

    def set_up_ports(self, infrastructure: Mapping[str, Any]) -> None:
        """Let ports depend on the arguments of ``setup``, as `Port.reader` says."""
        for name, port in self.ports.items():
            if type(port).reader is not Port.reader:
                with contextlib.suppress(PortError):  # nothing was given
                    fixed, read = self.key_of(name) is None, self._reader(name)
                    self._readers[name] = self._checked(
                        port, port.reader(read, fixed, infrastructure)
                    )

    @staticmethod
    def _checked(port: Port | None, read: Callable[[], Any]) -> Callable[[], Any]:
        """Return a reader that checks the bounds of a port, if it has any."""
        if port is None or not port.bounds:
            return read

        def checked() -> Any:
            value = read()
            try:
                port.check(value)
            except ValueError as problem:
                raise BoundsError(f"port '{port.name}' {problem}") from None
            return value

        return checked

    def _reader(self, name: str, wanted: PortType | None = None) -> Callable[[], Any]:
        port = self.ports.get(name)
        if port is None:
            raise self._port_error(name, "the node that this one replaces has no such port")
        type = wanted or port.type
        value = self.given.get(name, MISSING)
        if value is MISSING or not port.reads:
            if not port.reads and value is not MISSING:
                raise self._port_error(name, "it is an output: write-only")
            value = port.default
            if value is MISSING:
                raise self._port_error(name, f"nothing was given; expected {type.name}")
        if not isinstance(value, str):
            return lambda: list(value) if isinstance(value, list) else value
        key = pointed_key(name, value)
        if key is None:
            literal = self._parse(name, type, value)
            return lambda: list(literal) if isinstance(literal, list) else literal
        return lambda: self._read_entry(name, key, type)

    def _read_entry(self, name: str, key: str, type: PortType) -> Any:
        entry = self.scope.entry(key)
        if entry is None or entry.value is EMPTY:
            what = "does not exist" if entry is None else "was never written"
            raise self._port_error(name, f"the blackboard entry '{key}' {what}")
        value = entry.value
        if not type.strong or (entry.type is type and type.family != "integer"):
            return value  # a script may have left a number that is too large for its type
        if entry.type.family == "string" and type is not STRING:
            return self._parse(name, type, value)
        try:
            return cast(value, entry.type, type)
        except ValueError as error:
            raise self._port_error(name, f"entry '{key}': {error}") from None

    def _parse(self, name: str, type: PortType, text: str) -> Any:
        if not type.strong:
            return text
        try:
            if type.is_enum and type.python.__name__ != "NodeStatus":
                if text in self.runtime.enums:
                    return type.python(self.runtime.enums[text])
                if text.removeprefix("-").isdecimal():
                    return type.python(parse_integer(text))
            if type.parse is None:
                raise ValueError(f"a text does not become a {type.name}")
            return type.parse(text)
        except Exception as error:  # a parser of a behaviour's own may raise anything
            raise self._port_error(name, str(error)) from None

    def is_connected(self, name: str) -> bool:
        """Return whether something was given for a port, or its default points to an entry."""
        return self._output(name) is not None

    def _output(self, name: str) -> str | None:
        text = self.given.get(name, MISSING)
        if text is MISSING:
            port = self.ports.get(name)
            default = None if port is None else port.default
            text = default if isinstance(default, str) and is_pointer(default) else None
        return text if isinstance(text, str) else None

    def write_port(self, name: str, value: Any) -> None:
        """Write a port's value to the blackboard entry that it points to.

        Raises:
            PortError: If the port points to no entry.
            BlackboardError: If the entry does not take the value.
        """
        text = self._output(name)
        if text is None:
            raise self._port_error(name, "nothing was given to write to; expected {key}")
        key = pointed_key(name, text)
        if key is None:
            raise self._port_error(name, f"{shown(text)} is no entry to write to; expected {{key}}")
        type = self.ports[name].type
        try:
            if type.strong:
                value = fit(value, type)
            else:
                type = type_of(value)
        except (ValueError, TypeError) as error:
            raise self._port_error(name, str(error)) from None
        try:
            self.scope.write(key, value, type)
        except BlackboardError as error:
            raise BlackboardError(f"port '{name}' of {self.path or self.name}: {error}") from None

    def _port_error(self, name: str, text: str) -> PortError:
        return PortError(f"port '{name}' of {self.path or self.name}: {text}")

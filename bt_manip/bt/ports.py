"""Ports: the inputs and outputs of a node, declared as attributes of its class."""

import inspect
import keyword
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Self, overload

from bt_manip.bt.port_types import UNTYPED, PortType, fit, port_type
from bt_manip.exceptions import PortError, shown
from bt_manip.parameters import MISSING, Parameter

if TYPE_CHECKING:
    from bt_manip.bt.nodes.node import Node


class Port(Parameter):
    """A port of a node, used through one of `Input`, `Output` and `InOut`.

    Bounds hold for the values that the node reads.

    Args:
        doc: Its meaning, with the unit in brackets or as ``unit``.
        parse: For classes of your own: makes a value of a text.
        format: For classes of your own: makes such a text of a value.
        **declared: Unit and bounds, as of `bt_manip.parameters.Parameter`: ``above=0.0``.

    Attributes:
        name: Its name in trees; a trailing underscore of the attribute is dropped where the name
            is a Python keyword (``in_ = Input(int)`` declares the port ``in``).
        attribute: Its name in Python.
        type: The type of its values: ``str``, ``int``, ``float``, ``bool``, a list of these
            (``list[float]``), an ``Enum``, or any class; nothing for a port that takes all.
        default: Its value if nothing is given, `MISSING` if it must be given: a value, or a text as
            in a tree document, ``"{key}"`` and ``"{=}"`` included.
        direction: ``input``, ``output`` or ``inout``.

    Raises:
        PortError: If the default does not fit the type.
    """

    direction = ""
    reads = False
    writes = False

    def __init__(
        self,
        type: Any = UNTYPED,
        *,
        default: Any = MISSING,
        doc: str = "",
        name: str | None = None,
        parse: Callable[[str], Any] | None = None,
        format: Callable[[Any], str] | None = None,
        **declared: Any,
    ) -> None:
        kind = port_type(type, parse=parse, format=format)
        _check_default(default, kind)
        super().__init__(doc, default=default, size=0, type=kind, name=name or "", **declared)
        self.attribute = ""

    def __set_name__(self, owner: "type[Node]", name: str) -> None:
        """Take the attribute's name."""
        self.attribute = name
        if not self.name:
            bare = name[:-1]
            name = bare if name.endswith("_") and keyword.iskeyword(bare) else name
            object.__setattr__(self, "name", name)

    @overload
    def __get__(self, node: None, owner: "type[Node] | None" = None) -> Self: ...

    @overload
    def __get__(self, node: "Node", owner: "type[Node] | None" = None) -> Any: ...

    def __get__(self, node: "Node | None", owner: "type[Node] | None" = None) -> Any:
        """Read the port's value."""
        return self if node is None else node.read_port(self.name)

    def __set__(self, node: "Node", value: Any) -> None:
        """Write the port's value; a port that is connected to nothing drops it."""
        if not self.writes:
            raise AttributeError(f"port '{self.name}' of {node.name} is an input: read-only")
        if self.name in node.drawn:
            node._node_drawn = {**node._node_drawn, self.name: value}
        if node.is_connected(self.name):
            node.write_port(self.name, value)

    @property
    def mandatory(self) -> bool:
        """Whether a tree must give it: it is read and has no default."""
        return self.reads and self.default is MISSING

    @property
    def doc(self) -> str:
        """The meaning with unit and bounds, for the palette and the documentation."""
        text = self.described
        return f"{text.removesuffix('.')}, {self.bounds}." if self.bounds and text else text

    @property
    def form(self) -> str:
        """Direction, type and bounds, for users."""
        return ", ".join(filter(None, (self.direction, self.type.name, self.bounds)))

    def check(self, value: Any) -> None:
        """Check that a number, or each number of a list, is within the bounds; None is.

        Raises:
            ValueError: If it is not.
        """
        for number in value if isinstance(value, list) else [value]:
            if number is not None and not self.within(number):
                raise ValueError(f"must be {self.wanted_number}, got {shown(value)}")

    def reader(
        self, read: Callable[[], Any], fixed: bool, infrastructure: Mapping[str, Any]
    ) -> Callable[[], Any]:
        """Return the function that reads the port once the tree is set up, by default as before.

        `fixed` tells whether the tree gives a value, not an entry; `infrastructure` are the
        arguments of the nodes' ``setup``.
        """
        return read

    @property
    def default_text(self) -> str:
        """The default as it stands in a document, or an empty text."""
        if self.default is MISSING or self.default is None:
            return ""
        if isinstance(self.default, str):
            return self.default
        return self.type.format(self.default) if self.type.format else str(self.default)

    def __repr__(self) -> str:
        """Show the direction, the name and the type."""
        return f"{type(self).__name__}({self.name!r}, {self.type.name})"


class Input(Port):
    """A port that a node reads: a literal, or an entry of the blackboard."""

    direction = "input"
    reads = True


class Output(Port):
    """A port that a node writes: an entry of the blackboard."""

    direction = "output"
    writes = True


class InOut(Port):
    """A port that a node reads and writes."""

    direction = "inout"
    reads = True
    writes = True


def _check_default(default: Any, type: PortType) -> None:
    """Raise a `PortError` for an invalid default; None is valid for every type."""
    if default is MISSING or default is None or not type.strong:
        return
    if isinstance(default, str) and pointed_key("", default) is not None:
        return
    try:
        if isinstance(default, str):
            if type.parse is None:
                raise ValueError(f"a text does not become a {type.name}")
            type.parse(default)
        elif inspect.isclass(type.python) or type.parse is None or type.format is None:
            fit(default, type)
        else:  # a list, whose entries are checked by their texts
            type.parse(type.format(default))
    except Exception as error:  # a parser of a behaviour's own may raise anything
        raise PortError(
            f"{shown(default)} is no default of a port of type {type.name}: {error}"
        ) from None


def is_pointer(text: str) -> bool:
    """Return whether a text points to a blackboard entry: ``{key}``, spaces around it or not."""
    stripped = text.strip(" ")
    return len(stripped) >= 3 and stripped[0] == "{" and stripped[-1] == "}"


def pointed_key(port_name: str, text: str) -> str | None:
    """Return the key that a port's text points to, ``{=}`` being its name; None for a literal."""
    if text in ("{=}", "="):
        return port_name
    return text.strip(" ")[1:-1] if is_pointer(text) else None

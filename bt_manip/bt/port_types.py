"""Types of ports and of blackboard entries, and the safe casts between them."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from functools import partial
from typing import Any, Final, get_origin

from bt_manip.bt import literals
from bt_manip.bt.status import NodeStatus
from bt_manip.exceptions import shown

EXACT_INTEGERS: Final = (1 << 53) - 1
"""The largest integer up to which a double holds every integer exactly."""

MAX_ITEMS: Final = 100_000
"""Items of a list in a text that are read at most."""


@dataclass(frozen=True)
class PortType:
    """A type that a port or a blackboard entry can have.

    Attributes:
        name: Its name in a ``TreeNodesModel``, for Groot2: ``int``, ``std::string``.
        python: The Python type of its values.
        family: ``integer``, ``real``, ``string`` or ``object``: how values are kept and cast.
        parse: Reads a value from a text; None where texts cannot become such values.
        format: Writes a value as a text that `parse` reads.
        bits: Width, for integers.
        signed: Whether it has a sign, for integers.
        strong: False for the two types that take any value.
    """

    name: str
    python: Any
    family: str = field(default="object", compare=False)
    parse: Callable[[str], Any] | None = field(default=None, compare=False, repr=False)
    format: Callable[[Any], str] | None = field(default=None, compare=False, repr=False)
    bits: int = 32
    signed: bool = True
    strong: bool = field(default=True, compare=False)

    @property
    def is_enum(self) -> bool:
        """Whether values are members of an enumeration, that scripts may also name."""
        return isinstance(self.python, type) and issubclass(self.python, Enum)

    @property
    def converter(self) -> Callable[[str], Any] | None:
        """The function by which a text becomes a value of an entry; enumerations have none."""
        return None if self.is_enum else self.parse

    @property
    def form(self) -> str:
        """The texts that become such values, for messages: ``a number``."""
        if self.python is int:
            lower, upper = literals.integer_range(self.bits, signed=self.signed)
            return f"a whole number from {lower} to {upper}"
        return {float: "a number", bool: "true or false"}.get(self.python, self.name)

    def ignored_rest(self, text: str) -> str:
        """Return the text that is ignored after a number: ``e99`` of ``1e99`` as int."""
        if self.python is not int and self.python is not float:
            return ""
        return literals.rest_after_number(text, integer=self.python is int)


def _no_conversion(text: str) -> Any:
    raise ValueError(f"a text ({shown(text)}) cannot become a value of any type")


def _format_boolean(value: Any) -> str:
    return "true" if value else "false"


def _list_of(name: str, python: type, parse_item: Callable[[str], Any]) -> PortType:
    def parse(text: str) -> list[Any]:
        if text.startswith("json:"):
            items = literals.parse_json(text[5:])
            if not isinstance(items, list):
                raise ValueError(f"{shown(text)} is not a JSON list")
            convert: Callable[[Any], Any] = partial(_json_item, python=python)
        else:
            items, convert = literals.split_list(text), parse_item
        if len(items) > MAX_ITEMS:
            raise ValueError(f"a list of {len(items)} items; at most {MAX_ITEMS} are read")
        return [convert(item) for item in items]

    def write(items: Any) -> str:
        if python is bool:
            return ";".join(_format_boolean(item) for item in items)
        if python is str and any(";" in item or not item for item in items):
            return "json:" + literals.json.dumps(list(items), ensure_ascii=False)
        return ";".join(map(str, items))

    return PortType(name, list[python], parse=parse, format=write)  # type: ignore[valid-type]


def _json_item(item: Any, python: type) -> Any:
    if python is str and isinstance(item, str):
        return item
    if python is bool and isinstance(item, bool):
        return item
    if python is float and isinstance(item, bool):
        raise ValueError(f"{str(item).lower()} in a JSON list is not a number")
    if python in (int, float) and isinstance(item, int | float):  # a truth value is an integer too
        return python(item)
    raise ValueError(f"{shown(item)} in a JSON list is not of type {python.__name__}")


UNTYPED: Final = PortType("BT::AnyTypeAllowed", None, strong=False)
"""Takes the type of the first value that is written."""
ANY: Final = PortType("BT::Any", object, parse=_no_conversion, strong=False)
STRING: Final = PortType("std::string", str, "string", str, str)
INT: Final = PortType("int", int, "integer", literals.parse_integer, str)
INT64: Final = PortType(
    "int64_t", int, "integer", partial(literals.parse_integer, bits=64), str, bits=64
)
_parse_unsigned = partial(literals.parse_integer, signed=False)
UNSIGNED: Final = PortType("unsigned int", int, "integer", _parse_unsigned, str, signed=False)
BOOL: Final = PortType("bool", bool, "integer", literals.parse_boolean, _format_boolean, 1, False)
DOUBLE: Final = PortType("double", float, "real", literals.parse_real, lambda v: repr(float(v)))
STATUS: Final = PortType(
    "BT::NodeStatus", NodeStatus, parse=literals.parse_status, format=lambda status: status.name
)
INT_LIST: Final = _list_of("std::vector<int>", int, literals.parse_integer)
DOUBLE_LIST: Final = _list_of("std::vector<double>", float, literals.parse_real)
STRING_LIST: Final = _list_of("std::vector<std::string>", str, str)
BOOL_LIST: Final = _list_of("std::vector<bool>", bool, literals.parse_boolean)

_BY_PYTHON: Final = (
    (str, STRING),
    (bool, BOOL),
    (int, INT),
    (float, DOUBLE),
    (NodeStatus, STATUS),
    (list[int], INT_LIST),
    (list[float], DOUBLE_LIST),
    (list[str], STRING_LIST),
    (list[bool], BOOL_LIST),
    (object, ANY),
    (Any, UNTYPED),
    (None, UNTYPED),
)


_OF_SCALARS: Final = {float: DOUBLE, str: STRING, bool: BOOL, int: INT64}


def port_type(
    python: Any,
    *,
    parse: Callable[[str], Any] | None = None,
    format: Callable[[Any], str] | None = None,
) -> PortType:
    """Return the port type of a Python type.

    Args:
        python: ``str``, ``int``, ``float``, ``bool``, lists of these (``list[float]``), an
            ``Enum``, ``Any`` for a port of any type, any other class, or a `PortType`.
        parse: For other classes: reads a value from a text.
        format: For other classes: writes a value as such a text.
    """
    if isinstance(python, PortType):
        return python
    for known, found in _BY_PYTHON:
        if python is known or (python == known and not isinstance(python, type)):
            return found
    if isinstance(python, type) and issubclass(python, Enum):
        parse = parse or _enum_parser(python)
        return PortType(python.__name__, python, parse=parse, format=lambda member: member.name)
    name = getattr(python, "__name__", str(python))
    return PortType(name, python, parse=parse, format=format)


def _enum_parser(enum: type[Enum]) -> Callable[[str], Enum]:
    def parse(text: str) -> Enum:
        if text in enum.__members__:
            return enum[text]
        try:
            return enum(literals.parse_integer(text))
        except ValueError:
            names = ", ".join(enum.__members__)
            raise ValueError(f"{shown(text)} is not one of {names}") from None

    return parse


def type_of(value: Any) -> PortType:
    """Return the type of a Python value that came without one, as from a script or from Python."""
    kind = type(value)
    if kind in _OF_SCALARS:
        return _OF_SCALARS[kind]
    if kind is list and value:
        for item, found in ((bool, BOOL_LIST), (int, INT_LIST), (str, STRING_LIST)):
            if all(type(entry) is item for entry in value):
                return found
        if all(type(entry) in (int, float) for entry in value):
            return DOUBLE_LIST
    return port_type(kind)


def cast(value: Any, source: PortType, target: PortType) -> Any:
    """Cast a value safely to another type: nothing is lost, or it is an error.

    Raises:
        ValueError: If the types do not cast, or if this value does not fit.
    """
    wanted = target.family
    given = source.family
    if wanted == "integer":
        if given == "integer":
            return _to_integer(value, target)
        if given == "real":
            if target is BOOL:
                if value < 0:  # a truth value is unsigned to the engine
                    raise ValueError(f"{value} is negative: neither true nor false")
                return value != 0
            if value != value or value in (float("inf"), float("-inf")) or value != int(value):
                raise ValueError(f"{value} is not an integer")
            return _to_integer(int(value), target)
        if given == "string" and target is not BOOL:
            return literals.parse_integer(value, target.bits, signed=target.signed)
    elif wanted == "real":
        if given == "real":
            return value
        if given == "integer":
            if abs(value) > EXACT_INTEGERS:
                raise ValueError(f"{value} is too large for a double to hold exactly")
            return float(value)
        if given == "string":
            return literals.parse_real(value)
    elif wanted == "string":
        if given == "string":
            return value
        if given in ("integer", "real"):
            return literals.to_string(value)
    elif source == target or not target.strong:
        return value
    elif target.is_enum:
        if given in ("integer", "real"):
            return target.python(cast(value, source, INT))
        if given == "string":
            return target.python(literals.parse_integer(value, 64))
    elif isinstance(target.python, type) and isinstance(value, target.python):
        return value
    raise ValueError(f"a value of type {source.name} does not become {target.name}")


def fit(value: Any, type: PortType) -> Any:
    """Check that a Python value has a type; numbers are cast where nothing is lost.

    Raises:
        TypeError: If it is of another type.
        ValueError: If it is a number that the type does not hold.
    """
    python = type.python
    if inspect.isclass(python):
        if isinstance(value, python) and not (python is int and isinstance(value, bool)):
            return value
        if type.family in ("integer", "real"):
            value = value.item() if hasattr(value, "item") else value
            if isinstance(value, bool | int | float):
                return cast(value, type_of(value), type)
        raise TypeError(f"expected {type.name}, found {shown(value)}")
    if isinstance(value, str) and get_origin(python) is list:
        raise TypeError(f"expected {type.name}, found {shown(value)}")
    return list(value) if isinstance(value, list | tuple) else value


def _to_integer(value: int, target: PortType) -> int | bool:
    if target is BOOL:
        if value not in (0, 1):
            raise ValueError(f"{value} is no truth value: only 0 and 1 are")
        return bool(value)
    lower, upper = literals.integer_range(target.bits, signed=target.signed)
    if not lower <= value <= upper:
        raise ValueError(f"{value} is outside {lower} .. {upper}")
    return int(value)


def casts_safely(value: Any, source: PortType, target: PortType) -> bool:
    """Return whether a number can be written to an entry of another number type."""
    if source == target:
        return True
    if target is BOOL or target.family not in ("integer", "real"):
        return False
    if source is BOOL and not value and target.family == "integer":
        return False  # the engine compares with the lower limit as a truth value, which is true
    try:
        return bool(cast(value, source, target) == value)
    except ValueError:
        return False

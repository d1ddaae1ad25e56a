"""Addresses of devices: a host, and what is set on the robot."""

from dataclasses import dataclass, fields
from typing import Any, Literal, Self, get_args, get_origin, get_type_hints
from urllib.parse import parse_qsl

from bt_manip.exceptions import did_you_mean, shown

from .device import DeviceError

MAX_NUMBER = 1e3
"""Exclusive maximum of numbers in an address."""


@dataclass(frozen=True)
class DeviceAddress:
    """``HOST`` or ``HOST?key=value&...``; subclasses are dataclasses whose fields are the keys.

    A field has a default, and is a `float`, positive and below `MAX_NUMBER`, a `Literal` of texts,
    or a `str`.

    Attributes:
        host: Name or IP address of the controller.
    """

    host: str

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the address in a text.

        Raises:
            DeviceError: If it is none.
        """
        host, _, query = text.partition("?")
        if not host:
            raise DeviceError("no host in the address", text, "such as 172.16.0.2")
        types = get_type_hints(cls)
        names = [field.name for field in fields(cls)][1:]
        values: dict[str, Any] = dict(parse_qsl(query, keep_blank_values=True))
        for key, value in values.items():
            if key not in names:
                raise DeviceError(f"unknown key '{key}'{did_you_mean(key, names)}", text)
            if get_origin(types[key]) is Literal and value not in get_args(types[key]):
                raise DeviceError(f"{key} is one of {', '.join(get_args(types[key]))}", text)
            if types[key] is float:
                values[key] = _positive(key, value, text)
        return cls(host, **values)


def _positive(key: str, value: str, text: str) -> float:
    try:
        number = float(value)
    except ValueError:
        number = 0.0
    if not 0.0 < number < MAX_NUMBER:
        raise DeviceError(
            f"{key} is a number between 0 and {MAX_NUMBER:g}, not {shown(value)}", text
        )
    return number

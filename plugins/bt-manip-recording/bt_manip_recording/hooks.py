"""The hooks that this package declares."""

from collections.abc import Callable
from typing import Any

from bt_manip import hookspec


@hookspec("export format")
def register_export_formats(register: Callable[[str, Callable[..., None]], None]) -> None:
    """Register formats into which ``bt-manip export`` converts recordings.

    Args:
        register: ``register(name, write)``, where the name is the suffix of the files, and
            ``write(recording, path)`` converts a `bt_manip_recording.Recording`. Keyword-only
            arguments ``camera``, ``size``, ``fps`` and ``overlay`` are the options of these names.
    """


@hookspec("message source")
def register_message_sources(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register what adds messages of its own to MCAP recordings.

    Args:
        register: ``register(name, make)``: ``make(run, add)`` is called when a recording starts,
            and returns a function that is called after each tick. ``add(topic, message)`` adds a
            message of the present time: a dict, or a protobuf message.
    """

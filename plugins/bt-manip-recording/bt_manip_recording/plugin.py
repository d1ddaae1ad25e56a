"""What the package brings; everything expensive is imported when it is needed."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from bt_manip import hookimpl
from bt_manip_recording.hooks import register_export_formats as register_export_formats
from bt_manip_recording.hooks import register_message_sources as register_message_sources

FORMATS = ("csv", "parquet", "npz", "mcap")
"""Formats of ``bt-manip export``, which the functions ``write_NAME`` of the package write."""


@hookimpl
def register_recorders(register: Callable[[str, Callable[[Path | None], Any]], None]) -> None:
    """Register the recording of everything, and that of the joints."""
    from bt_manip_recording import McapRecorder, Trace

    register("mcap", McapRecorder)
    register("trace", Trace)


@hookimpl
def register_commands(register: Callable[..., None]) -> None:
    """Register ``bt-manip export``."""
    register("export", "bt_manip_recording.commands:export")


@hookimpl(specname="register_export_formats")
def register_own_export_formats(register: Callable[[str, Callable[..., None]], None]) -> None:
    """Register tables, traces, and recordings with an end."""
    for name in FORMATS:
        register(name, partial(_write, name))


def _write(name: str, recording: Any, path: Path) -> None:
    import bt_manip_recording

    getattr(bt_manip_recording, f"write_{name}")(recording, path)

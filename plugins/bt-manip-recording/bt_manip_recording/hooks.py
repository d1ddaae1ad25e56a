"""The hook that this package declares."""

from collections.abc import Callable

from bt_manip import hookspec


@hookspec("export format")
def register_export_formats(register: Callable[[str, Callable[..., None]], None]) -> None:
    """Register formats into which ``bt-manip export`` converts recordings.

    Args:
        register: ``register(name, write)``, where the name is the suffix of the files, and
            ``write(recording, path)`` converts a `bt_manip_recording.Recording`. Keyword-only
            arguments ``camera``, ``size``, ``fps`` and ``overlay`` are the options of these names.
    """

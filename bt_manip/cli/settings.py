"""Reading ``--set KEY=VALUE``."""

from collections.abc import Iterable

import click


def parse_settings(texts: Iterable[str]) -> dict[str, str]:
    """Split settings into keys and values.

    Args:
        texts: Each ``KEY=VALUE``; the value may hold further ``=``.

    Raises:
        click.UsageError: When one is not of that form, or a key is set twice.
    """
    settings: dict[str, str] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not equals or not key.strip():
            raise click.UsageError(f"--set wants KEY=VALUE, got '{text}'")
        if key.strip() in settings:
            raise click.UsageError(f"--set gives '{key.strip()}' twice")
        settings[key.strip()] = value
    return settings

"""The option ``--json`` of commands: one JSON object on standard output instead of the text."""

import functools
import json
import re
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import click

from bt_manip.cli.exit_codes import exit_code_of
from bt_manip.cli.options import Function
from bt_manip.exceptions import BtManipError

if TYPE_CHECKING:
    from bt_manip.bt import Problem

_PLACED = re.compile(r"([^\n]+?):(\d+)(?::(\d+))?: (?:(error|warning): )?(.+)")
"""A message with its place in front."""


def json_option(command: Function) -> Function:
    """Add ``--json`` to a command, which gets it as its argument ``as_json``.

    Bad input of a command with the option is printed as findings.
    """

    @click.option(
        "--json", "as_json", is_flag=True, help="Print one JSON object instead of the text."
    )
    @functools.wraps(command)
    def with_json(*args: Any, as_json: bool, **given: Any) -> Any:
        try:
            return command(*args, as_json=as_json, **given)
        except BtManipError as error:
            if not as_json:
                raise
            print_json(findings_of(error))
            return exit_code_of(error)

    return with_json  # type: ignore[return-value]


def print_json(findings: "Iterable[Problem]" = (), **content: Any) -> None:
    """Print the findings of a command, and its results by name, as one JSON object.

    Args:
        findings: The findings.
        **content: The results, in types of JSON.
    """
    whole = {"findings": [one.plain() for one in dict.fromkeys(findings)], **content}
    click.echo(json.dumps(whole, indent=1, allow_nan=False))


def findings_of(
    error: BtManipError | Iterable[str], file: str = "", code: str = ""
) -> "list[Problem]":
    """Return the findings of an error, or of messages.

    Args:
        error: An error that may list several, or messages, with their places in front.
        file: The file of messages without a place.
        code: The code of the findings of messages.
    """
    from bt_manip.bt import Place, Problem

    if isinstance(error, BtManipError):
        lines = str(error).splitlines()
        whole = lines if all(map(_PLACED.match, lines)) else [str(error)]
        error = getattr(error, "problems", ()) or whole
    found = []
    for one in error:
        if isinstance(one, str) and (placed := _PLACED.fullmatch(one)):
            path, line, column, severity, text = placed.groups()
            place = Place(path, int(line), int(column or 0))
            one = Problem(place, text, severity or "error", code)
        elif isinstance(one, str):
            one = Problem(Place(file, 0, 0), one.removeprefix(f"{file}: "), code=code)
        found.append(one)
    return found

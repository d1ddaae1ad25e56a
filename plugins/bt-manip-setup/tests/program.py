"""The program, run inside the test's own process."""

import sys
from importlib.metadata import entry_points
from typing import NamedTuple

import pytest


class Outcome(NamedTuple):
    """What a command came to."""

    code: int
    out: str
    err: str


def run_program(*arguments: object) -> int:
    """Run a command; return its exit code."""
    (command,) = entry_points(group="console_scripts", name="bt-manip")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["bt-manip", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            sys.exit(command.load()())
    code = ended.value.code
    return code if isinstance(code, int) else 0

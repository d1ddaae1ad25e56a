"""Exit codes of all commands."""

from collections.abc import Mapping

from bt_manip.exceptions import BtManipError

SUCCESS = 0

FAILED = 1
"""A cycle or an episode failed, or a check found problems."""

BAD_INPUT = 2
"""Bad input or usage; nothing was simulated."""

FAULT = 3
"""An internal fault: a plugin raised, the physics diverged, a file could not be written."""

INTERRUPTED = 130
"""After Ctrl-C: 128 + SIGINT, as in shells."""

COMMON: Mapping[int, str] = {BAD_INPUT: "bad input", INTERRUPTED: "interrupted"}
"""Meanings that most commands share."""


def exit_code_of(error: BtManipError) -> int:
    """Return the exit code of an error: bad input, except where a process died."""
    from bt_manip.evaluation import WorkerDiedError

    return FAULT if isinstance(error, WorkerDiedError) else BAD_INPUT


def exit_code_help(meanings: Mapping[int, str], *, common: Mapping[int, str] = COMMON) -> str:
    """Return the sentence about exit codes in the help of a command.

    Args:
        meanings: The meanings of a command's exit codes.
        common: Meanings of exit codes that it shares with other commands.
    """
    meanings = {**common, **meanings}
    return f"Exit codes: {', '.join(f'{code} {meanings[code]}' for code in sorted(meanings))}."

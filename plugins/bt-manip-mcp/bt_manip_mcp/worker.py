"""The warm process in which commands run, one after the other.

Requests are lines of JSON on standard input, answers lines on what was standard output; whatever
commands, behaviours and plugins print goes elsewhere. Processes that a command starts import this
module, too, as multiprocessing does with the main one, so that they are guarded as this one is.
"""

import contextlib
import io
import json
import os
from typing import Any, Final

VARIABLE: Final = "BT_MANIP_MCP_GUARD"
"""The variable with the arguments of the guard, as JSON."""

MAX_ERROR: Final = 4_000
"""Characters of the error stream that an answer keeps."""


def main() -> None:
    """Answer requests until standard input ends."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    requests = os.fdopen(os.dup(0), encoding="utf-8")
    null = os.open(os.devnull, os.O_RDONLY)
    os.dup2(null, 0)
    os.dup2(2, 1)
    if os.environ.get("MUJOCO_GL") != "disable":
        from bt_manip.viewer import use_offscreen_opengl

        use_offscreen_opengl()
        with contextlib.suppress(ImportError, AttributeError):  # drawing will tell what is missing
            import mujoco.gl_context  # noqa: F401  # searches libraries of the system
    _guard()
    first = _answer(["list", "trees", "--json"])  # imports what runs need
    print(json.dumps(first), file=answers, flush=True)
    for line in requests:
        print(json.dumps(_answer(json.loads(line))), file=answers, flush=True)


def _guard() -> None:
    from bt_manip_mcp.file_guard import guard_files

    guard_files(**json.loads(os.environ[VARIABLE]))


def _answer(arguments: list[str]) -> dict[str, Any]:
    """Run a command, and return the object that it prints, with its exit code.

    A command that prints none has failed: its error is the only finding.
    """
    from bt_manip.cli import Interrupt, findings_of, run_app

    printed, errors = io.StringIO(), io.StringIO()
    interrupt = Interrupt()
    interrupt.install()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(errors):
        code = run_app(interrupt, arguments)
    found = last_object(printed.getvalue())
    if found is None or (code == 3 and not found["findings"]):
        text = errors.getvalue()[-MAX_ERROR:].strip() or "the command printed no result"
        found = (found or {}) | {"findings": [one.plain() for one in findings_of([text])]}
    return {"exit_code": interrupt.exit_code or code, **found}


def last_object(text: str) -> dict[str, Any] | None:
    """Return the object with findings that a command has printed last; None without one."""
    found: dict[str, Any] = {}
    with contextlib.suppress(ValueError):
        found, _ = json.JSONDecoder().raw_decode(text, f"\n{text}".rindex("\n{\n"))
    return found if "findings" in found else None


if __name__ == "__main__":
    main()
elif __name__ == "__mp_main__" and VARIABLE in os.environ:
    _guard()

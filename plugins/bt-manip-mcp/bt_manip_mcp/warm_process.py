"""A warm process that runs commands, seen from the server that starts and stops it."""

import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import platformdirs

from bt_manip.cli import findings_of
from bt_manip_mcp.limits import Limits
from bt_manip_mcp.worker import VARIABLE

START_TIME: Final = 120.0
"""Wall time in which the process starts [s]."""

GRACE: Final = 5.0
"""Wall time after a limit in which a command may print what it has so far [s]."""


class WarmProcess:
    """Runs commands in another process, which is started when it is first needed.

    Args:
        limits: The limits of the server.
        draws: Whether it has OpenGL, as pictures need; others start faster.
    """

    def __init__(self, limits: Limits, *, draws: bool = False) -> None:
        self._limits, self._draws = limits, draws
        self._process: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()
        self._temporary = tempfile.TemporaryDirectory(prefix="bt-manip-mcp-")
        self._rest = b""

    @property
    def folder(self) -> Path:
        """A folder for files of a request, which the client does not see."""
        return Path(self._temporary.name)

    def run(self, arguments: list[str]) -> dict[str, Any]:
        """Run a command.

        Args:
            arguments: Its words.

        Returns:
            The object that it prints with ``--json``, its ``exit_code``, which is None if it was
            killed, and ``stopped``, a text, if it reached the limit of wall time.
        """
        with self._lock:
            process = self._started()
            assert process.stdin is not None
            with suppress(BrokenPipeError):
                process.stdin.write(json.dumps(arguments).encode() + b"\n")
                process.stdin.flush()
            answer = self._receive(self._limits.seconds)
            if answer is not None:
                return answer
            stopped: dict[str, Any] = {}
            if process.poll() is None:
                text = f"after {self._limits.seconds:g} s, the limit of this server"
                stopped = {"stopped": text}
                process.send_signal(signal.SIGINT)
                answer = self._receive(GRACE)
            if answer is None:
                self._kill()
                text = "killed" if stopped else f"its process died (exit {process.returncode})"
                findings = [finding.plain() for finding in findings_of([text])]
                answer = {"exit_code": None, "findings": findings}
            return answer | stopped

    def close(self) -> None:
        """End the process, and those that it started."""
        self._kill()
        self._temporary.cleanup()

    def _started(self) -> subprocess.Popen[bytes]:
        if self._process is not None and self._process.poll() is None:
            return self._process
        limits = self._limits
        given = {
            "folder": str(limits.folder),
            "readable": [str(path) for path in limits.plugins],
            "writable": [
                self._temporary.name,
                os.environ.get("BT_MANIP_CACHE") or str(platformdirs.user_cache_path("bt_manip")),
            ],
            "allow_python": limits.allow_python,
        }
        environment = {
            **os.environ,
            VARIABLE: json.dumps(given),
            "TMPDIR": self._temporary.name,
            "BT_MANIP_BLOCK": ",".join(limits.blocked),
            "BT_MANIP_PLUGINS_DIR": os.pathsep.join(map(str, limits.plugins)),
        }
        if not self._draws:
            environment["MUJOCO_GL"] = "disable"
        elif environment.get("MUJOCO_GL") == "disable":
            del environment["MUJOCO_GL"]
        self._rest = b""
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "bt_manip_mcp.worker"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=limits.folder, env=environment,
            start_new_session=True,
        )  # fmt: skip
        if self._receive(START_TIME) is None:
            self._kill()
            raise RuntimeError("the process of the commands did not start")
        return self._process

    def _receive(self, limit: float) -> dict[str, Any] | None:
        """Return the next answer; None if there is none in this time [s], or the process died."""
        assert self._process is not None and self._process.stdout is not None
        file, end = self._process.stdout.fileno(), time.monotonic() + limit
        while b"\n" not in self._rest:
            ready, _, _ = select.select([file], [], [], max(0.0, end - time.monotonic()))
            data = os.read(file, 1 << 16) if ready else b""
            if not data:
                if ready:
                    self._process.wait()
                return None
            self._rest += data
        line, _, self._rest = self._rest.partition(b"\n")
        answer = json.loads(line)
        assert isinstance(answer, dict)
        return answer

    def _kill(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()

"""Start ``python -m bt_manip`` from a process that has imported the packages it needs.

Imports take most of the time of a short command. A server imports once and forks itself for each
command, whose process has its own memory, files and signals like any other. A command with
variables of its own that Python or OpenGL read at the start is started as usual.
"""

import ctypes
import gc
import importlib
import json
import os
import runpy
import signal
import socket
import subprocess
import sys
from collections.abc import Mapping
from inspect import signature
from typing import Any

_READ_AT_START = ("PYTHON", "MUJOCO", "PYOPENGL", "DISPLAY", "LD_", "LC_", "LANG")
_IMPORTED = (
    "bt_manip.cli.run_job", "bt_manip.cli.replay", "bt_manip.cli.page_session", "bt_manip.builtin",
    "bt_manip.behaviours", "bt_manip.runner", "bt_manip.recording", "bt_manip.viewer.page",
    "bt_manip.control", "bt_manip.evaluation", "bt_manip.faults", "bt_manip.groot",
)  # fmt: skip
_PIPES = ("p2cread", "p2cwrite", "c2pread", "c2pwrite", "errread", "errwrite")
_PR_SET_CHILD_SUBREAPER = 36  # of <linux/prctl.h>


class WarmPopen(subprocess.Popen):
    """A `Popen` that forks ``[sys.executable, "-m", "bt_manip", ...]`` from the server."""

    _server: socket.socket | None = None

    def _execute_child(self, *args: Any) -> None:
        given = _BIND(self, *args).arguments
        words = given["args"]
        words = [] if isinstance(words, str | bytes | os.PathLike) else [*map(os.fsdecode, words)]
        start = [sys.executable, *(["-u"] if "-u" in words[1:2] else []), "-m", "bt_manip"]
        env = os.environ if given["env"] is None else given["env"]
        others = given["preexec_fn"] or given["pass_fds"] or given["shell"]
        if others or words[: len(start)] != start or _at_start(env) != _at_start(os.environ):
            super()._execute_child(*args)  # type: ignore[misc]
            return
        pipes = [given[name] for name in _PIPES]
        files = [own if fd == -1 else fd for own, fd in enumerate((pipes[0], pipes[3], pipes[5]))]
        cwd = os.fsdecode(given["cwd"] or os.getcwd())
        request = json.dumps([words[len(start) :], cwd, dict(env)]).encode()
        server = self._serving()
        socket.send_fds(server, [len(request).to_bytes(4, "big")], files)
        server.sendall(request)
        self.pid = int.from_bytes(server.recv(4, socket.MSG_WAITALL), "big")
        self._child_created = True
        self._close_pipe_fds(*pipes)  # type: ignore[attr-defined]

    @classmethod
    def _serving(cls) -> socket.socket:
        """Return the connection to the server, which is started at the first use."""
        if cls._server is None:
            # The parent of a command is a process of the server that ends: it becomes our child.
            ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
            cls._server, theirs = socket.socketpair()
            with theirs:
                fd = theirs.fileno()
                cls._process = subprocess.Popen([sys.executable, __file__, str(fd)], pass_fds=[fd])
        return cls._server


_BIND = signature(subprocess.Popen._execute_child).bind  # type: ignore[attr-defined]


def _at_start(env: Mapping[str, str]) -> dict[str, str]:
    return {name: value for name, value in env.items() if name.startswith(_READ_AT_START)}


def _serve(server: socket.socket) -> list[str]:
    """Fork for each request; return, in the process of a command, its words."""
    while True:
        data, files, _, _ = socket.recv_fds(server, 4, 3, socket.MSG_WAITALL)
        if not data:
            os._exit(0)
        request = server.recv(int.from_bytes(data, "big"), socket.MSG_WAITALL)
        theirs, ours = os.pipe()
        between = os.fork()
        if between:
            os.waitpid(between, 0)
            server.sendall(os.read(theirs, 4))
            for fd in (*files, theirs, ours):
                os.close(fd)
            continue
        if command := os.fork():
            os.write(ours, command.to_bytes(4, "big"))
            os._exit(0)
        server.close()
        for own, fd in enumerate(files):
            os.dup2(fd, own)
        for fd in (*files, theirs, ours):
            os.close(fd)
        words, cwd, env = json.loads(request)
        os.environ.clear()
        os.environ.update(env)
        os.chdir(cwd)
        return words


def _main() -> None:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    for name in _IMPORTED:
        importlib.import_module(name)
    importlib.import_module("bt_manip.plugins").load_plugins()  # imports those of others
    gc.freeze()
    words = _serve(socket.socket(fileno=int(sys.argv[1])))
    gc.unfreeze()
    sys.argv[1:], sys.path[0] = words, os.getcwd()
    sys.stdin = open(0, closefd=False)
    sys.stdout = open(1, "w", 1, closefd=False)
    sys.stderr = open(2, "w", 1, errors="backslashreplace", closefd=False)
    runpy.run_module("bt_manip", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    _main()

"""A guard of a process: which files its Python code may open, whatever names them.

Trees include trees, scenes name models, and models name meshes; so paths are refused where files
are opened. Installed code may be read, and files of the folder. The guard is against what stands in
documents; it does not confine code, which is why code of the folder is not loaded.
"""

import errno
import os
import sys
import sysconfig
from collections.abc import Collection
from typing import Any, Final

CODE: Final = (".py", ".pyc", ".pyo", ".so", ".pyd", ".pth")
_WRITING: Final = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_CHANGES: Final = {
    "os.remove": 1, "os.rmdir": 1, "os.mkdir": 1, "os.truncate": 1, "os.chmod": 1, "os.chown": 1,
    "os.utime": 1, "os.rename": 2, "os.link": 2, "os.symlink": 2,
}  # fmt: skip
"""Audit events that change files: how many of their arguments are paths."""
_NETWORK: Final = ("socket.bind", "socket.connect", "socket.sendto")
_DEVICES: Final = ("/dev/null", "/dev/urandom", "/dev/shm")


def guard_files(
    folder: str, readable: Collection[str], writable: Collection[str], *, allow_python: bool
) -> None:
    """Refuse, from now on, files outside of a folder, code in it, and the network.

    Args:
        folder: May be read and written.
        readable: Further folders and files that may be read, besides installed code.
        writable: Further folders that may be read and written.
        allow_python: Whether code of the folder may be loaded.
    """
    installed = [sys.prefix, sys.base_prefix, sys.exec_prefix, *filter(None, sys.path)]
    for packages in {sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}:
        installed += [entry.path for entry in os.scandir(packages) if entry.is_symlink()]
    code = {os.path.realpath(path) for path in (*installed, *readable)} - {os.sep}
    owned = {os.path.realpath(path) for path in (folder, *writable, *_DEVICES)}

    def check(path: Any, *, writes: bool) -> None:
        if not isinstance(path, str | bytes | os.PathLike):
            return  # a descriptor, which was opened before
        real = os.path.realpath(os.fsdecode(path))
        if _within(real, code) and not writes:
            return
        if not _within(real, owned):
            _refuse("outside of the folder of this server", real)
        if real.endswith(CODE) and not allow_python:
            _refuse("code, which this server does not load", real)

    def audit(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open":
            path, mode, flags = arguments
            writes = set(mode) & set("wax+") if mode else (flags or 0) & _WRITING
            check(path, writes=bool(writes))
        elif event in ("os.listdir", "os.scandir"):
            check(arguments[0] or ".", writes=False)
        elif event in _CHANGES:
            for path in arguments[: _CHANGES[event]]:
                check(path, writes=True)
        elif event in _NETWORK and isinstance(arguments[-1], tuple):
            _refuse("the network, which this server does not use", str(arguments[-1][0]))

    sys.addaudithook(audit)


def _within(path: str, folders: Collection[str]) -> bool:
    return any(path == one or path.startswith(one + os.sep) for one in folders)


def _refuse(reason: str, what: str) -> None:
    raise PermissionError(errno.EACCES, f"refused: {reason}", what)

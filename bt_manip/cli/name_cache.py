"""Names for the shell's completion, kept in a file so that a second TAB imports nothing heavy."""

import contextlib
import hashlib
import importlib.util
import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from bt_manip.exceptions import BtManipError
from bt_manip.files import cache_root, replace_text
from bt_manip.plugins import PluginSelection, installed


class NameCache:
    """Answers of completion, valid while the files of bt-manip and of all plugins are the same.

    A file that cannot be read or written is no error: the answers are computed again.
    """

    def __init__(self, choice: PluginSelection) -> None:
        stamp = repr([sys.version, sorted(choice.blocked), *_stamps(_files(choice))])
        self._stamp = hashlib.sha256(stamp.encode()).hexdigest()
        folders = repr([str(folder.absolute()) for folder in choice.folders])
        name = hashlib.sha256(f"{sys.prefix}{sorted(choice.blocked)}{folders}".encode())
        self._path = cache_root() / "completion" / f"{name.hexdigest()[:16]}.json"

    def get(self, key: str, compute: Callable[[], tuple[list[str], Iterable[Path]]]) -> list[str]:
        """Return an answer, or else compute it, with further files on which it depends."""
        answers = self._read()
        found = answers.get(key)
        if found is not None and found["stamps"] == _stamps(map(Path, found["files"])):
            return list(found["names"])
        names, depends = compute()
        files = sorted(map(str, depends))
        answers[key] = {"names": names, "files": files, "stamps": _stamps(map(Path, files))}
        self._write(answers)
        return names

    def _read(self) -> dict[str, Any]:
        try:
            found = json.loads(self._path.read_bytes())
            if found["stamp"] == self._stamp:
                return dict(found["answers"])
        except (OSError, ValueError, KeyError, TypeError):
            pass
        return {}

    def _write(self, answers: Mapping[str, Any]) -> None:
        with contextlib.suppress(OSError):
            self._path.parent.mkdir(parents=True, exist_ok=True)
            replace_text(self._path, json.dumps({"stamp": self._stamp, "answers": answers}))


def _files(choice: PluginSelection) -> Iterator[Path]:
    """Yield the files of bt-manip, of all plugins, and what installed them."""
    modules = {"bt_manip"}
    for point in installed():
        modules.add(point.module.partition(".")[0])
        if point.folder is not None:
            yield point.folder
    for module in sorted(modules):
        with contextlib.suppress(ImportError, ValueError):
            spec = importlib.util.find_spec(module)
            if spec is not None and spec.submodule_search_locations:
                yield from _below(Path(next(iter(spec.submodule_search_locations))))
            elif spec is not None and spec.origin:
                yield Path(spec.origin)
    checkout = Path(__file__).resolve().parents[2]
    for name in ("trees", "scenes", "models"):  # of an installation that can be edited
        yield from _below(checkout / name)
    for folder in choice.folders:
        if not folder.is_dir():
            raise BtManipError(f"no folder '{folder}' to take plugins from")
        yield from sorted(folder.glob("*.py"))


def _below(folder: Path) -> Iterator[Path]:
    """Yield a folder's files without compiled modules, and its folders."""
    for parent, folders, files in os.walk(folder):
        folders[:] = sorted(set(folders) - {"__pycache__"})
        yield Path(parent)
        yield from (Path(parent, name) for name in sorted(files))


def _stamps(files: Iterable[Path]) -> list[list[Any]]:
    """Return path, time and size of each file; a missing one has only its path."""
    found: list[list[Any]] = []
    for path in files:
        try:
            status = os.stat(path)
            found.append([str(path), status.st_mtime_ns, status.st_size])
        except OSError:
            found.append([str(path)])
    return found

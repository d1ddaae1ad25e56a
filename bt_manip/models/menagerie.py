"""Models of MuJoCo Menagerie, from the package ``mujoco-menagerie``.

That package caches models, verifies checksums, and reads ``MENAGERIE_ROOT`` (a folder of models to
use instead), ``MENAGERIE_BASE_URL`` and ``MENAGERIE_CACHE_DIR``.
"""

import tarfile
import threading
from collections.abc import Iterator
from pathlib import Path

from bt_manip.exceptions import did_you_mean
from bt_manip.models.downloads import ModelCache, Progress, check_downloads, terminal_progress
from bt_manip.models.errors import ModelError

CONNECTION_TIMEOUT = 2.0
"""Timeout for the first response of the server [s]."""

REMEDY = (
    "set MENAGERIE_ROOT to a folder with the models of MuJoCo Menagerie to do without a network"
)


def menagerie_file(name: str, progress: Progress = terminal_progress) -> Path:
    """Return the file of a model, downloaded on first use.

    ``franka_emika_panda/hand`` is another model of the folder ``franka_emika_panda``.

    Raises:
        ModelError: If there is no such model, the server does not answer, or the download is
            damaged.
    """
    import mujoco_menagerie as menagerie

    robot_name, _, entry = name.strip("/").partition("/")
    try:
        robot = menagerie.get(robot_name)
    except menagerie.UnknownRobotError:
        near = did_you_mean(robot_name, menagerie.names())
        raise ModelError(f"no model '{robot_name}' in MuJoCo Menagerie{near}") from None
    try:
        file = robot.entry(entry or robot.default_model).file
        if not is_cached(robot_name):
            check_downloads(f"menagerie:{name}")
            _require_server(name)
        path = robot.path(progress=progress) / file
    except menagerie.UnknownEntryPointError:
        near = did_you_mean(entry, robot.entry_names)
        raise ModelError(f"'{robot_name}' of Menagerie has no model '{entry}'{near}") from None
    except (menagerie.MenagerieError, tarfile.TarError, OSError, EOFError) as error:
        raise ModelError(f"menagerie:{name} was not fetched: {error}") from None
    if not path.is_file():
        raise ModelError(f"menagerie:{name}: there is no file {path}")
    return path


def _require_server(name: str) -> None:
    """Raise a `ModelError` without a server; the package itself would retry for many seconds."""
    import urllib.error
    import urllib.request

    import mujoco_menagerie as menagerie

    cache = menagerie.Cache()
    if cache.root is not None or not cache.base_url.startswith("http"):
        return
    request = urllib.request.Request(cache.base_url, method="HEAD")
    problems = [f"no answer within {CONNECTION_TIMEOUT:g} s"]

    def connect() -> None:
        try:
            urllib.request.urlopen(request, timeout=CONNECTION_TIMEOUT).close()
        except urllib.error.HTTPError:
            pass  # an answer, too
        except (OSError, ValueError) as error:
            problems[0] = str(getattr(error, "reason", error))
            return
        problems.clear()

    # In a thread, because resolving the host's name may take longer than the timeout.
    thread = threading.Thread(target=connect, daemon=True)
    thread.start()
    thread.join(CONNECTION_TIMEOUT)
    if problems:
        raise ModelError(
            f"menagerie:{name} was not fetched: {cache.base_url}: {problems[0]}; {REMEDY}"
        )


def is_cached(name: str) -> bool:
    """Return whether a model is available without a network."""
    import mujoco_menagerie as menagerie

    cache, robot = menagerie.Cache(), menagerie.get(name)
    if cache.root is not None:
        return (cache.root / name).is_dir()
    return cache.is_cached(robot)


class MenagerieCache(ModelCache):
    """Models of Menagerie on this machine."""

    kinds = ("menagerie",)

    def addresses(self, everything: bool) -> Iterator[str]:
        """Yield the addresses of the models on this machine, or of all with ``" *"``."""
        import mujoco_menagerie as menagerie

        for name in menagerie.names():
            here = is_cached(name)
            if here or everything:
                yield f"menagerie:{name}" + ("" if here else " *")

    def fetch(self, address: str) -> tuple[str, Path]:
        """Download a model if it is not cached."""
        name = address.partition(":")[2]
        return f"menagerie:{name}", menagerie_file(name)

    def remove(self, address: str) -> list[Path]:
        """Delete a model; raise a `ModelError` if there is no such model."""
        import shutil

        import mujoco_menagerie as menagerie

        name, known = address.partition(":")[2], menagerie.names()
        if name not in known:
            raise ModelError(f"no model '{name}' in MuJoCo Menagerie{did_you_mean(name, known)}")
        path = menagerie.Cache().model_path(menagerie.get(name))
        if not path.is_dir():
            return []
        shutil.rmtree(path)
        return [path]

"""Virtual environments beside ``.venv``, for packages that cannot be in it."""

import hashlib
import subprocess
import venv
from collections.abc import Sequence
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
INSTALL = ("sh", "tools/install_into.sh")


class OwnEnvironment:
    """An environment in a folder of the repository, made anew when its list of packages changes."""

    def __init__(self, folder: str, *lists: Path) -> None:
        """Keep the folder's name, and the files that list packages."""
        self._folder = REPOSITORY / folder
        self._wanted = hashlib.sha256(b"".join(file.read_bytes() for file in lists)).hexdigest()

    @property
    def python(self) -> str:
        """Its interpreter."""
        return str(self._folder / "bin" / "python")

    def install(self, *steps: Sequence[str]) -> str:
        """Install by arguments of pip, unless that is done; return why not, empty if it could."""
        ready = self._folder / ".ready"
        if ready.is_file() and ready.read_text() == self._wanted:
            return ""
        venv.create(self._folder, clear=True, with_pip=True)
        for words in steps:
            done = subprocess.run(
                [*INSTALL, self._folder, *words], cwd=REPOSITORY, capture_output=True, text=True
            )
            if done.returncode:
                errors = [line for line in done.stderr.splitlines() if line.startswith("ERROR")]
                return (errors or done.stderr.splitlines() or ["pip failed"])[-1]
        ready.write_text(self._wanted)
        return ""

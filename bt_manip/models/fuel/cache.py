"""The folder where models of Fuel lie, which Gazebo uses too."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import mkdtemp

from bt_manip.models.errors import ModelError
from bt_manip.models.fuel.address import FuelAddress, fuel_server
from bt_manip.models.model_config import MODEL_CONFIG

FUEL_CACHE_VARIABLE = "GZ_FUEL_CACHE_PATH"
"""Gazebo's own environment variable for the place of the cache."""

_STAGE = ".bt_manip_"


class FuelCache:
    """Models by server, owner, name and version, each there whole or not at all.

    Laid out as Gazebo lays it out: ``SERVER/OWNER/models/NAME/VERSION/``, in lower case.
    """

    def __init__(self, root: Path | None = None) -> None:
        """Use a folder; by default the one that Gazebo uses."""
        given = os.environ.get(FUEL_CACHE_VARIABLE, "")
        self.root = root or (Path(given) if given else Path.home() / ".gz" / "fuel")

    def folder(self, address: FuelAddress) -> Path:
        """Return where all versions of a model lie, whether there are any or not."""
        host = address.host.replace(":", "_")
        return self.root / host / address.owner.lower() / "models" / address.name.lower()

    def versions(self, address: FuelAddress) -> list[int]:
        """List the versions of a model that are here, in order."""
        return _versions(self.folder(address))

    def find(self, address: FuelAddress) -> tuple[FuelAddress, Path] | None:
        """Find a model, the newest of those that are here unless the address has a version."""
        versions = self.versions(address)
        version = address.version or (versions[-1] if versions else None)
        if version is None or version not in versions:
            return None
        return address.at(version), self.folder(address) / str(version)

    def models(self) -> Iterator[FuelAddress]:
        """Go through all that is here, version by version."""
        for folder in sorted(self.root.glob("*/*/models/*")):
            host, owner, _, name = folder.relative_to(self.root).parts
            server = f"https://{host}"
            if FuelAddress(fuel_server(), "", "").host.replace(":", "_") == host:
                server = fuel_server()
            for version in _versions(folder):
                yield FuelAddress(server, owner, name, version)

    def remove(self, address: FuelAddress) -> list[Path]:
        """Delete a version, or all versions of a model; give what was deleted."""
        folder = self.folder(address)
        versions = [address.version] if address.version else self.versions(address)
        gone = [folder / str(v) for v in versions if (folder / str(v)).is_dir()]
        for path in gone:
            shutil.rmtree(path)
        self._tidy(folder)
        return gone

    @contextmanager
    def staging(self) -> Iterator[Path]:
        """Return a folder to make a model in, on the cache's own disk; it goes in the end.

        Raises:
            ModelError: When the cache cannot be written.
        """
        missing = [p for p in (self.root, *self.root.parents) if not p.exists()]
        try:
            self.root.mkdir(parents=True, exist_ok=True)
            stage = Path(mkdtemp(prefix=_STAGE, dir=self.root))
        except OSError as error:
            raise ModelError(f"cache {self.root}: cannot be written: {error.strerror}") from None
        try:
            yield stage
        finally:
            shutil.rmtree(stage, ignore_errors=True)
            for path in missing:
                with suppress(OSError):  # something is in it now
                    path.rmdir()

    def publish(self, folder: Path, address: FuelAddress) -> Path:
        """Move a whole model to its place, at once.

        Two processes may come with the same model: the first one's stays.

        Args:
            folder: The model, inside of what `staging` gave.
            address: Its address, with the version.

        Raises:
            ModelError: When the place cannot be written.
        """
        target = self.folder(address) / str(address.version)
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            if target.is_dir() and not (target / MODEL_CONFIG).is_file():
                target.rename(folder.with_name("left_behind"))  # by someone who was cut off
            with suppress(FileExistsError):
                _rename(folder, target)
        except OSError as error:
            self._tidy(target.parent)
            raise ModelError(f"cache {target}: cannot be written: {error.strerror}") from None
        return target

    def _tidy(self, folder: Path) -> None:
        """Remove folders that hold nothing, upwards."""
        while folder != self.root and folder.is_relative_to(self.root):
            try:
                folder.rmdir()
            except OSError:
                return
            folder = folder.parent


def _rename(folder: Path, target: Path) -> None:
    """Rename a folder; one that is there already is no error of the disk's."""
    try:
        folder.rename(target)
    except OSError:
        if (target / MODEL_CONFIG).is_file():
            raise FileExistsError(target) from None
        raise


def _versions(folder: Path) -> list[int]:
    with suppress(OSError):
        names = [path.name for path in folder.iterdir() if (path / MODEL_CONFIG).is_file()]
        return sorted(int(name) for name in names if name.isascii() and name.isdigit())
    return []

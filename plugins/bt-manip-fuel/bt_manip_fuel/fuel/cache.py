"""Cache of models of Fuel, shared with Gazebo."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from bt_manip.models import ModelError
from bt_manip_fuel.fuel.address import FuelAddress, fuel_server
from bt_manip_fuel.model_config import MODEL_CONFIG

FUEL_CACHE_VARIABLE = "GZ_FUEL_CACHE_PATH"
"""Gazebo's environment variable with the cache folder."""


class FuelCache:
    """Gazebo's cache of models by server, owner, name and version, written atomically.

    The layout is ``SERVER/OWNER/models/NAME/VERSION/``, in lower case.
    """

    def __init__(self) -> None:
        given = os.environ.get(FUEL_CACHE_VARIABLE, "")
        self.root = Path(given) if given else Path.home() / ".gz" / "fuel"

    def folder(self, address: FuelAddress) -> Path:
        """Return the folder of all versions of a model, which may not exist."""
        host = address.host.replace(":", "_")
        return self.root / host / address.owner.lower() / "models" / address.name.lower()

    def find(self, address: FuelAddress) -> tuple[FuelAddress, Path] | None:
        """Return a cached model: the version of the address, or the newest cached one."""
        versions = _versions(self.folder(address))
        version = address.version or (versions[-1] if versions else None)
        if version is None or version not in versions:
            return None
        return address.at(version), self.folder(address) / str(version)

    def models(self) -> Iterator[FuelAddress]:
        """Yield all cached models, version by version."""
        for folder in sorted(self.root.glob("*/*/models/*")):
            host, owner, _, name = folder.relative_to(self.root).parts
            server = f"https://{host}"
            if FuelAddress(fuel_server(), "", "").host.replace(":", "_") == host:
                server = fuel_server()
            for version in _versions(folder):
                yield FuelAddress(server, owner, name, version)

    def remove(self, address: FuelAddress) -> list[Path]:
        """Delete a version or all versions of a model; return the deleted paths."""
        folder = self.folder(address)
        versions = [address.version] if address.version else _versions(folder)
        gone = [folder / str(v) for v in versions if (folder / str(v)).is_dir()]
        for path in gone:
            shutil.rmtree(path)
        return gone

    @contextmanager
    def staging(self) -> Iterator[Path]:
        """Create a temporary folder on the disk of the cache, deleted at the end.

        Raises:
            ModelError: If the cache cannot be written; paths in errors are relative to the folder.
        """
        try:
            self.root.mkdir(parents=True, exist_ok=True)
            folder = TemporaryDirectory(prefix=".bt_manip_", dir=self.root)
        except OSError as error:
            raise ModelError(f"cache {self.root}: cannot be written: {error.strerror}") from None
        with folder as name:
            try:
                yield Path(name)
            except ModelError as error:
                raise ModelError(str(error).replace(name + os.sep, "")) from None

    def publish(self, folder: Path, address: FuelAddress) -> Path:
        """Move a complete model into the cache in one step.

        If two processes publish the same model, the first one's remains.

        Args:
            folder: The model, in a folder of `staging`.
            address: Its address, with the version.

        Raises:
            ModelError: If the cache cannot be written.
        """
        target = self.folder(address) / str(address.version)
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            if target.is_dir() and not (target / MODEL_CONFIG).is_file():
                shutil.rmtree(target)  # incomplete, from an interrupted process
            folder.rename(target)
        except OSError as error:
            if not (target / MODEL_CONFIG).is_file():
                raise ModelError(f"cache {target}: cannot be written: {error.strerror}") from None
        return target


def _versions(folder: Path) -> list[int]:
    """Return the versions in a model's folder, in order."""
    with suppress(OSError):
        names = [path.name for path in folder.iterdir() if (path / MODEL_CONFIG).is_file()]
        return sorted(int(name) for name in names if name.isascii() and name.isdigit())
    return []

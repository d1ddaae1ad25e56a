"""Client of a Fuel server."""

import json
import os
from pathlib import Path
from typing import Any

from bt_manip.models import ModelError, Progress, check_downloads, terminal_progress
from bt_manip_fuel.fuel.address import FuelAddress
from bt_manip_fuel.fuel.archive import ZipLimits, unpack
from bt_manip_fuel.fuel.cache import FuelCache
from bt_manip_fuel.fuel.transfer import Transfer
from bt_manip_fuel.model_config import sdf_file

TOKEN_VARIABLE = "BT_MANIP_FUEL_TOKEN"
"""Environment variable with the token for private models."""

_ZIPS = (
    "application/zip",
    "application/x-zip-compressed",
    "application/octet-stream",
    "binary/octet-stream",
)
_MAX_ARCHIVE = 2**30  # [bytes] maximum size of a zip
_MAX_TEXT = 1 << 16  # [bytes] maximum size of details or a referral


class FuelClient:
    """Provides models from the cache, or else from the server.

    A model is downloaded, unpacked and checked beside the cache, and moved into it atomically. So
    it is complete or absent, even if two processes fetch it at the same time.

    Args:
        cache: Cache of models; default: Gazebo's.
        token: Token for private models; default: from the environment.
        limits: Limits of a zip.
        progress: Called with the progress of a download.
    """

    def __init__(
        self,
        cache: FuelCache | None = None,
        *,
        token: str | None = None,
        limits: ZipLimits | None = None,
        progress: Progress = terminal_progress,
    ) -> None:
        self.cache = cache or FuelCache()
        self._token = os.environ.get(TOKEN_VARIABLE, "") if token is None else token
        self._limits = limits or ZipLimits()
        self._progress = progress

    def find(self, address: FuelAddress) -> tuple[FuelAddress, Path]:
        """Return a model, from the cache if it has the requested version (or any).

        Returns:
            The address with the version, and the folder.

        Raises:
            ModelError: If it is not cached and cannot be fetched.
        """
        return self.cache.find(address) or self.fetch(address)

    def fetch(self, address: FuelAddress) -> tuple[FuelAddress, Path]:
        """Download the requested version, or the newest one, unless it is in the cache.

        Raises:
            ModelError: If it cannot be fetched.
        """
        if address.version is None and self.cache.versions(address):
            check_downloads(str(address))
            newest = self.details(address).get("version")
            if isinstance(newest, int) and (known := self.cache.find(address.at(newest))):
                return known
        elif known := self.cache.find(address):
            return known
        check_downloads(str(address))
        with self.cache.staging() as stage:
            try:
                version = self._download(address, stage / "model.zip")
                folder = stage / "model"
                folder.mkdir()
                unpack(stage / "model.zip", folder, self._limits)
                sdf_file(folder)
            except ModelError as error:
                inside = str(stage / "model")
                text = str(error).replace(inside + os.sep, "").replace(inside, "the zip")
                raise ModelError(f"{address} was not fetched: {text}") from None
            except OSError as error:
                raise ModelError(f"{address} was not fetched: {error}") from None
            found = address.at(version)
            return found, self.cache.publish(folder, found)

    def details(self, address: FuelAddress) -> dict[str, Any]:
        """Request the details of a model: ``version``, ``license_name``, ``description``, ...

        Raises:
            ModelError: If the server has none.
        """
        transfer = Transfer(address.server, self._token)
        with transfer.get(address.url) as response:
            text = transfer.text(response, _MAX_TEXT)
        try:
            details = json.loads(text)
        except (ValueError, RecursionError):
            details = None
        if not isinstance(details, dict):
            raise ModelError(f"{address.url}: the answer is not the details of a model")
        return details

    def _download(self, address: FuelAddress, path: Path) -> int:
        """Download the zip, possibly by a referral; return its version."""
        transfer = Transfer(address.server, self._token)
        with transfer.get(address.zip_url) as response:
            version = _version(address, response.headers.get("X-Ign-Resource-Version"))
            kind = _kind(response)
            if kind in _ZIPS:
                transfer.save(response, path, _MAX_ARCHIVE, address.name, self._progress)
                return version
            if kind != "text/plain":
                raise ModelError(f"{response.url}: expected a zip, got '{kind}'")
            referral = transfer.text(response, _MAX_TEXT)
        if not referral or not referral.isprintable() or " " in referral:
            raise ModelError(f"{address.zip_url}: refers to {ascii(referral[:80])}, no address")
        with transfer.get(referral) as response:
            if _kind(response) not in _ZIPS:
                raise ModelError(f"{referral}: expected a zip, got '{_kind(response)}'")
            transfer.save(response, path, _MAX_ARCHIVE, address.name, self._progress)
        return version


def _kind(response: Any) -> str:
    return response.headers.get("Content-Type", "").partition(";")[0].strip().lower()


def _version(address: FuelAddress, header: str | None) -> int:
    """Read the version from the response; without one, it is the requested version."""
    if header is None:
        return address.version or 1
    if not header.isascii() or not header.isdigit() or not 0 < int(header) < 10**9:
        raise ModelError(f"the server sent the version {ascii(header)}, which is none")
    if address.version is not None and int(header) != address.version:
        raise ModelError(f"the server sent version {header} for version {address.version}")
    return int(header)

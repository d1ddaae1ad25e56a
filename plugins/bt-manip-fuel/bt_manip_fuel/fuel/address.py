"""Addresses of Gazebo Fuel: ``fuel:owner/name``, ``fuel:owner/name/3``, and whole URLs."""

import os
import unicodedata
from dataclasses import dataclass, replace
from urllib.parse import quote, unquote, urlsplit

from bt_manip.models import ModelError

URL_VARIABLE = "BT_MANIP_FUEL_URL"
"""Environment variable with the address of another server."""
GAZEBO = "https://fuel.gazebosim.org"
API = "1.0"
LOOPBACK = ("localhost", "127.0.0.1", "::1")

_FORM = "OWNER/NAME or OWNER/NAME/VERSION"


@dataclass(frozen=True)
class FuelAddress:
    """A model on a Fuel server.

    Attributes:
        server: The server without a path, such as ``https://fuel.gazebosim.org``.
        owner: User or organisation.
        name: Name of the model, which may have spaces.
        version: Version; None for the newest.
    """

    server: str
    owner: str
    name: str
    version: int | None = None

    @property
    def host(self) -> str:
        """Host name of the server, with its port if given."""
        return urlsplit(self.server).netloc.lower()

    @property
    def zip_url(self) -> str:
        """URL of the model's archive, or of a redirect to it."""
        owner, name, version = quote(self.owner), quote(self.name), self.version or "tip"
        return f"{self.server}/{API}/{owner}/models/{name}/{version}/{name}.zip?link=true"

    def at(self, version: int) -> "FuelAddress":
        """Return the address of one version."""
        return replace(self, version=version)

    def __str__(self) -> str:
        """Return the short form if the server is the default one."""
        version = "" if self.version is None else f"/{self.version}"
        if self.server == fuel_server():
            return f"fuel:{self.owner}/{self.name}{version}"
        return f"{self.server}/{self.owner}/models/{self.name}{version}"


def fuel_server() -> str:
    """Return the server of ``fuel:`` addresses.

    Raises:
        ModelError: If the environment variable is invalid.
    """
    url = os.environ.get(URL_VARIABLE, "") or GAZEBO
    parts = urlsplit(url)
    if parts.scheme not in ("http", "https") or not parts.hostname:
        raise ModelError(f"{URL_VARIABLE}: expected https://HOST[:PORT], got '{url}'")
    if parts.path.strip("/") not in ("", API):
        raise ModelError(f"{URL_VARIABLE}: expected no path but /{API}, got '{url}'")
    return f"{parts.scheme}://{parts.netloc}"


def fuel_address(text: str) -> FuelAddress:
    """Parse an address: ``fuel:owner/name[/version]`` or the URL of a model.

    Raises:
        ModelError: If it is invalid.
    """
    if text.startswith("fuel:"):
        return _made(text, fuel_server(), text.removeprefix("fuel:").strip("/").split("/"))
    parts = urlsplit(text)
    if parts.scheme not in ("http", "https") or not parts.hostname:
        raise ModelError(f"'{text}' is no Fuel address")
    if parts.scheme == "http" and parts.hostname not in LOOPBACK:
        raise ModelError(f"'{text}': models are downloaded over https:// only")
    path = parts.path.strip("/").split("/")
    if path[0] == API:
        path = path[1:]
    if len(path) not in (3, 4) or path[1] != "models":
        raise ModelError(
            f"'{text}' is not the address of a model; one reads "
            f"{GAZEBO}/OWNER/models/NAME or {GAZEBO}/{API}/OWNER/models/NAME/VERSION"
        )
    return _made(text, f"{parts.scheme}://{parts.netloc}", [path[0], *path[2:]])


def _made(text: str, server: str, parts: list[str]) -> FuelAddress:
    if len(parts) not in (2, 3):
        raise ModelError(f"'{text}': expected {_FORM}")
    owner, name = (_component(text, unquote(part)) for part in parts[:2])
    version = None
    if len(parts) == 3 and parts[2] != "tip":
        if not parts[2].isascii() or not parts[2].isdigit() or int(parts[2]) < 1:
            raise ModelError(f"'{text}': a version is 1, 2, ... or tip, got '{parts[2]}'")
        version = int(parts[2])
    return FuelAddress(server, owner, name, version)


def _component(text: str, part: str) -> str:
    """Check that a part of an address is a valid folder name."""
    odd = any(unicodedata.category(c)[0] == "C" for c in part)
    if not part.strip() or part != part.strip() or part[0] == "." or odd or set(part) & set("/\\:"):
        raise ModelError(f"'{text}': '{part}' is no owner or name; expected {_FORM}")
    return part

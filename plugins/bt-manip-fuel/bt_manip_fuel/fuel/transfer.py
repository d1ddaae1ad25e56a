"""Downloads of zips from untrusted servers."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urljoin, urlsplit

import requests

from bt_manip.models import ModelError, Progress
from bt_manip_fuel.fuel.address import FuelAddress

MAX_REDIRECTS = 5
MAX_ZIP = 2**30  # [bytes]
_MAX_TEXT = 1 << 16  # [bytes] of an address in a text
_HTTP_TIMEOUT = (10.0, 30.0)  # [s] for the connection, and between two chunks
_REDIRECTS = (301, 302, 303, 307, 308)
_ZIPS = (
    "application/zip",
    "application/x-zip-compressed",
    "application/octet-stream",
    "binary/octet-stream",
)
_HINTS = {
    401: ": a private model, which wants a token",
    403: ": a private model, which wants a token",
    404: ": there is no such model",
}
_CHUNK = 1 << 18


@contextmanager
def open_zip(address: FuelAddress, token: str) -> Iterator[tuple[requests.Response, str]]:
    """Request the zip of a model.

    Redirects, and texts with the address of the zip, are followed here, a limited number of times:
    the package ``requests`` would pass the token on, and follow redirects from https to http.

    Args:
        address: The model.
        token: Private token, sent to its server only.

    Yields:
        The response, and the version that the server states; empty if it states none.

    Raises:
        ModelError: If there is no such zip, or a redirect is not allowed.
    """
    url, version, seen = address.zip_url, "", set[str]()
    allowed = ("https",) if urlsplit(url).scheme == "https" else ("https", "http")
    try:
        with requests.Session() as session:
            while True:
                _check_redirect(url, allowed, seen)
                # Without compression, which would not bound the size of the content.
                headers = {"Accept-Encoding": "identity", "User-Agent": "bt-manip"}
                parts = urlsplit(url)
                if token and f"{parts.scheme}://{parts.netloc}" == address.server:
                    headers["Private-token"] = token
                with session.get(
                    url, headers=headers, stream=True, allow_redirects=False, timeout=_HTTP_TIMEOUT
                ) as response:
                    version = version or response.headers.get("X-Ign-Resource-Version", "")
                    if response.status_code in _REDIRECTS:
                        url = urljoin(url, response.headers.get("Location", ""))
                        continue
                    _check_status(url, response)
                    kind = response.headers.get("Content-Type", "").partition(";")[0].strip()
                    if kind.lower() in _ZIPS:
                        yield response, version
                        return
                    if kind.lower() != "text/plain":
                        raise ModelError(f"{url}: expected a zip, got '{kind}'")
                    url = _referral(url, response)
    except requests.exceptions.SSLError as error:
        raise ModelError(f"{url}: the server's certificate is not trusted: {error}") from None
    except requests.RequestException as error:
        raise ModelError(f"{url}: no connection to the server: {error}") from None


def _check_redirect(url: str, allowed: tuple[str, ...], seen: set[str]) -> None:
    """Reject other schemes, cycles, and too many redirects."""
    if urlsplit(url).scheme not in allowed:
        raise ModelError(f"the server leads to '{url}', which is not {' or '.join(allowed)}")
    if url in seen:
        raise ModelError(f"the server leads in a circle, to '{url}' again")
    if len(seen) > MAX_REDIRECTS:
        raise ModelError(f"the server redirects more than {MAX_REDIRECTS} times, now to '{url}'")
    seen.add(url)


def _check_status(url: str, response: requests.Response) -> None:
    status = response.status_code
    encoding = response.headers.get("Content-Encoding", "identity").lower()
    if encoding != "identity":  # the unpacked size would not be bounded
        raise ModelError(f"{url}: the answer is packed as '{encoding}', which was not asked for")
    if status != 200:
        hint = _HINTS.get(status, "")
        raise ModelError(f"{url}: the server answered {status} {response.reason}{hint}")


def _referral(url: str, response: requests.Response) -> str:
    """Read the address in a short text."""
    data = b""
    for chunk in response.iter_content(_CHUNK):
        data += chunk
        if len(data) > _MAX_TEXT:
            raise ModelError(f"{url}: an answer of more than {_MAX_TEXT} bytes")
    text = data.decode("utf-8", "replace").strip()
    if not text or not text.isascii() or not text.isprintable() or " " in text:
        raise ModelError(f"{url}: refers to {ascii(text[:80])}, no address")
    return text


def save(response: requests.Response, path: Path, name: str, progress: Progress) -> None:
    """Write a response to a file, and tell the progress of a model's download.

    Raises:
        ModelError: If it is cut off, or longer than announced or allowed.
    """
    announced = response.headers.get("Content-Length", "")
    total = int(announced) if announced.isascii() and announced.isdigit() else 0
    done = 0
    with path.open("xb") as file:
        for chunk in response.iter_content(_CHUNK):
            done += len(chunk)
            if max(done, total) > MAX_ZIP:
                raise ModelError(f"{response.url}: more than {MAX_ZIP} bytes")
            file.write(chunk)
            progress(name, done, total)
    if total and done != total:
        raise ModelError(f"{response.url}: cut off after {done} of {total} bytes")

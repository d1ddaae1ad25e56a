"""HTTP transfers from untrusted servers."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urljoin, urlsplit

import requests

from bt_manip.models import ModelError, Progress

MAX_REDIRECTS = 5
_HTTP_TIMEOUT = (10.0, 30.0)  # [s] for the connection, and between two chunks
_REDIRECTS = (301, 302, 303, 307, 308)
_CHUNK = 1 << 18


class Transfer:
    """The requests for one model, with a limited number of redirects and without repetition.

    Redirects are not left to the package ``requests``, which would pass the token on, and follow
    redirects from https to http.

    Args:
        origin: Scheme, host and port of the requested server.
        token: Private token, sent to this server only.
    """

    def __init__(self, origin: str, token: str = "") -> None:
        self._origin = origin
        self._token = token
        self._seen: set[str] = set()
        self._secure = urlsplit(origin).scheme == "https"

    @contextmanager
    def get(self, url: str) -> Iterator[requests.Response]:
        """Get an address, following redirects.

        Raises:
            ModelError: If the response is not 200, or a redirect is not allowed.
        """
        with requests.Session() as session:
            try:
                while True:
                    self._check(url)
                    with session.get(
                        url, headers=self._headers(url), stream=True, allow_redirects=False,
                        timeout=_HTTP_TIMEOUT,
                    ) as response:  # fmt: skip
                        if response.status_code not in _REDIRECTS:
                            self._check_status(url, response)
                            yield response
                            return
                        url = urljoin(url, response.headers.get("Location", ""))
            except requests.RequestException as error:
                raise ModelError(f"{url}: {_reason(error)}") from None

    def text(self, response: requests.Response, most: int) -> str:
        """Read a short text.

        Raises:
            ModelError: If it is longer, or not text.
        """
        data = b""
        for chunk in response.iter_content(_CHUNK):
            data += chunk
            if len(data) > most:
                raise ModelError(f"{response.url}: an answer of more than {most} bytes")
        try:
            return data.decode("utf-8").strip()
        except UnicodeDecodeError:
            raise ModelError(f"{response.url}: the answer is not text") from None

    def save(
        self, response: requests.Response, path: Path, most: int, name: str, progress: Progress
    ) -> None:
        """Write a response to a file.

        Raises:
            ModelError: If it is cut off, or longer than announced or allowed.
        """
        announced = response.headers.get("Content-Length", "")
        total = int(announced) if announced.isascii() and announced.isdigit() else 0
        if total > most:
            raise ModelError(f"{response.url}: {total} bytes, more than {most}")
        done = 0
        with path.open("xb") as file:
            for chunk in response.iter_content(_CHUNK):
                done += len(chunk)
                if done > most:
                    raise ModelError(f"{response.url}: more than {most} bytes")
                file.write(chunk)
                progress(name, done, total)
        if total and done != total:
            raise ModelError(f"{response.url}: cut off after {done} of {total} bytes")

    def _check(self, url: str) -> None:
        """Reject other schemes, cycles, and too many redirects."""
        scheme = urlsplit(url).scheme
        allowed = ("https",) if self._secure else ("https", "http")
        if scheme not in allowed:
            raise ModelError(f"the server leads to '{url}', which is not {' or '.join(allowed)}")
        if url in self._seen:
            raise ModelError(f"the server leads in a circle, to '{url}' again")
        if len(self._seen) > MAX_REDIRECTS:
            raise ModelError(
                f"the server redirects more than {MAX_REDIRECTS} times, now to '{url}'"
            )
        self._seen.add(url)

    def _headers(self, url: str) -> dict[str, str]:
        # Without compression, which would not bound the size of the content.
        headers = {"Accept-Encoding": "identity", "User-Agent": "bt-manip"}
        parts = urlsplit(url)
        if self._token and f"{parts.scheme}://{parts.netloc}" == self._origin:
            headers["Private-token"] = self._token
        return headers

    def _check_status(self, url: str, response: requests.Response) -> None:
        status = response.status_code
        encoding = response.headers.get("Content-Encoding", "identity").lower()
        if encoding != "identity":  # the unpacked size would not be bounded
            raise ModelError(
                f"{url}: the answer is packed as '{encoding}', which was not asked for"
            )
        if status == 200:
            return
        hint = {
            401: ": a private model, which wants a token",
            403: ": a private model, which wants a token",
            404: ": there is no such model",
        }.get(status, "")
        raise ModelError(f"{url}: the server answered {status} {response.reason}{hint}")


def _reason(error: requests.RequestException) -> str:
    if isinstance(error, requests.exceptions.SSLError):
        return f"the server's certificate is not trusted: {error}"
    if isinstance(error, requests.Timeout):
        return "the server does not answer"
    if isinstance(error, requests.exceptions.ChunkedEncodingError):
        return f"the connection was cut: {error}"
    if isinstance(error, requests.ConnectionError):
        return f"no connection to the server: {error}"
    return str(error)

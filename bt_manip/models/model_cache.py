"""Models that a source keeps on this machine."""

from collections.abc import Iterable
from pathlib import Path


class ModelCache:
    """Models that a source keeps on this machine, for the commands of ``bt-manip models``.

    Attributes:
        kinds: Kinds of addresses whose models it keeps: ``("fuel", "https")``.
    """

    kinds: tuple[str, ...] = ()

    def addresses(self, everything: bool) -> Iterable[str]:
        """Return the addresses of the models that need no network.

        Args:
            everything: Also those that would be downloaded, if they are known, ending in ``" *"``.
        """
        raise NotImplementedError

    def fetch(self, address: str) -> tuple[str, Path]:
        """Download a model, or a newer version of it; return its exact address and its path.

        Raises:
            ModelError: When it cannot be fetched.
        """
        raise NotImplementedError

    def remove(self, address: str) -> list[Path]:
        """Delete a model; return the deleted paths.

        Raises:
            ModelError: When there is no such model.
        """
        raise NotImplementedError

    def clear(self) -> list[Path]:
        """Delete all models; return the deleted paths."""
        return [path for address in list(self.addresses(False)) for path in self.remove(address)]

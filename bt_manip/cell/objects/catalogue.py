"""The objects that can be made: registered ones by name, all others by address."""

from collections.abc import Callable
from functools import partial
from typing import Any

from bt_manip.cell.objects.model_object import ModelObject
from bt_manip.models import MjcfModel, Progress, is_address, load_model, terminal_progress
from bt_manip.registry import Registry


class Catalogue:
    """Finds what makes an object, wherever an object is named.

    A model that was fetched and converted once is kept, so that the next one of it is only made.
    """

    def __init__(
        self,
        registered: Registry[Callable[..., Any]],
        progress: Progress = terminal_progress,
    ) -> None:
        """Know the registered objects.

        Args:
            registered: Factories by name.
            progress: Told how far a download is.
        """
        self._registered = registered
        self._progress = progress
        self._loaded: dict[str, MjcfModel] = {}

    def get(self, name: str) -> Callable[..., Any]:
        """Give what makes an object; a model is fetched and read now.

        Args:
            name: A registered name, or an address.

        Raises:
            UnknownPartError: When nothing is registered by the name; it offers the nearest names.
            ModelError: When the address leads to no model.
        """
        if not is_address(name) or name in self._registered:
            return self._registered.get(name)
        if name not in self._loaded:
            model = load_model(name, progress=self._progress)
            self._loaded[name] = self._loaded[model.address] = model
        return partial(ModelObject, self._loaded[name])

    def create(self, name: str, *arguments: Any, **parameters: Any) -> Any:
        """Make an object.

        Raises:
            UnknownPartError: When nothing is registered by the name; it offers the nearest names.
            ModelError: When the address leads to no model.
        """
        return self.get(name)(*arguments, **parameters)

    def warnings(self) -> tuple[str, ...]:
        """Give what was lost when models were converted, each with file and line."""
        lost = (text for model in self._loaded.values() for text in model.warnings)
        return tuple(dict.fromkeys(lost))

    def names(self) -> tuple[str, ...]:
        """Name the registered objects."""
        return self._registered.names()

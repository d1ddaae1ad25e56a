"""The objects that can be made: registered ones by name, all others by address."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from bt_manip.models import (
    MjcfModel,
    Progress,
    Source,
    can_decompose,
    is_address,
    load_model,
    terminal_progress,
)
from bt_manip.registry import Registry

from .categories import CONTAINER, check_known
from .cell_object import as_object
from .model_object import ModelObject


class Catalogue:
    """Finds what makes an object, wherever an object is named.

    A model that was fetched and converted once is kept, so that the next one of it is only made.
    """

    def __init__(
        self,
        registered: Registry[Callable[..., Any]],
        progress: Progress = terminal_progress,
        sources: Registry[Source] | None = None,
    ) -> None:
        """Know the registered objects.

        Args:
            registered: Factories by name.
            progress: Told how far a download is.
            sources: What finds models, by kind of address; default: the built-in ones.
        """
        self._sources = None if sources is None else {s: sources.get(s) for s in sources}
        self._registered = registered
        self._progress = progress
        self._loaded: dict[tuple[str, str], MjcfModel] = {}
        self._lost: dict[str, None] = {}  # a set that keeps its order
        self.vary: Callable[[str], Mapping[str, Any]] | None = None
        """Asked what to make an object with, by name, where nobody says; nobody at first."""

    def get(self, name: str) -> Callable[..., Any]:
        """Give what makes an object; a model is fetched and read now.

        Args:
            name: A registered name, or an address.

        Raises:
            UnknownPartError: When nothing is registered by the name; it offers the nearest names.
            ModelError: When the address leads to no model.
        """
        factory = self._factory(name)
        return factory if self.vary is None else partial(self._varied, name, factory)

    def nominal(self, name: str, **parameters: Any) -> Any:
        """Make an object as it is without variation.

        Raises:
            UnknownPartError: When nothing is registered by the name; it offers the nearest names.
            ModelError: When the address leads to no model.
        """
        return self._factory(name)(**parameters)

    def _factory(self, name: str) -> Callable[..., Any]:
        if not is_address(name) or name in self._registered:
            return self._registered.maker(name, "mjcf_model", expected="a composer.Entity")
        self._load(name, "hull")
        return partial(self._make, name)

    def _varied(
        self, name: str, factory: Callable[..., Any], *arguments: Any, **parameters: Any
    ) -> Any:
        varied = self.vary(name) if self.vary is not None else {}
        return factory(*arguments, **{**varied, **parameters})

    def _make(self, address: str, *, convex: str | None = None, **parameters: Any) -> ModelObject:
        """Make an object of a model; a container's meshes are hollow where that can be had."""
        category = parameters.get("category")
        if category is not None:
            check_known(category, self._categories())
        if category == CONTAINER and convex is None:
            if can_decompose():
                convex = "parts"
            elif self._load(address, "hull").assets:
                self._lost[
                    f"{address}: its meshes collide as if they were filled, so nothing may fit "
                    "into it; pip install 'bt-manip[convex]' makes them hollow"
                ] = None
        return ModelObject(self._load(address, convex or "hull"), convex=convex, **parameters)

    def _categories(self) -> set[str]:
        """Collect the categories of the registered objects, those of plugins among them."""
        found = (as_object(self._registered.get(name)).category for name in self._registered)
        return {category for category in found if isinstance(category, str)}

    def _load(self, address: str, convex: str) -> MjcfModel:
        if (address, convex) not in self._loaded:
            model = load_model(
                address, convex=convex, progress=self._progress, sources=self._sources
            )
            self._loaded[address, convex] = self._loaded[model.address, convex] = model
            self._lost.update(dict.fromkeys(model.warnings))
        return self._loaded[address, convex]

    def create(self, name: str, *arguments: Any, **parameters: Any) -> Any:
        """Make an object.

        Raises:
            UnknownPartError: When nothing is registered by the name; it offers the nearest names.
            ModelError: When the address leads to no model.
        """
        return self.get(name)(*arguments, **parameters)

    def warnings(self) -> tuple[str, ...]:
        """Give what was lost when models were converted, each with file and line."""
        return tuple(self._lost)

    def names(self) -> tuple[str, ...]:
        """Name the registered objects."""
        return self._registered.names()

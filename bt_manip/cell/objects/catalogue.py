"""Factories of objects, by registered name or address of a model."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from bt_manip.models import (
    MjcfModel,
    ModelFormat,
    Source,
    built_in_sources,
    can_decompose,
    is_address,
    load_model,
    no_downloads,
)
from bt_manip.registry import Registry, installed_parts

from .categories import CONTAINER, check_known
from .cell_object import as_object
from .model_object import ModelObject


class Catalogue:
    """Provides the factory of an object by its registered name or by the address of a model.

    Models are fetched and converted only once.

    Args:
        registered: Factories by name.
        sources: Model sources by kind of address; default: those of all installed plugins.
        formats: Model formats by name; default: those of all installed plugins.
    """

    def __init__(
        self,
        registered: Registry[Callable[..., Any]],
        sources: Registry[Source] | None = None,
        formats: Registry[ModelFormat] | None = None,
    ) -> None:
        self._sources = None if sources is None else sources.copies()
        self._formats = None if formats is None else formats.copies()
        self._registered = registered
        self._loaded: dict[tuple[str, str], MjcfModel] = {}
        self._warnings: dict[str, None] = {}  # an ordered set
        self.sample_parameters: Callable[[str], Mapping[str, Any]] | None = None
        """Samples parameters of the object of a name that are not given; None by default."""

    def get(self, name: str) -> Callable[..., Any]:
        """Return the factory of an object; its model is fetched and read immediately.

        Args:
            name: A registered name, or an address.

        Raises:
            UnknownPartError: If the name is not registered; the nearest names are offered.
            ModelError: If there is no model at the address.
        """
        factory = self._factory(name)
        if self.sample_parameters is None:
            return factory
        return partial(self._randomized, name, factory)

    def nominal(self, name: str, **parameters: Any) -> Any:
        """Make an object without randomization.

        Raises:
            UnknownPartError: If the name is not registered; the nearest names are offered.
            ModelError: If there is no model at the address.
        """
        return self._factory(name)(**parameters)

    def restored(self, name: str, parameters: Mapping[str, Any]) -> Any:
        """Make an object of a snapshot, without randomization; nothing is downloaded.

        Sources of plugins that do not declare ``checks_downloads`` might download, and are not used
        for models that are not loaded yet.

        Raises:
            UnknownPartError: If the name is not registered; the nearest names are offered.
            ModelError: If the model is neither loaded nor on this machine.
        """
        sources = self._sources
        known = installed_parts().model_sources.copies() if sources is None else sources
        careful = {k: find for k, find in known.items() if getattr(find, "checks_downloads", False)}
        self._sources = built_in_sources() | careful
        try:
            with no_downloads(f"a snapshot downloads no models, and '{name}' is not here"):
                return self.nominal(name, **parameters)
        finally:
            self._sources = sources

    def _factory(self, name: str) -> Callable[..., Any]:
        if not is_address(name) or name in self._registered:
            return self._registered.maker(name, "mjcf_model", expected="a composer.Entity")
        self._load(name, "hull")
        return partial(self._make, name)

    def _randomized(
        self, name: str, factory: Callable[..., Any], *arguments: Any, **parameters: Any
    ) -> Any:
        sampled = self.sample_parameters(name) if self.sample_parameters is not None else {}
        return factory(*arguments, **{**sampled, **parameters})

    def _make(self, address: str, *, convex: str | None = None, **parameters: Any) -> ModelObject:
        """Create an object from a model; meshes of containers are decomposed into convex parts."""
        category = parameters.get("category")
        if category is not None:
            known = (as_object(self._registered.get(name)).category for name in self._registered)
            check_known(category, (word for word in known if isinstance(word, str)))
        if category == CONTAINER and convex is None:
            if can_decompose():
                convex = "parts"
            elif self._load(address, "hull").assets:
                self._warnings[
                    f"{address}: its meshes collide as if they were filled, so nothing may fit "
                    "into it; pip install 'bt-manip[convex]' makes them hollow"
                ] = None
        model = self._load(address, convex or "hull")
        made = ModelObject(model, convex=convex, **parameters)
        self._warnings.update(dict.fromkeys(made.warnings))
        return made

    def _load(self, address: str, convex: str) -> MjcfModel:
        if (address, convex) not in self._loaded:
            model = load_model(address, convex=convex, sources=self._sources, formats=self._formats)
            self._loaded[address, convex] = self._loaded[model.address, convex] = model
            self._warnings.update(dict.fromkeys(model.warnings))
        return self._loaded[address, convex]

    def create(self, name: str, *arguments: Any, **parameters: Any) -> Any:
        """Make an object.

        Raises:
            UnknownPartError: If the name is not registered; the nearest names are offered.
            ModelError: If there is no model at the address.
        """
        return self.get(name)(*arguments, **parameters)

    def warnings(self) -> tuple[str, ...]:
        """Return the warnings about the models of all objects so far."""
        return tuple(self._warnings)

    def names(self) -> tuple[str, ...]:
        """Return the names of the registered objects."""
        return self._registered.names()

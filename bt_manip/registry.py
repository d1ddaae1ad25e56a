"""Registries of parts by name, each part with the plugin that provides it."""

import copy
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from functools import partial
from typing import Any, Generic, TypeVar

from bt_manip.exceptions import BtManipError
from bt_manip.packages import suggestion

T = TypeVar("T")


class UnknownPartError(BtManipError):
    """No part is registered under a requested name.

    Args:
        note: Possible other reason, appended to the message.

    Attributes:
        kind: Kind of the part: ``"robot"``, ``"object"``, ...
        name: The unknown name.
        known: The registered names.
    """

    def __init__(self, kind: str, name: str, known: tuple[str, ...], note: str = "") -> None:
        hint = suggestion(kind, name, known) or "; no plugin brings one"
        super().__init__(f"unknown {kind} '{name}'{hint}{note}")
        self.kind = kind
        self.name = name
        self.known = known


class PartFault(Exception):
    """A part cannot be created because of a fault in its plugin.

    Not a `BtManipError`, because the request for the part is valid.

    Attributes:
        plugin: Name of the plugin.
    """

    def __init__(self, kind: str, name: str, plugin: str, problem: str) -> None:
        super().__init__(f"{kind} '{name}' cannot be made: {problem}")
        self.plugin = plugin


class Registry(Generic[T]):
    """Registry of parts of one kind by name, which returns copies.

    Parts are never shared between runs: data is copied, and factories create new objects. So no run
    can change the parts of the next one.

    Args:
        kind: Kind of its parts, in the singular, for messages.
    """

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self.note = ""  # appended to the message on a miss
        self._items: dict[str, tuple[T, str]] = {}

    def add(self, name: str, item: T, owner: str) -> None:
        """Register a part.

        Args:
            name: Name of the part.
            item: The part.
            owner: The plugin that provides it.

        Raises:
            BtManipError: If the name is taken or invalid.
        """
        self.check(name)
        self._items[name] = (item, owner)

    def check(self, name: object) -> None:
        """Check that a part can be registered under a name.

        Raises:
            BtManipError: If the name is taken or invalid.
        """
        if not isinstance(name, str) or not name or not all(c.isalnum() or c in "_-" for c in name):
            raise BtManipError(
                f"{self.kind} names are made of letters, digits, '_' and '-', got {name!r}"
            )
        if name in self._items:
            raise BtManipError(
                f"{self.kind} '{name}' is registered already, by plugin '{self.owner(name)}'"
            )

    def with_part(self, name: str, item: T) -> "Registry[T]":
        """Return a copy of the registry with a part added or replaced, of the same owner."""
        other = copy.copy(self)
        owner = self._items[name][1] if name in self._items else ""
        other._items = {**self._items, name: (item, owner)}
        return other

    def get(self, name: str) -> T:
        """Return a copy of a part.

        Raises:
            UnknownPartError: If there is none of this name; the message suggests the nearest names.
        """
        return copy.deepcopy(self._find(name)[0])

    def create(self, name: str, *arguments: Any, **parameters: Any) -> Any:
        """Call a factory and return the new part.

        Raises:
            UnknownPartError: If there is none of this name; the message suggests the nearest names.
        """
        factory: Any = self.get(name)
        return factory(*arguments, **parameters)

    def maker(self, name: str, *needs: str, expected: str = "") -> Callable[..., Any]:
        """Return a wrapped factory, whose errors name the plugin at fault.

        Args:
            name: Name of the factory.
            *needs: Attributes that a part of this kind must have.
            expected: Description of a part of this kind, for messages.

        Returns:
            A function with the arguments of the factory, which is its ``__wrapped__``. It raises
            `PartFault` if the factory raises an error other than `BtManipError`, or returns an
            object without the attributes.

        Raises:
            UnknownPartError: If there is none of this name; the message suggests the nearest names.
        """
        factory: Any = self.get(name)

        def fault(problem: str) -> PartFault:
            return PartFault(self.kind, name, self.owner(name), problem)

        def make(*arguments: Any, **parameters: Any) -> Any:
            try:
                made = factory(*arguments, **parameters)
                missing = [need for need in needs if not hasattr(made, need)]
            except BtManipError:
                raise
            except (Exception, SystemExit) as error:
                raise fault(f"{type(error).__name__}: {error}") from error
            if missing:
                gave = "None" if made is None else f"a {type(made).__name__}"
                right = f"; expected {expected}" if expected else ""
                raise fault(f"its factory gave {gave}, which has no '{missing[0]}'{right}")
            return made

        make.__wrapped__ = factory  # type: ignore[attr-defined]
        return make

    def copies(self) -> dict[str, T]:
        """Return copies of all parts by name, in alphabetical order."""
        return {name: self.get(name) for name in self}

    def owner(self, name: str) -> str:
        """Return the name of the plugin that provides a part.

        Raises:
            UnknownPartError: If there is none of this name.
        """
        return self._find(name)[1]

    def names(self) -> tuple[str, ...]:
        """Return the names of all parts, in alphabetical order."""
        return tuple(sorted(self._items))

    def in_order(self) -> tuple[str, ...]:
        """Return the names of all parts, in the order of their registration."""
        return tuple(self._items)

    def _find(self, name: str) -> tuple[T, str]:
        try:
            return self._items[name]
        except KeyError:
            raise UnknownPartError(self.kind, name, self.names(), self.note) from None

    def __contains__(self, name: object) -> bool:
        """Return whether there is a part of this name."""
        return name in self._items

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names, in alphabetical order."""
        return iter(self.names())

    def __len__(self) -> int:
        """Return the number of parts."""
        return len(self._items)


@dataclass(frozen=True)
class TreeDefaults:
    """Scene and controller that a tree requires, by registered names; None for any.

    Attributes:
        scene: Name of the scene.
        controller: Name of the arm's controller.
    """

    scene: str | None = None
    controller: str | None = None


def _registry(kind: str) -> Any:
    return field(default_factory=partial(Registry, kind))


@dataclass(frozen=True)
class Parts:
    """All parts that plugins provide, by kind.

    Attributes:
        objects: Factories, ``factory(**parameters) -> composer.Entity``.
        robots: Robot descriptions.
        grippers: Factories, ``factory(robot) -> Gripper``.
        controllers: Factories, ``factory(robot) -> Controller``.
        planners: Factories, ``factory() -> Planner``.
        behaviours: Classes of tree nodes, without the built-in nodes of the tree language.
        dialects: Dialects of trees, `bt_manip.bt.Dialect`.
        conversions: Functions, ``write(reading, stubs) -> str``, of `bt_manip.bt.Reading`.
        trees: Locations: ``path.xml`` or ``path.py:function``.
        scenes: Factories, ``factory() -> Scene``.
        model_sources: Functions, ``find(address, progress) -> FoundModel | Path``, by the kind of
            address: the text before the colon.
        model_formats: Formats of model files, `bt_manip.models.ModelFormat`.
        model_caches: Factories, ``factory() -> bt_manip.models.ModelCache``.
        recorders: Factories, ``factory(path) -> RunObserver``.
        views: Factories, ``factory(session, **options) -> bt_manip.runner.RunView``.
        commands: Places of commands, ``module:function``, by the group, if any, and the name:
            ``tree-draw``.
        modifiers: Factories, ``factory(run, texts, warn) -> bt_manip.runner.RunModifier``.
        pools: Factories of pools of workers, ``factory(make_worker, address, workers)``.
        contracts: Functions, ``checks(parts, provides, settings) -> Iterable[Check]``.
        backends: Real robots, `bt_manip.robots.Backend`.
        pose_sources: Factories, ``factory(expected) -> bt_manip.scenes.PoseSource``.
        tree_defaults: Required scene and controller of trees, by the name of the tree.
        declared: Parts of the kinds that plugins declare, by kind.
        plugins: Versions of the plugins that provide them, except the built-in one, by name.
    """

    trees: Registry[str] = _registry("tree")
    behaviours: Registry[type] = _registry("behaviour")
    dialects: Registry[Any] = _registry("dialect")
    conversions: Registry[Callable[..., Any]] = _registry("conversion")
    objects: Registry[Callable[..., Any]] = _registry("object")
    robots: Registry[Any] = _registry("robot")
    grippers: Registry[Callable[..., Any]] = _registry("gripper")
    controllers: Registry[Callable[..., Any]] = _registry("controller")
    planners: Registry[Callable[..., Any]] = _registry("planner")
    scenes: Registry[Callable[..., Any]] = _registry("scene")
    backends: Registry[Any] = _registry("backend")
    pose_sources: Registry[Callable[..., Any]] = _registry("pose source")
    model_sources: Registry[Callable[..., Any]] = _registry("model source")
    model_formats: Registry[Any] = _registry("model format")
    model_caches: Registry[Callable[..., Any]] = _registry("model cache")
    recorders: Registry[Callable[..., Any]] = _registry("recorder")
    views: Registry[Callable[..., Any]] = _registry("view")
    commands: Registry[str] = _registry("command")
    modifiers: Registry[Callable[..., Any]] = _registry("modifier")
    pools: Registry[Callable[..., Any]] = _registry("pool")
    contracts: Registry[Callable[..., Any]] = _registry("contract")
    tree_defaults: dict[str, TreeDefaults] = field(default_factory=dict)
    declared: dict[str, Registry[Any]] = field(default_factory=dict)
    plugins: dict[str, str] = field(default_factory=dict)

    def by_kind(self) -> Mapping[str, Registry[Any]]:
        """Return all registries by kind, ``"objects"`` and so on."""
        values = {one.name: getattr(self, one.name) for one in fields(self)}
        own = {kind: value for kind, value in values.items() if isinstance(value, Registry)}
        return own | self.declared

    def of(self, kind: str) -> Registry[Any]:
        """Return the registry of a kind, such as one that a plugin declares.

        Raises:
            UnknownPartError: If no plugin declares it.
        """
        kinds = self.by_kind()
        if kind not in kinds:
            raise UnknownPartError("kind of parts", kind, tuple(kinds))
        return kinds[kind]


_load: Callable[[], Parts]


def set_loader(load: Callable[[], Parts]) -> None:
    """Set the function behind `installed_parts`; ``bt_manip`` does so when it is imported."""
    global _load
    _load = load


def installed_parts() -> Parts:
    """Load the parts of all installed plugins, for functions that get no parts."""
    return _load()

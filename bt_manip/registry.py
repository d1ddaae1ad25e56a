"""Parts by name, each with the plugin that brought it."""

import copy
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from bt_manip.exceptions import BtManipError, did_you_mean

T = TypeVar("T")


class UnknownPartError(BtManipError):
    """A part was asked for by a name that nothing is registered under.

    Attributes:
        kind: What was asked for: ``"robot"``, ``"object"``, ...
        name: The name that is not known.
        known: The names that are.
    """

    def __init__(self, kind: str, name: str, known: tuple[str, ...], note: str = "") -> None:
        """Say what is missing and which names are nearest.

        Args:
            kind: What was asked for.
            name: The name that is not known.
            known: The names that are.
            note: What else may explain that it is missing.
        """
        super().__init__(f"unknown {kind} '{name}'" + did_you_mean(name, known) + note)
        self.kind = kind
        self.name = name
        self.known = known


class PartFault(Exception):
    """A part cannot be made, by a fault of the plugin that it is from.

    Not a `BtManipError`: whoever asked for the part has done nothing wrong.

    Attributes:
        plugin: Name of the plugin.
    """

    def __init__(self, kind: str, name: str, plugin: str, problem: str) -> None:
        """Say which part it is, and what is wrong with it."""
        super().__init__(f"{kind} '{name}' cannot be made: {problem}")
        self.plugin = plugin


class Registry(Generic[T]):
    """Keeps parts of one kind by name and hands out copies.

    What comes out is never shared: data is copied, functions and classes are what makes new
    things. So no run can change what the next one gets.
    """

    def __init__(self, kind: str) -> None:
        """Make an empty registry.

        Args:
            kind: What its parts are, in the singular, for messages.
        """
        self.kind = kind
        self.note = ""  # appended to the message on a miss
        self._items: dict[str, tuple[T, str]] = {}

    def add(self, name: str, item: T, owner: str) -> None:
        """Take in a part.

        Args:
            name: The name that it is asked for by.
            item: The part.
            owner: The plugin that brings it.

        Raises:
            BtManipError: When the name is taken or is no name.
        """
        self.check(name)
        self._items[name] = (item, owner)

    def check(self, name: object) -> None:
        """Make sure that a part could be taken in under a name.

        Raises:
            BtManipError: When the name is taken or is no name.
        """
        if not isinstance(name, str) or not name or not all(c.isalnum() or c in "_-" for c in name):
            raise BtManipError(
                f"{self.kind} names are made of letters, digits, '_' and '-', got {name!r}"
            )
        if name in self._items:
            raise BtManipError(
                f"{self.kind} '{name}' is registered already, by plugin '{self.owner(name)}'"
            )

    def get(self, name: str) -> T:
        """Give a copy of a part.

        Raises:
            UnknownPartError: When there is none of this name; it offers the nearest names.
        """
        return copy.deepcopy(self._find(name)[0])

    def create(self, name: str, *arguments: Any, **parameters: Any) -> Any:
        """Call a part that is a factory.

        Raises:
            UnknownPartError: When there is none of this name; it offers the nearest names.
        """
        factory: Any = self.get(name)
        return factory(*arguments, **parameters)

    def maker(self, name: str, *needs: str, expected: str = "") -> Callable[..., Any]:
        """Give what makes a part that is a factory, so that a plugin's fault in it has its name.

        Args:
            name: The part.
            *needs: Names of what a part of this kind has to have.
            expected: What a part of this kind is, for messages.

        Returns:
            A function that takes what the factory takes, which is its ``__wrapped__``. It raises a
            `PartFault` when the factory raises, unless that is a `BtManipError`, or makes something
            else.

        Raises:
            UnknownPartError: When there is none of this name; it offers the nearest names.
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

    def owner(self, name: str) -> str:
        """Name the plugin that brought a part.

        Raises:
            UnknownPartError: When there is none of this name.
        """
        return self._find(name)[1]

    def names(self) -> tuple[str, ...]:
        """Name all parts, in alphabetical order."""
        return tuple(sorted(self._items))

    def _find(self, name: str) -> tuple[T, str]:
        try:
            return self._items[name]
        except KeyError:
            raise UnknownPartError(self.kind, name, self.names(), self.note) from None

    def __contains__(self, name: object) -> bool:
        """Tell whether there is a part of this name."""
        return name in self._items

    def __iter__(self) -> Iterator[str]:
        """Go through the names, in alphabetical order."""
        return iter(self.names())

    def __len__(self) -> int:
        """Count the parts."""
        return len(self._items)


@dataclass(frozen=True)
class Surroundings:
    """Where a tree works, by registered names; None where it does not care.

    Attributes:
        scene: What stands in the cell.
        controller: What the arm is controlled by.
    """

    scene: str | None = None
    controller: str | None = None


@dataclass(frozen=True)
class Parts:
    """All that plugins brought, kind by kind.

    Attributes:
        objects: Factories, ``factory(**parameters) -> composer.Entity``.
        robots: Robot descriptions.
        grippers: Factories, ``factory(robot) -> Gripper``.
        controllers: Factories, ``factory(robot) -> Controller``.
        planners: Factories, ``factory() -> Planner``.
        behaviours: Classes of tree nodes; the nodes of the tree language itself are not here.
        trees: Places: ``path.xml`` or ``path.py:function``.
        scenes: Factories, ``factory() -> Scene``.
        model_sources: Functions, ``find(address, progress) -> FoundModel | Path``, by what stands
            before the colon of an address.
        recorders: Factories, ``factory(path) -> RunObserver``.
        surroundings: Where trees work that do not work everywhere, by their names.
    """

    objects: Registry[Callable[..., Any]] = field(default_factory=lambda: Registry("object"))
    robots: Registry[Any] = field(default_factory=lambda: Registry("robot"))
    grippers: Registry[Callable[..., Any]] = field(default_factory=lambda: Registry("gripper"))
    controllers: Registry[Callable[..., Any]] = field(
        default_factory=lambda: Registry("controller")
    )
    planners: Registry[Callable[..., Any]] = field(default_factory=lambda: Registry("planner"))
    behaviours: Registry[type] = field(default_factory=lambda: Registry("behaviour"))
    trees: Registry[str] = field(default_factory=lambda: Registry("tree"))
    scenes: Registry[Callable[..., Any]] = field(default_factory=lambda: Registry("scene"))
    model_sources: Registry[Callable[..., Any]] = field(
        default_factory=lambda: Registry("model source")
    )
    recorders: Registry[Callable[..., Any]] = field(default_factory=lambda: Registry("recorder"))
    surroundings: dict[str, Surroundings] = field(default_factory=dict)

    def by_kind(self) -> Mapping[str, Registry[Any]]:
        """Give the registries by the names of their fields, ``"objects"`` and so on."""
        return {
            "objects": self.objects,
            "robots": self.robots,
            "grippers": self.grippers,
            "controllers": self.controllers,
            "planners": self.planners,
            "behaviours": self.behaviours,
            "trees": self.trees,
            "scenes": self.scenes,
            "model_sources": self.model_sources,
            "recorders": self.recorders,
        }

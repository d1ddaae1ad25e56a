"""The behaviours that trees may name."""

from collections.abc import Iterable, Mapping
from enum import Enum
from typing import TYPE_CHECKING, Any, Final

from bt_manip.bt.nodes.actions import blackboard, constant, script, sleep
from bt_manip.bt.nodes.controls import branching, parallel, reactive, sequence, switch, try_catch
from bt_manip.bt.nodes.decorators import conditional, forcing, loop, repeat, timing
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.nodes.subtree import SubTree
from bt_manip.exceptions import TreeError, UnknownBehaviourError
from bt_manip.packages import suggestion

if TYPE_CHECKING:
    from bt_manip.bt.xml.dialect import Dialect

FORBIDDEN = frozenset(" \t\n\r<>&\"'/\\:*?|.")
"""Characters that no name of a behaviour, tree or port has."""

BUILT_IN: Final[tuple[type[Node], ...]] = (
    blackboard.SetBlackboard, blackboard.UnsetBlackboard, blackboard.WasEntryUpdated,
    branching.IfThenElse, branching.WhileDoElse,
    conditional.Precondition, conditional.RunOnce, conditional.SkipUnlessUpdated,
    conditional.WaitValueUpdate,
    constant.AlwaysFailure, constant.AlwaysSuccess,
    forcing.ForceFailure, forcing.ForceSuccess, forcing.Inverter, forcing.KeepRunningUntilFailure,
    loop.LoopBool, loop.LoopDouble, loop.LoopInt, loop.LoopString,
    parallel.Parallel, parallel.ParallelAll,
    reactive.ReactiveFallback, reactive.ReactiveSequence,
    repeat.Repeat, repeat.RetryUntilSuccessful,
    script.Script, script.ScriptCondition,
    sequence.AsyncFallback, sequence.AsyncSequence, sequence.Fallback, sequence.Sequence,
    sequence.SequenceWithMemory,
    sleep.Sleep, SubTree, switch.Switch2, switch.Switch3, switch.Switch4, switch.Switch5,
    switch.Switch6, timing.Delay, timing.Timeout, try_catch.TryCatch,
)  # fmt: skip
"""The nodes of the language, which every registry has."""


class BehaviourRegistry:
    """Behaviours by the name that trees use, numbers that scripts know by name, and dialects.

    The nodes of the language are in every registry.

    Args:
        behaviours: Classes to register under their own names.
    """

    def __init__(self, behaviours: Iterable[type[Node]] = ()) -> None:
        self._classes = {cls.registration: cls for cls in BUILT_IN}
        self._built_in = frozenset(self._classes)
        self._enums: dict[str, int] = {}
        self._dialects: dict[str, Dialect] = {}
        for behaviour in behaviours:
            self.register(behaviour)

    def register(self, cls: type[Node], name: str | None = None) -> None:
        """Make a class known.

        Args:
            cls: A subclass of `Action`, `Condition`, `Control` or `Decorator`.
            name: Its name in trees; by default the name of the class.

        Raises:
            TreeError: If it is no such class, or if the name is taken or not allowed.
        """
        if not (isinstance(cls, type) and issubclass(cls, Node) and hasattr(cls, "kind")):
            raise TreeError(
                f"{cls!r} cannot be registered; expected a subclass of Action, Condition, "
                "Control or Decorator"
            )
        name = name or cls.registration
        problem = name_problem(name)
        if problem is not None:
            raise TreeError(f"the behaviour name '{name}' {problem}")
        known = self._classes.get(name)
        if known is not None and known is not cls:
            raise TreeError(f"the name '{name}' is taken by {known.__module__}.{known.__name__}")
        self._classes[name] = cls

    def replace(self, cls: type[Node], name: str) -> None:
        """Register a class under a name that may be taken."""
        self._classes[name] = cls

    def register_enum(self, enum: type[Enum] | str, value: int | None = None) -> None:
        """Let scripts, cases of a Switch and enumeration ports know numbers by name.

        Args:
            enum: An enumeration with integer values, or one name.
            value: The number of that one name.

        Raises:
            TreeError: If a name means another number already.
        """
        numbers = {enum: value} if isinstance(enum, str) else {m.name: m.value for m in enum}
        for name, number in numbers.items():
            if not isinstance(number, int):
                raise TreeError(f"scripts know integers by name; '{name}' is {number!r}")
            if self._enums.setdefault(name, number) != number:
                raise TreeError(f"'{name}' is {self._enums[name]} already; it cannot be {number}")

    def register_dialect(self, dialect: "Dialect") -> None:
        """Let documents be of a dialect."""
        self._dialects[dialect.name] = dialect

    @property
    def dialects(self) -> Mapping[str, "Dialect"]:
        """The dialects that documents may be of, by name."""
        return dict(self._dialects)

    def of_dialect(self, dialect: "Dialect") -> "BehaviourRegistry":
        """Return a registry with the nodes of a dialect, which replace those of the same name."""
        copied = self.copy()
        copied._classes.update(dialect.nodes)
        copied._built_in = copied._built_in - dialect.without | dialect.nodes.keys()
        return copied

    def get(self, name: str) -> type[Node]:
        """Return the class that is registered under a name.

        Raises:
            UnknownBehaviourError: If no class has it; the message names the nearest ones.
        """
        try:
            return self._classes[name]
        except KeyError:
            raise UnknownBehaviourError(
                f"no behaviour is named '{name}'" + suggestion("behaviour", name, self._classes)
            ) from None

    def names(self, *, built_in: bool = True) -> list[str]:
        """Return all names, sorted.

        Args:
            built_in: Whether the nodes of the language are among them.
        """
        return sorted(n for n in self._classes if built_in or n not in self._built_in)

    def is_built_in(self, name: str) -> bool:
        """Return whether the language has a node of this name."""
        return name in self._built_in

    def name_of(self, cls: type[Any]) -> str | None:
        """Return the name under which a class is registered, or None."""
        for name, known in self._classes.items():
            if known is cls:
                return name
        return None

    @property
    def enums(self) -> Mapping[str, int]:
        """Numbers that scripts know by name."""
        return dict(self._enums)

    def copy(self) -> "BehaviourRegistry":
        """Return a registry of one's own with the same content."""
        copied = BehaviourRegistry()
        copied._classes = dict(self._classes)
        copied._enums = dict(self._enums)
        copied._dialects = dict(self._dialects)
        copied._built_in = self._built_in
        return copied

    def __contains__(self, name: object) -> bool:
        """Return whether a class is registered under this name."""
        return name in self._classes


def name_problem(name: str) -> str | None:
    """Return the problem with the name of a behaviour or tree, or None."""
    if not name:
        return "is empty"
    if name in ("Root", "root"):
        return "is reserved"
    for char in name:
        if char in FORBIDDEN or ord(char) < 32 or ord(char) == 127:
            return f"contains the character {char!r}, which is not allowed"
    return None

"""The findings of a walk through a tree: what cannot run, cannot end, or cannot work."""

from collections.abc import Iterable, Mapping
from math import inf, pi
from typing import Any, Final
from xml.sax.saxutils import quoteattr

from bt_manip.bt.analysis.entries import (
    ROBOT,
    Use,
    Uses,
    constants,
    is_plain_assignment,
)
from bt_manip.bt.analysis.facts import (
    UNWRITTEN,
    Constant,
    EntryName,
    Fact,
    values_of,
    written,
)
from bt_manip.bt.analysis.flows import FLOWS
from bt_manip.bt.analysis.walk import COMPLETE, Walk, literal, robot_of, traits_of
from bt_manip.bt.nodes.action import Leaf
from bt_manip.bt.nodes.controls.parallel import Parallel, ParallelAll, threshold
from bt_manip.bt.nodes.controls.reactive import ReactiveFallback, ReactiveSequence
from bt_manip.bt.nodes.controls.sequence import InOrder, Sequence
from bt_manip.bt.nodes.controls.switch import Switch, equal
from bt_manip.bt.nodes.declared import Declared
from bt_manip.bt.nodes.decorators.forcing import ForceFailure, ForceSuccess, Inverter
from bt_manip.bt.nodes.decorators.repeat import Repeat, RetryUntilSuccessful
from bt_manip.bt.nodes.decorators.timing import Timeout
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.nodes.subtree import SubTree
from bt_manip.bt.port_types import STRING, cast
from bt_manip.bt.ports import Port, is_pointer
from bt_manip.bt.status import RUNNING
from bt_manip.bt.traits import FACTS
from bt_manip.bt.xml.problem import Edit, Place, Problems
from bt_manip.bt.xml.source import Element
from bt_manip.exceptions import shortened, shown

PLAUSIBLE: Final = {
    "m": (3.0, "metres", "centimetres or millimetres"),
    "rad": (6.3, "radians", "degrees"),
}
"""By unit: the largest plausible value in a cell, the unit in words, and what it may be mixed up
with."""

_FACTS_OF_SCRIPTS: Final = {
    "_while": "its _while never holds",
    "_skipIf": "its _skipIf always holds",
    "_failureIf": "its _failureIf always holds",
    "_successIf": "its _successIf always holds",
}
_STEPS: Final = {
    "open": ("OpenGripper", "robot"),
    "at_object": ("Reach", "object", "robot"),
    "holding": ("Grasp", "object", "robot"),
}
"""By fact: the behaviour after which it holds, and the ports that it takes from the one that needs
it."""

_ROUNDS: Final = "3"
"""Suggested rounds of a loop that never ends."""

MAX_FOLLOWED: Final = 1_000_000
"""Entries that are read times nodes, above which values of entries are not followed."""

_PASSING: Final = (
    SubTree, Inverter, ForceSuccess, ForceFailure, Timeout, Repeat, RetryUntilSuccessful,
)  # fmt: skip
"""Nodes that tick their child in their own first tick."""


def check_tree(
    nodes: list[Any],
    goal: Iterable[Any],
    places: Mapping[int, Element],
    problems: Problems,
    given: Iterable[str] = (),
    results: Iterable[str] = (),
    libraries: Iterable[str] = (),
) -> None:
    """Warn of what no run of a tree can do, or what it does on every way.

    Args:
        nodes: The nodes of a bound tree, depth first.
        goal: The conditions of its goal.
        places: The elements of the nodes.
        problems: Takes the warnings.
        given: Keys of the root that are written before the tree runs.
        results: Keys of the root that are read after the run.
        libraries: Files with sub-trees that stand for those of others, and need not use all that
            is given to them.
    """
    if nodes:
        root = id(getattr(nodes[0], "scope", None))  # a stock behaviour of py_trees has none
        checks = _Checks(nodes, goal, places, problems)
        checks.given = {EntryName(root, key) for key in given}
        checks.results = checks.given | {EntryName(root, key) for key in results}
        checks.libraries = frozenset(libraries)
        checks.make()


class _Checks:
    """The checks of one tree.

    Attributes:
        given: Entries that are written before the tree runs.
        results: Entries that are read by others than its nodes.
        libraries: Files with sub-trees that need not use all that is given to them.
    """

    def __init__(
        self,
        nodes: list[Any],
        goal: Iterable[Any],
        places: Mapping[int, Element],
        problems: Problems,
    ) -> None:
        self._nodes = nodes
        self._goal = list(goal)
        self._places = places
        self._problems = problems
        self._uses = Uses([*nodes, *self._goal], places)
        followed = {use.entry for use in self._uses.reads}
        followed |= {use.entry for use in self._uses.writes if use.key == ROBOT}
        if len(followed) * len(nodes) > MAX_FOLLOWED:
            followed = set()
        self._followed = followed
        self._walk = Walk(FLOWS, followed)
        self.given: set[EntryName] = set()
        self.results: set[EntryName] = set()
        self.libraries: frozenset[str] = frozenset()

    def make(self) -> None:
        start = {entry: Constant(value, type) for entry, value, type in constants(self._nodes)}
        facts = written({}, {**start, **dict.fromkeys(self.given)})
        self._walk.visit(self._nodes[0], facts)
        initial = {*start, *self.given}
        for node in self._nodes:
            element = self._places.get(id(node))
            if element is not None and isinstance(node, Node):
                self._check_ways(node, element)
        self._check_reads(initial)
        self._check_unread()

    def _warn(self, place: Place, text: str, code: str, edit: Edit | None = None) -> None:
        self._problems.warning(place, text, code, edit)

    def _removal(self, node: Node) -> Edit | None:
        """Return the removal of a leaf, if its parent has others."""
        element, siblings = self._places[id(node)], getattr(node.parent, "child_nodes", ())
        return Edit(element.tag, "", element.place) if element.tag and siblings[1:] else None

    def _reached(self, node: Any) -> bool:
        return id(node) in self._walk.incoming

    # ------------------------------------------------------------------ statuses

    def _check_ways(self, node: Node, element: Element) -> None:
        walk, key = self._walk, id(node)
        if not self._reached(node):
            if key in walk.barred:
                self._warn(
                    element.place,
                    f"{node.registration} never runs: {walk.barred[key]}",
                    "never-runs",
                    self._removal(node),
                )
            return
        if key in walk.decided:
            name = walk.decided[key]
            self._warn(
                element.place_of(name),
                f"{node.registration} never runs: {_FACTS_OF_SCRIPTS[name]}; "
                "remove the node, or let the script read an entry",
                "never-runs",
                self._removal(node),
            )
            return
        if key in walk.errors:
            name, error = walk.errors[key]
            self._warn(
                element.attributes[name].value_place
                if name in element.attributes
                else element.place,
                f"this script always fails: {error}{self._reader_of(node)}",
                "failing-script",
            )
        tick = type(node)._tick
        if tick is Repeat._tick:
            self._check_endless(node, element)
        elif tick is Timeout._tick:
            self._check_timeout(node, element)
        elif tick in (Parallel._tick, ParallelAll._tick):
            if tick is Parallel._tick:
                self._check_successes(node, element)
            self._check_commands(node.child_nodes, node.child_nodes)
        elif tick is ReactiveSequence._tick or tick is ReactiveFallback._tick:
            children = node.child_nodes
            for index, child in enumerate(children):
                self._check_commands([child], children[index + 1 :])
        elif tick is Switch._tick:
            self._check_cases(node, element)
        elif isinstance(node, SubTree):
            self._check_remaps(node, element)
        elif isinstance(node, Leaf):
            self._check_needs(node, element)
            if traits_of(node).commands:
                self._check_units(node, element)

    def _reader_of(self, node: Node) -> str:
        """Name the port of a number that an entry written by a node's script is for."""
        mine = {use.entry for use in self._uses.writes if use.node is node}
        for use in self._uses.reads:
            if use.port is not None and use.port.type.strong and use.entry in mine:
                if use.port.type is not STRING:
                    return (
                        f"; {use.node.registration} at {use.place} reads it as {use.port.type.form}"
                    )
        return ""

    def _check_endless(self, node: Any, element: Element) -> None:
        child = self._walk.outcomes[id(node.child_node)] if self._reached(node.child_node) else None
        port = "num_cycles" if isinstance(node, Repeat) else "num_attempts"
        if child is None or literal(node, port) != -1 or child.running is not None:
            return
        counted = child.success if isinstance(node, Repeat) else child.failure
        possible = [way for way in map(child.of, COMPLETE) if way is not None]
        if counted is not None and len(possible) == 1:
            verb = "succeeds" if isinstance(node, Repeat) else "fails"
            self._warn(
                element.place,
                f"{node.registration} never ends: '{node.child_node.name}' {verb} at once, every "
                f"time, within one tick; set {port} to a number, or repeat something that takes "
                "time",
                "never-ends",
                _value_edit(element, port, _ROUNDS),
            )

    def _check_timeout(self, node: Any, element: Element) -> None:
        limit, child = literal(node, "msec"), self._walk.outcomes.get(id(node.child_node))
        if limit and child is not None and limit < child.least < inf:
            self._warn(
                element.place,
                f"{node.registration} always ends '{node.child_node.name}', which takes at least "
                f"{child.least:g} ms, after {limit:g} ms; set msec above that",
                "always-timed-out",
                _value_edit(element, "msec", f"{2 * child.least:.0f}"),
            )

    def _check_successes(self, node: Any, element: Element) -> None:
        wanted = literal(node, "success_count")
        if wanted is None:
            return
        found = [self._walk.outcomes[id(child)] for child in node.child_nodes]
        can = [
            any(way is not None for way in (one.success, one.running, one.skipped)) for one in found
        ]
        needed = threshold(int(wanted), len(can))
        if sum(can) < needed <= len(can):
            name = node.child_nodes[can.index(False)].name
            self._warn(
                element.place,
                f"{node.registration} never succeeds: {needed} children must, and '{name}' never "
                "does",
                "never-succeeds",
            )

    def _check_cases(self, node: Any, element: Element) -> None:
        seen: dict[str, str] = {}
        for name in node.cases:
            text = node.port_text(name)
            if text is None or is_pointer(text):
                continue
            same = next(
                (one for one, value in seen.items() if equal(value, text, node.runtime.enums)), None
            )
            if same is not None:
                self._warn(
                    element.place_of(name),
                    f"{name} repeats {same}, so that its child never runs; give it another value",
                    "repeated-case",
                )
            seen[name] = text

    # ------------------------------------------------------------------ commands

    def _check_commands(self, first: list[Any], second: list[Any]) -> None:
        """Warn where two children command one arm or gripper of a robot at a time."""
        for one in first:
            surely = dict(self._commands(one, surely=True))
            for other in second:
                if other is one:
                    continue
                for command, leaf in self._commands(other, surely=False):
                    if command in surely:
                        self._warn_commands(surely[command], leaf, command[0])
                        break

    def _warn_commands(self, one: Node, other: Node, what: str) -> None:
        places = [self._places.get(id(node)) for node in (one, other)]
        if places[0] is None or places[1] is None:
            return
        earlier, later = sorted(
            ((places[0].place, one), (places[1].place, other)), key=lambda pair: pair[0][1:]
        )
        self._warn(
            later[0],
            f"{later[1].registration} commands the {what} that {earlier[1].registration} at "
            f"{earlier[0]} commands at the same time; run them one after the other",
            "commanded-twice",
        )

    def _commands(self, node: Any, *, surely: bool) -> list[tuple[tuple[str, Any], Node]]:
        """Return the first commands of a node that take time, each with its leaf.

        Args:
            node: The node.
            surely: Whether only what it commands in every case counts.
        """
        if not self._reached(node):
            return []
        guard = getattr(node, "_node_guard", None)
        if guard is not None and guard.scripts.keys() & _FACTS_OF_SCRIPTS.keys():
            return []
        if isinstance(node, Leaf):
            traits = traits_of(node)
            if RUNNING not in traits.returns:
                return []
            robot = robot_of(node, self._walk.incoming[id(node)])
            return [((name, robot), node) for name in sorted(traits.commands)]
        tick = type(node)._tick if isinstance(node, Node) else None
        if tick in (Parallel._tick, ParallelAll._tick):
            return [
                one for child in node.child_nodes for one in self._commands(child, surely=surely)
            ]
        if tick in (InOrder._tick, ReactiveSequence._tick, ReactiveFallback._tick):
            for child in node.child_nodes:
                found = self._commands(child, surely=surely)
                outcomes = self._walk.outcomes.get(id(child))
                if found or outcomes is None or outcomes.running is not None:
                    return found
                if surely and (outcomes.failure is not None or outcomes.skipped is not None):
                    return []
            return []
        if isinstance(node, _PASSING):
            return self._commands(node.child_node, surely=surely)
        return []

    # ------------------------------------------------------------------ the cell

    def _check_needs(self, node: Leaf, element: Element) -> None:
        facts = self._walk.incoming[id(node)]
        robot = robot_of(node, facts)
        for name in sorted(traits_of(node).needs):
            if values_of(facts, Fact(robot, name)) == {False}:
                text = f"{node.registration}: {FACTS[name]}"
                self._warn(element.place, text, "missing-step", _insertion(node, element, name))

    def _check_units(self, node: Node, element: Element) -> None:
        for name, port in node.ports.items():
            most, unit, others = PLAUSIBLE.get(port.unit, (inf, "", ""))
            attribute = element.attributes.get(name)
            if unit and attribute is not None and not is_pointer(attribute.value):
                number = _largest(port, attribute.value)
                if number > most:
                    self._warn(
                        attribute.value_place,
                        f"{name} is {number:g} {unit}, which is beyond any cell; is it meant in "
                        f"{others}? Write it in {unit}",
                        "implausible-value",
                        _converted(element, name, port.unit, most),
                    )

    # ------------------------------------------------------------------ the blackboard

    def _check_reads(self, initial: set[EntryName]) -> None:
        writes: dict[EntryName, Use] = {}
        for use in self._uses.writes:
            writes.setdefault(use.entry, use)
        failing = {use.entry for use in self._uses.writes if id(use.node) in self._walk.errors}
        for use in self._uses.reads:
            entry = use.entry
            if not use.is_needed:
                continue
            name = shortened(use.key)
            if entry not in writes and entry not in initial:
                self._warn(
                    use.place,
                    f"nothing writes the blackboard entry '{name}' that is read here"
                    + self._nearest(use, writes.values()),
                    "never-written",
                    self._only_entry(use, writes),
                )
            elif self._reached(use.node) and use.is_early and entry in self._followed:
                self._check_value(
                    use, values_of(self._walk.incoming[id(use.node)], entry), writes, failing
                )

    def _check_value(
        self,
        use: Use,
        values: frozenset[Any],
        writes: dict[EntryName, Use],
        failing: set[EntryName],
    ) -> None:
        entry, name = use.entry, shortened(use.key)
        if values == {UNWRITTEN}:
            writer = writes.get(entry)
            if writer is None or isinstance(writer.node, Declared):  # it may only read it
                return
            self._warn(
                use.place,
                f"the entry '{name}' is read here before {writer.node.registration} at "
                f"{writer.place} writes it; change their order",
                "read-before-written",
            )
        elif use.port is not None and entry not in failing:
            reasons = [_unreadable(use.port, value) for value in values]
            if all(reasons):
                self._warn(
                    use.place,
                    f"the entry '{name}' holds {shown(next(iter(values)).value)}: {reasons[0]}",
                    "wrong-type",
                )

    def _check_unread(self) -> None:
        read = {use.entry for use in self._uses.reads} | self.results
        names = {key for keys in self._uses.mentions.values() for key in keys}
        seen: set[EntryName] = set()
        for use in self._uses.writes:
            entry = use.entry
            if entry in read or entry in seen or not is_plain_assignment(use):
                continue
            seen.add(entry)
            if use.key.lstrip("@") == ROBOT and ROBOT in names:
                continue
            near = self._nearest(use, self._uses.reads)
            written = [one for one in self._uses.writes if one.node is use.node]
            self._warn(
                use.place,
                f"nothing reads the blackboard entry '{shortened(use.key)}' that is written here"
                + (near or "; remove it, or name it in _results"),
                "never-read",
                None if near or len(written) > 1 else self._removal(use.node),
            )

    def _only_entry(self, use: Use, writes: dict[EntryName, Use]) -> Edit | None:
        """Return the change to the entry that ports of the main tree write, if it is the only one.

        What nothing writes in a sub-tree is meant to come from outside.
        """
        root = id(use.scope.root)
        keys = {entry.key for entry, one in writes.items() if entry.scope == root and one.port}
        is_evident = len(keys) == 1 and use.port is not None and use.entry.scope == root
        return Edit(f"{{{use.key}}}", f"{{{keys.pop()}}}") if is_evident else None

    def _nearest(self, use: Use, others: Iterable[Use]) -> str:
        return self._likely(use.key, (one.key for one in others if one.scope is use.scope))

    def _likely(self, key: str, known: Iterable[str]) -> str:
        """Return a hint to the keys that a mistyped one may mean; empty if none is near."""
        text = self._problems.hint(key, known)
        return text if text.startswith("; did") else ""

    def _check_remaps(self, node: Any, element: Element) -> None:
        root = self._places.get(id(node.child_node))
        if root is None or root.place.file in self.libraries:
            return
        used = self._uses.mentions.get(id(node.inner_scope), {})
        known = [key for key in used if key != ROBOT]
        for key in node.remaps:
            if key not in used and key in element.attributes:
                self._warn(
                    element.attributes[key].place,
                    f"the sub-tree '{node.tree_id}' does not use '{key}'{self._likely(key, known)}",
                    "unused-attribute",
                )


def _value_edit(element: Element, name: str, by: str) -> Edit | None:
    """Return the change of the value of an attribute."""
    attribute = element.attributes.get(name)
    return None if attribute is None else Edit(attribute.value, by, attribute.value_place)


def _converted(element: Element, name: str, unit: str, most: float) -> Edit | None:
    """Return the value of an attribute in its unit, if it is a number in another one."""
    try:
        value = float(element.attributes[name].value)
    except ValueError:
        return None
    factors = (pi / 180,) if unit == "rad" else (0.01, 0.001)
    plausible = (value * factor for factor in factors if abs(value * factor) <= most)
    right = next(plausible, None)
    return None if right is None else _value_edit(element, name, f"{right:.4g}")


def _insertion(node: Node, element: Element, fact: str) -> Edit | None:
    """Return the insertion, before a leaf, of the step after which a fact holds."""
    name, *ports = _STEPS[fact]
    given = {port: element.get(port) for port in ports if port in element.attributes}
    if not element.tag or ("object" in ports and "object" not in given):
        return None
    words = [name, *(f"{port}={quoteattr(str(value))}" for port, value in given.items())]
    both = f"<{' '.join(words)}/>{element.tag}"
    is_step = isinstance(node.parent, Sequence)
    return Edit(element.tag, both if is_step else f"<Sequence>{both}</Sequence>", element.place)


def _largest(port: Port, text: str) -> float:
    """Return the largest magnitude of the numbers in a text that a port takes; 0 without one.

    Positions in the world, which are lists in metres, may be far from its origin.
    """
    try:
        value = port.type.parse(text) if port.type.parse else None
    except ValueError:
        return 0.0
    numbers = value if isinstance(value, list) and port.unit != "m" else [value]
    return max((abs(one) for one in numbers if isinstance(one, int | float)), default=0.0)


def _unreadable(port: Port, value: Any) -> str:
    """Return why a port does not take a value of an entry; empty if it does, or may do so."""
    type = port.type
    if not isinstance(value, Constant) or not type.strong or type.is_enum:
        return ""
    try:
        if value.type.family == "string" and type is not STRING:
            if type.parse is None:
                return f"a text does not become a {type.name}"
            read = type.parse(str(value.value))
        else:
            read = cast(value.value, value.type, type)
        if port.bounds:
            port.check(read)
    except Exception as error:  # a parser of a behaviour's own may raise anything
        return f"{error}; expected {type.form}"
    return ""

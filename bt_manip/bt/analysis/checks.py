"""The findings of a walk through a tree: what cannot run, cannot end, or cannot work."""

import re
from collections.abc import Iterable, Mapping
from math import inf, pi
from typing import Any, Final
from xml.sax.saxutils import quoteattr

from bt_manip.bt.analysis.facts import (
    UNWRITTEN,
    Constant,
    EntryName,
    Fact,
    Facts,
    Ways,
    constants,
    least,
    values_of,
    variable_of,
    written,
)
from bt_manip.bt.analysis.flows import BRANCHING, FLOWS, ORDERED, REACTIVE
from bt_manip.bt.analysis.uses import ROBOT, Use, Uses, value_place
from bt_manip.bt.analysis.walk import Walk, port_values, robot_of, traits_of
from bt_manip.bt.nodes.action import Condition, Leaf
from bt_manip.bt.nodes.actions.blackboard import SetBlackboard
from bt_manip.bt.nodes.actions.constant import AlwaysFailure, AlwaysSuccess
from bt_manip.bt.nodes.actions.script import Script
from bt_manip.bt.nodes.controls.parallel import Parallel, ParallelAll
from bt_manip.bt.nodes.controls.sequence import Sequence
from bt_manip.bt.nodes.controls.switch import Switch, equal
from bt_manip.bt.nodes.declared import Declared
from bt_manip.bt.nodes.decorators.conditional import Precondition
from bt_manip.bt.nodes.decorators.repeat import Counting, Repeat
from bt_manip.bt.nodes.decorators.timing import Delay, Timeout
from bt_manip.bt.nodes.guard import GUARDS
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.nodes.subtree import SubTree
from bt_manip.bt.port_types import STRING, cast
from bt_manip.bt.ports import Port, is_pointer, pointed_key
from bt_manip.bt.status import RUNNING, SKIPPED, SUCCESS
from bt_manip.bt.traits import FACTS
from bt_manip.bt.tree import Tree
from bt_manip.bt.xml.problem import Edit, Problems
from bt_manip.bt.xml.source import Element
from bt_manip.exceptions import shortened, shown

PLAUSIBLE: Final = {
    "m": (3.0, "metres", "centimetres or millimetres", (0.01, 0.001)),
    "rad": (6.3, "radians", "degrees", (pi / 180,)),
}
"""By unit: the largest plausible value in a cell, the unit in words, what it may be mixed up with,
and the factors from there."""

_STEPS: Final = {
    "open": ("OpenGripper", "robot"),
    "at_object": ("Reach", "object", "robot"),
    "holding": ("Grasp", "object", "robot"),
}
"""By fact: the behaviour that brings it about, and the ports that it takes from the one in need."""

_ROUNDS: Final = "3"
"""Suggested rounds of a loop that never ends."""

MAX_FOLLOWED: Final = 1_000_000
"""Entries that are read times nodes, above which values of entries are not followed."""

_PARALLEL: Final = (Parallel._tick, ParallelAll._tick)


def check_tree(
    tree: Tree,
    places: Mapping[int, Element],
    problems: Problems,
    given: Iterable[str] = (),
    libraries: Iterable[str] = (),
) -> None:
    """Warn of what no run of a tree can do, or what it does on every way.

    Keys of the root in `given` are written before. Files of `libraries` have sub-trees that stand
    for those of others, and need not use all that is given to them.
    """
    root, owners = id(tree.blackboard), set(libraries)
    checks = _Checks(tree, places, problems, {EntryName(root, key) for key in given})
    for node in tree.nodes:
        if isinstance(node, Node) and id(node) in places:
            checks.check_node(node, owners)
    checks.check_reads()
    results = (*tree.results, pointed_key("", tree.given_task) or "")
    checks.check_unread({EntryName(root, key) for key in results})
    tree.constants = checks.constants


class _Checks:
    """The checks of one tree, with the uses of its entries and the walk through it."""

    def __init__(
        self,
        tree: Tree,
        places: Mapping[int, Element],
        problems: Problems,
        given: set[EntryName],
    ) -> None:
        self._places, self._problems, self._warn = places, problems, problems.warning
        self._uses = uses = Uses([*tree.nodes, *tree.goal], places)
        start = constants(tree.scopes.values())
        self._initial = {*start, *given}
        followed = {use.entry for use in uses.reads}
        followed |= {use.entry for use in uses.writes if use.key == ROBOT}
        if len(followed) * len(tree.nodes) > MAX_FOLLOWED:
            followed = set()
        self._followed = followed
        begin: Facts = written({}, {**start, **dict.fromkeys(given)})
        if not tree.continues and any(getattr(type(n), "adds_objects", ()) for n in tree.nodes):
            robots = {robot_of(node, begin) for node in tree.nodes}
            facts = [Fact(robot, name) for robot in robots for name in ("at_object", "holding")]
            begin = {**begin, **dict.fromkeys(facts, frozenset({False}))}
        self._walk = Walk(followed)
        self._walk.visit(tree.nodes[0], begin)
        self.constants: dict[tuple[str, str], str] = {}
        self._failing = {use.entry for use in uses.writes if id(use.node) in self._walk.errors}

    def _ways(self, node: Any) -> Ways:
        return self._walk.ways.get(id(node), {})

    # ------------------------------------------------------------------ nodes

    def check_node(self, node: Any, libraries: set[str]) -> None:
        """Check what a node can do; sub-trees of libraries need not use what is given to them."""
        element, walk, key = self._places[id(node)], self._walk, id(node)
        reason, script = walk.barred.get(key, ("", ""))
        if key not in walk.incoming or script:
            if reason:
                text, edit = f"{node.registration} never runs: {reason}", _removal(node, element)
                self._warn(element.place_of(script), text, "never-runs", edit)
            return
        self._check_script(node, element)
        self._check_values(node, element)
        tick, children = type(node)._tick, node.child_nodes
        if tick is Counting._tick:
            self._check_endless(node, element)
        elif tick is Timeout._tick:
            self._check_timeout(node, element)
        elif tick in _PARALLEL:
            self._check_successes(node, element)
            self._check_commands(children, children)
        elif tick in REACTIVE:
            for index, child in enumerate(children):
                self._check_commands([child], children[index + 1 :])
        elif tick is Switch._tick:
            self._check_cases(node, element)
        elif isinstance(node, SubTree):
            self._check_remaps(node, element, libraries)
        elif isinstance(node, Leaf):
            self._check_needs(node, element)

    def _check_script(self, node: Node, element: Element) -> None:
        failure, uses = self._walk.errors.get(id(node)), self._uses
        if failure is None or failure.lacks & self._initial:
            return
        if any(use.entry in failure.lacks for use in uses.writes if use.node is not node):
            return
        text = f"this script always fails: {failure.error}"
        mine = {use.entry for use in uses.writes if use.node is node}
        for use in uses.reads:
            type = use.type
            if use.entry in mine and type is not None and type.strong and type is not STRING:
                text += f"; {use.node.registration} at {use.place} reads it as {type.form}"
                break
        self._warn(value_place(element, failure.name), text, "failing-script")

    def _check_endless(self, node: Any, element: Element) -> None:
        port, verb = node.port, "succeeds" if isinstance(node, Repeat) else "fails"
        ways, below = self._ways(node.child_node), [*node.child_node.iterate()]
        if node._counted not in ways or self._walk.number(node, port) != -1:
            return
        child, always = f"'{node.child_node.name}' {verb}", ways.keys() == {node._counted}
        reason = f": {child} at once, every time, within one tick"
        if not {id(use.node) for use in self._uses.writes}.isdisjoint(map(id, below)):
            always &= not _is_asked_again(node)
        elif not always and RUNNING not in ways and all(map(_only_asks, below)):
            reason, always = f" once {child}: nothing changes within one tick", True
        if always:
            self._warn(
                element.place,
                f"{node.registration} never ends{reason}; set {port} to a number, or repeat what "
                "takes time",
                "never-ends",
                _value_edit(element, port, _ROUNDS),
            )

    def _check_timeout(self, node: Any, element: Element) -> None:
        limit, ways = self._walk.number(node, "msec"), self._ways(node.child_node)
        time, verb, outcome = least(ways), "always ends", "which takes"
        if limit and time <= limit and SUCCESS in ways:
            time, verb, outcome = ways[SUCCESS].least, "ends", "whose success takes"
        if limit and limit < time < inf:
            self._warn(
                element.place,
                f"{node.registration} {verb} '{node.child_node.name}', {outcome} at least "
                f"{time:g} ms, after {limit:g} ms; set msec above that",
                "always-timed-out",
                _value_edit(element, "msec", f"{2 * time:.0f}"),
            )

    def _check_successes(self, node: Any, element: Element) -> None:
        can = {SUCCESS, RUNNING, SKIPPED}
        never = next((one for one in node.child_nodes if not can & self._ways(one).keys()), None)
        if never is not None and SUCCESS not in self._ways(node):
            text = f"{node.registration} never succeeds: too few can, '{never.name}' always fails"
            self._warn(element.place, text, "never-succeeds")

    def _check_cases(self, node: Any, element: Element) -> None:
        seen: dict[str, str] = {}
        chosen = node.port_text("variable")
        if chosen and node.key_of("variable") is None:
            self._warn(
                value_place(element, "variable"),
                f"the variable is the text '{chosen}', so that the same child always runs; "
                f"{{{chosen}}} reads an entry",
                "never-runs",
                _value_edit(element, "variable", f"{{{chosen}}}"),
            )
        for name in node.cases:
            text = node.port_text(name)
            if text is None or is_pointer(text):
                continue
            for same, value in seen.items():
                if equal(value, text, node.runtime.enums):
                    text = f"{name} repeats {same}, so its child never runs; give it another value"
                    self._warn(element.place_of(name), text, "repeated-case")
                    break
            else:
                seen[name] = text

    def _check_remaps(self, node: Any, element: Element, libraries: set[str]) -> None:
        root = self._places.get(id(node.child_node))
        if root is None or root.place.file in libraries:
            return
        used = self._uses.mentions.get(id(node.inner_scope), {})
        for key in node.remaps:
            if key not in used and key in element.attributes:
                near = self._likely(key, (one for one in used if one != ROBOT))
                text = f"the sub-tree '{node.tree_id}' does not use '{key}'{near}"
                self._warn(element.attributes[key].place, text, "unused-attribute")

    # ------------------------------------------------------------------ commands

    def _check_commands(self, first: list[Any], second: list[Any]) -> None:
        """Warn where two children command one arm or gripper of a robot at a time."""
        for one in first:
            surely = self._commands(one, surely=True)
            for other in second:
                found = {} if other is one or not surely else self._commands(other, surely=False)
                command = next((command for command in found if command in surely), None)
                if command is not None:
                    self._warn_commands([surely[command], found[command]], command[0])

    def _warn_commands(self, nodes: list[Node], what: str) -> None:
        earlier, later = sorted(nodes, key=lambda node: self._places[id(node)].place[1:])
        self._warn(
            self._places[id(later)].place,
            f"{later.registration} commands the {what} that {earlier.registration} at "
            f"{self._places[id(earlier)].place} commands at the same time; run them one after the "
            "other",
            "commanded-twice",
        )

    def _commands(self, node: Any, *, surely: bool) -> dict[tuple[str, Any], Node]:
        """Return the first commands of a node that take time, each with its leaf.

        With `surely`, only what it commands in every case counts.
        """
        guard, facts = getattr(node, "_node_guard", None), self._walk.incoming.get(id(node))
        if facts is None or (guard is not None and guard.scripts.keys() & GUARDS.keys()):
            return {}
        if isinstance(node, Leaf):
            traits, robot = traits_of(node), robot_of(node, facts)
            takes_time = RUNNING in traits.returns and id(node) in self._places
            return {(name, robot): node for name in sorted(traits.commands) if takes_time}
        tick, children = getattr(type(node), "_tick", None), node.child_nodes
        may_not = isinstance(node, Delay | Precondition | Switch)
        if (tick not in FLOWS and tick not in _PARALLEL) or (surely and may_not):
            return {}
        in_order = len(children) if tick in ORDERED else int(tick in BRANCHING)
        found: dict[tuple[str, Any], Node] = {}
        for index, child in enumerate(children):
            found = {**self._commands(child, surely=surely), **found}
            ways = self._ways(child)
            ends = found or not ways or RUNNING in ways or (surely and len(ways) > 1)
            if ends and index < in_order:
                break
        return found

    # ------------------------------------------------------------------ the cell

    def _check_needs(self, node: Leaf, element: Element) -> None:
        facts = self._walk.incoming[id(node)]
        robot = robot_of(node, facts)
        for name in sorted(traits_of(node).needs):
            if values_of(facts, Fact(robot, name)) == {False}:
                text = f"{node.registration}: {FACTS[name]}"
                self._warn(element.place, text, "missing-step", _insertion(node, element, name))

    def _check_values(self, node: Node, element: Element) -> None:
        """Check the values that ports read, where all that are possible are known."""
        moves = isinstance(node, Leaf) and traits_of(node).commands
        for name, port in node.ports.items():
            if not port.reads or port.writes:
                continue
            key, is_given = node.key_of(name), name in element.attributes
            if key is None and is_given:
                self._check_rest(element, port)
            if key is None and not (is_given and (port.unit in PLAUSIBLE or port.bounds)):
                continue
            values = port_values(node, name, self._walk.incoming[id(node)])
            if not all(isinstance(value, Constant) for value in values):
                continue
            value, place = next(iter(values)).value, value_place(element, name)
            if len(values) == 1 and port.type is STRING:
                self.constants[node.path, name] = str(value)
            reasons = [_unreadable(port, one) for one in values]
            most, unit, others, factors = PLAUSIBLE.get(port.unit, (inf, "", "", ()))
            if all(reasons):
                holder = name if key is None else f"the entry '{shortened(key)}'"
                if key is None or variable_of(node.scope, key) not in self._failing:
                    text = f"{holder} holds {shown(value)}: {reasons[0]}"
                    self._warn(place, text, "wrong-type")
            elif moves and min(_largest(port, str(one.value)) for one in values) > most:
                self._warn(
                    place,
                    f"{name} is {_largest(port, str(value)):g} {unit}, which is beyond any cell; "
                    f"is it meant in {others}? Write it in {unit}",
                    "implausible-value",
                    _converted(element, name, most, factors),
                )

    def _check_rest(self, element: Element, port: Port) -> None:
        """Check that nothing which changes a literal follows its number, as in ``0,15``."""
        text = element.get(port.name) or ""
        rest = port.type.ignored_rest(text)
        if not rest or rest.strip() in ("", port.unit) or re.fullmatch(r"\.0*", rest):
            return
        number, decimal = text.removesuffix(rest), text.replace(",", ".")
        is_decimal = rest.startswith(",") and not port.type.ignored_rest(decimal)
        likely = f"; did you mean {decimal}?" if is_decimal else ""
        self._warn(
            value_place(element, port.name),
            f"{port.name} is {number}: the {shown(rest)} after it is ignored{likely}",
            "no-meaning",
            _value_edit(element, port.name, decimal) if is_decimal else None,
        )

    # ------------------------------------------------------------------ the blackboard

    def check_reads(self) -> None:
        """Check that entries are written before they are read."""
        writes: dict[EntryName, Use] = {}
        for use in self._uses.writes:
            writes.setdefault(use.entry, use)
        sets = (use for use in self._uses.reads if isinstance(use.node, SetBlackboard))
        is_any = any(use.node.key_of("output_key") == use.key for use in sets)
        for use in (use for use in self._uses.reads if use.is_needed):
            entry, facts = use.entry, self._walk.incoming.get(id(use.node))
            writer, name = writes.get(entry), shortened(use.key)
            if writer is None and entry not in self._initial:
                if is_any and not isinstance(use.node, SetBlackboard):
                    continue
                text = f"nothing writes the blackboard entry '{name}' that is read here"
                text += self._nearest(use, writes.values())
                self._warn(use.place, text, "never-written", _only_other(use, writes))
            elif writer is None or facts is None or isinstance(writer.node, Declared):
                continue  # a stub may only read what its ports name
            elif use.is_early and entry in self._followed:
                if values_of(facts, entry) == {UNWRITTEN}:
                    self._warn(
                        use.place,
                        f"the entry '{name}' is read here before {writer.node.registration} at "
                        f"{writer.place} writes it; set it before",
                        "read-before-written",
                    )

    def check_unread(self, results: set[EntryName]) -> None:
        """Check that entries that Script and SetBlackboard write are read, or are results."""
        read = {use.entry for use in self._uses.reads} | results | self._initial
        useful = {use[1:3] for use in self._uses.writes if use.entry in read}  # in one sub-tree
        for use in self._uses.writes:
            is_set = use.type is None or isinstance(use.node, SetBlackboard)
            if use.entry in read or use[1:3] in useful or not is_set:
                continue
            read.add(use.entry)  # one warning is enough
            near = self._nearest(use, self._uses.reads)
            alone = sum(one.node is use.node for one in self._uses.writes) == 1
            alone &= isinstance(use.node, Script | SetBlackboard)
            self._warn(
                use.place,
                f"nothing reads the blackboard entry '{shortened(use.key)}' that is written here"
                + (near or "; remove it, or name it in _results"),
                "never-read",
                _removal(use.node, self._places[id(use.node)]) if alone and not near else None,
            )

    def _nearest(self, use: Use, others: Iterable[Use]) -> str:
        scope = use.node.scope
        return self._likely(use.key, (one.key for one in others if one.node.scope is scope))

    def _likely(self, key: str, known: Iterable[str]) -> str:
        """Return a hint to the keys that a mistyped one may mean; empty if none is near."""
        text = self._problems.hint(key, known)
        return text if text.startswith("; did") else ""


def _only_asks(node: Any) -> bool:
    """Return whether nothing changes by a node itself: a condition, a constant, or a parent."""
    asks = isinstance(node, Condition | AlwaysSuccess | AlwaysFailure)
    is_parent = getattr(type(node), "_tick", None) in FLOWS
    return (asks or is_parent) and not isinstance(node, Declared)


def _is_asked_again(node: Any) -> bool:
    """Return whether something at a loop or above it may end it, between two of its rounds."""
    while node is not None:
        guard, tick = getattr(node, "_node_guard", None), getattr(type(node), "_tick", None)
        if tick in (*REACTIVE, *BRANCHING, *_PARALLEL) or (guard and "_while" in guard.scripts):
            return True
        node = node.parent
    return False


def _only_other(use: Use, writes: Mapping[EntryName, Use]) -> Edit | None:
    """Return the change to the entry that ports of the main tree write, if it is the only one.

    What nothing writes in a sub-tree is meant to come from outside.
    """
    root = id(use.node.scope.root)
    keys = {entry.key for entry, one in writes.items() if entry.scope == root and one.type}
    is_evident = len(keys) == 1 and use.type is not None and use.entry.scope == root
    return Edit(f"{{{use.key}}}", f"{{{keys.pop()}}}") if is_evident else None


def _removal(node: Node, element: Element) -> Edit | None:
    """Return the removal of a leaf, if its parent has others."""
    siblings = getattr(node.parent, "child_nodes", ())
    return Edit(element.tag, "", element.place) if element.tag and siblings[1:] else None


def _value_edit(element: Element, name: str, by: str) -> Edit | None:
    """Return the change of the value of an attribute, unless it is that of an entry."""
    attribute = element.attributes.get(name)
    if attribute is None or is_pointer(attribute.value):
        return None
    return Edit(attribute.value, by, attribute.value_place)


def _converted(element: Element, name: str, most: float, factors: Iterable[float]) -> Edit | None:
    """Return the conversion of a number in an attribute by the first factor that is plausible."""
    try:
        value = float(element.get(name) or "")
    except ValueError:
        return None
    right = next((value * factor for factor in factors if abs(value * factor) <= most), None)
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


def _unreadable(port: Port, value: Constant) -> str:
    """Return why a port does not take a value; empty if it does, or may do so."""
    type = port.type
    if not type.strong or type.is_enum:
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

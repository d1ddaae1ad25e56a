"""Reading trees: from files and texts to trees that run."""

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypedDict, Unpack

from py_trees.behaviour import Behaviour

from bt_manip.bt.blackboard import Blackboard
from bt_manip.bt.goal import TASK
from bt_manip.bt.libraries import Libraries
from bt_manip.bt.mapping import LeafMapping
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.runtime import Clock
from bt_manip.bt.stubs import Stubs
from bt_manip.bt.substitution import Substitutions
from bt_manip.bt.tree import Tree
from bt_manip.bt.xml.builder import Builder
from bt_manip.bt.xml.context import ReadingContext
from bt_manip.bt.xml.dialect import BTCPP, dialect_named
from bt_manip.bt.xml.document import Document, parse_document, read_document
from bt_manip.bt.xml.engine_rules import check_engine_rules
from bt_manip.bt.xml.problem import Problem, Problems
from bt_manip.bt.xml.static_checks import (
    check_elements,
    check_goals_below,
    check_keys,
    check_unused,
)
from bt_manip.exceptions import BtManipError, TreeError


@dataclass(frozen=True)
class Reading:
    """The result of reading a document.

    Attributes:
        tree: The tree; None if the document cannot be used.
        problems: All findings, errors and warnings.
        document: The document, as far as it could be read.
        stubbed: The description of each stub, with the number of its nodes.
        registry: The behaviours, stubs included, and the nodes of the dialect.
    """

    tree: Tree | None
    problems: tuple[Problem, ...]
    document: Document | None
    stubbed: Mapping[str, int] = field(default_factory=dict)
    registry: BehaviourRegistry = field(default_factory=BehaviourRegistry)

    @property
    def errors(self) -> tuple[Problem, ...]:
        """The findings that make the document unusable."""
        return tuple(problem for problem in self.problems if problem.is_error)

    @property
    def warnings(self) -> tuple[Problem, ...]:
        """The findings with which the document can still be used."""
        return tuple(problem for problem in self.problems if not problem.is_error)

    def raise_errors(self) -> None:
        """Raise a `TreeError` that lists all errors, if there are any."""
        if self.errors:
            raise TreeError("\n".join(map(str, self.errors)), self.errors)

    def usable_tree(self) -> Tree:
        """Return the tree of a document without errors.

        Raises:
            TreeError: If the document has errors; it lists all of them.
        """
        self.raise_errors()
        if self.tree is None:
            raise TreeError("the document does not say which of its trees runs")
        return self.tree


class ReadingOptions(TypedDict, total=False):
    """How a document is read; all options have defaults.

    Attributes:
        clock: Returns the time [s] of Delay, Timeout and Sleep; default: ``time.monotonic``.
        main: The tree to run; default: the main tree of the document.
        dialect: ``btcpp``, ``moveit-pro``, or ``auto`` to recognise it; default: ``btcpp``.
        blackboard: The root's entries that exist before.
        substitutions: Rules that replace nodes, for tests.
        libraries: Other files and folders whose trees may be named as sub-trees; `Libraries`
            that are given to several readings are read and checked once.
        stubs: Placeholders for unknown behaviours and sub-trees; by default these are errors.
        mapping: Rules that replace leaves and sub-trees of other projects by behaviours.
        strict: Whether the static checks, beyond the rules of the engine, are made; default: True.
        library: Whether a document needs no main tree; default: False.
    """

    clock: Clock
    main: str | None
    dialect: str
    blackboard: Blackboard | Mapping[str, Any] | None
    substitutions: Substitutions | None
    libraries: Sequence[str | Path] | Libraries
    stubs: Stubs | None
    mapping: LeafMapping | None
    strict: bool
    library: bool


def load_tree(
    path: str | Path, registry: BehaviourRegistry, **options: Unpack[ReadingOptions]
) -> Tree:
    """Read a tree from a file.

    Args:
        path: The file.
        registry: The behaviours that it may name.
        **options: As of `ReadingOptions`.

    Returns:
        A tree that can run.

    Raises:
        TreeError: If the document has errors; it lists them with file, line and column.
    """
    return read_tree(path, registry, **options).usable_tree()


def parse_tree(
    text: str,
    registry: BehaviourRegistry,
    *,
    file: str = "<text>",
    base: Path | None = None,
    **options: Unpack[ReadingOptions],
) -> Tree:
    """Read a tree from a text.

    Args:
        text: The document.
        registry: The behaviours that it may name.
        file: The file name in places of problems.
        base: The folder of relative includes; the current one if none is given.
        **options: As of `ReadingOptions`.

    Returns:
        A tree that can run.

    Raises:
        TreeError: If the document has errors; it lists them with line and column.
    """
    return read_tree_text(text, registry, file=file, base=base, **options).usable_tree()


def read_tree(
    path: str | Path, registry: BehaviourRegistry, **options: Unpack[ReadingOptions]
) -> Reading:
    """Read a tree from a file, and give all findings instead of raising.

    Args:
        path: The file.
        registry: The behaviours that it may name.
        **options: As of `ReadingOptions`.

    Raises:
        TreeError: If the file cannot be opened.
    """
    problems = Problems()
    libraries = options.get("libraries", ())
    if not isinstance(libraries, Libraries):
        libraries = options["libraries"] = Libraries(libraries)
    document = read_document(path, problems, libraries.sources)
    if document is None:
        return Reading(None, tuple(problems), None)
    return _Reader(document, registry, problems, **options).read()


def read_tree_text(
    text: str,
    registry: BehaviourRegistry,
    *,
    file: str = "<text>",
    base: Path | None = None,
    **options: Unpack[ReadingOptions],
) -> Reading:
    """Read a tree from a text, and give all findings instead of raising; see `parse_tree`."""
    problems = Problems()
    document = parse_document(text, problems, file=file, base=base)
    if document is None:
        return Reading(None, tuple(problems), None)
    return _Reader(document, registry, problems, **options).read()


@dataclass
class _Reader:
    """Reads one document: checks it, builds its main tree and collects the findings.

    The options are those of `ReadingOptions`.
    """

    document: Document
    registry: BehaviourRegistry
    problems: Problems
    clock: Clock = time.monotonic
    main: str | None = None
    dialect: str = BTCPP.name
    blackboard: Blackboard | Mapping[str, Any] | None = None
    substitutions: Substitutions | None = None
    strict: bool = True
    libraries: Sequence[str | Path] | Libraries = ()
    stubs: Stubs | None = None
    mapping: LeafMapping | None = None
    library: bool = False

    def read(self) -> Reading:
        """Read the document; its libraries are added to it."""
        document, problems, libraries = self.document, self.problems, self.libraries
        main, own_trees = self.main or document.main_tree(), list(document.trees)
        if not isinstance(libraries, Libraries):
            libraries = Libraries(libraries)
        libraries.add_to(document)
        if self.mapping is not None:
            self.mapping.apply(document, problems)
        dialect = dialect_named(self.dialect, document.root)
        context = ReadingContext(
            document, self.registry, problems, dialect, self.stubs, self.strict
        )
        check_engine_rules(context)
        if self.strict:
            check_elements(context)
        builder = Builder(context, self.substitutions)
        tree = self._main_tree(main, builder)
        if self.strict and not builder.is_too_deep:
            _build_others(own_trees, context, builder)
        reached = {
            document.trees[name].place.file for name in builder.built if name in document.trees
        }
        problems.extend(libraries.problems_of(reached, context))
        if problems.errors:
            tree = None
        return Reading(tree, tuple(problems), document, builder.stubbed, context.registry)

    def _main_tree(self, main: str | None, builder: Builder) -> Tree | None:
        """Build the tree that runs, and check its goal and its blackboard keys."""
        document, problems = self.document, self.problems
        if main is None:
            if not self.library and document.root.name == "root":
                names = ", ".join(document.trees) or "none"
                problems.error(
                    document.root.place,
                    f"which tree to run? <root> needs main_tree_to_execute; trees: {names}",
                )
            return None
        root = builder.build(main, document.root.place_of("main_tree_to_execute"))
        tree = None if root is None else self._bind(main, root, builder)
        if self.strict and not builder.is_too_deep:
            check_unused(document, main, builder.built, problems)
            if tree is not None and not problems.errors:
                given = document.models.get(main, {})
                check_keys([*tree.nodes, *tree.goal], builder.places, problems, given)
        return tree

    def _bind(self, main: str, root: Behaviour, builder: Builder) -> Tree | None:
        """Bind the built nodes to the blackboard, the clock and the goal."""
        scope = _scope(self.blackboard)
        goal: tuple[Node, ...] = ()
        if self.strict:
            goal = builder.goal(main)
            check_goals_below(self.document, main, builder.built, self.problems)
        try:
            return Tree(
                root,
                clock=self.clock,
                blackboard=scope,
                enums=builder.enums,
                tree_id=main,
                document=self.document,
                on_problem=builder.add_error,
                goal=goal,
                task=self.document.trees[main].get(TASK) or "",
            )
        except BtManipError as error:
            self.problems.error(self.document.root.place, str(error))
            return None


def _scope(given: Blackboard | Mapping[str, Any] | None) -> Blackboard:
    """Return the blackboard scope of the root, with the entries that are given."""
    if isinstance(given, Blackboard):
        return given
    scope = Blackboard()
    for key, value in (given or {}).items():
        scope[key] = value
    return scope


def _build_others(tree_ids: Iterable[str], context: ReadingContext, builder: Builder) -> None:
    """Build the trees that the main tree does not reach, only to find their problems."""
    for tree_id in tree_ids:
        if tree_id not in builder.built:
            other = Builder(context)
            other.build(tree_id, context.document.trees[tree_id].place)
            other.goal(tree_id)
            builder.built |= other.built
            builder.stubbed = {**other.stubbed, **builder.stubbed}

"""Reading trees: from files and texts to trees that run."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypedDict, Unpack

from bt_manip.bt.blackboard import Blackboard
from bt_manip.bt.goal import GOAL
from bt_manip.bt.libraries import Libraries
from bt_manip.bt.mapping import LeafMapping
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.runtime import Clock
from bt_manip.bt.stubs import Stubs
from bt_manip.bt.substitution import Substitutions
from bt_manip.bt.tree import Tree
from bt_manip.bt.xml.builder import Builder
from bt_manip.bt.xml.check import check_elements, check_keys, check_unused
from bt_manip.bt.xml.dialect import dialect_named
from bt_manip.bt.xml.document import Document, parse_document, read_document
from bt_manip.bt.xml.problem import Place, Problem, Problems
from bt_manip.bt.xml.verify import verify
from bt_manip.exceptions import BtManipError, TreeError


@dataclass(frozen=True)
class Reading:
    """The result of reading a document.

    Attributes:
        tree: The tree; None if the document cannot be used.
        problems: All findings, errors and warnings.
        document: The document, as far as it could be read.
        stubbed: What each stub stands for and does, with the number of its nodes.
        registry: The behaviours, stubs included, and the nodes of the dialect.
    """

    tree: Tree | None
    problems: tuple[Problem, ...]
    document: Document | None
    stubbed: Mapping[str, int] = field(default_factory=dict)
    registry: BehaviourRegistry = field(default_factory=BehaviourRegistry)

    @property
    def errors(self) -> tuple[Problem, ...]:
        """The findings because of which the document cannot be used."""
        return tuple(problem for problem in self.problems if problem.is_error)

    @property
    def warnings(self) -> tuple[Problem, ...]:
        """The findings that do not stop it from being used."""
        return tuple(problem for problem in self.problems if not problem.is_error)

    def raise_errors(self) -> None:
        """Raise a `TreeError` that lists all errors, if there are any."""
        if self.errors:
            raise TreeError("\n".join(map(str, self.errors)), self.errors)

    def usable_tree(self) -> Tree:
        """Return the tree, if nothing is wrong with it.

        Raises:
            TreeError: If the document is wrong; it lists all that is.
        """
        self.raise_errors()
        if self.tree is None:
            raise TreeError("the document does not say which of its trees runs")
        return self.tree


class ReadingOptions(TypedDict, total=False):
    """How a document is read; all options have defaults.

    Attributes:
        clock: Returns the time [s] of Delay, Timeout and Sleep; default: ``time.monotonic``.
        main: The tree to run; by default the one that the document says.
        dialect: ``btcpp``, ``moveit-pro``, or ``auto`` to recognise it; default: ``btcpp``.
        blackboard: The root's entries that exist before.
        substitutions: Rules that put other nodes in the place of some, for tests.
        libraries: Other files and folders whose trees may be named as sub-trees; `Libraries`
            that are given to several readings are read and checked once.
        stubs: What stands for behaviours and sub-trees that nobody has; by default they are errors.
        mapping: Which behaviours stand for leaves and sub-trees of others; they are replaced in the
            document.
        strict: Whether errors that the engine finds only at a tick are reported; default: True.
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
        TreeError: If the document is wrong; it lists all that is, with file, line and column.
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
        TreeError: If the document is wrong; it lists all that is, with line and column.
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
    return _read(document, registry, problems, **options)


def read_tree_text(
    text: str,
    registry: BehaviourRegistry,
    *,
    file: str = "<text>",
    base: Path | None = None,
    **options: Unpack[ReadingOptions],
) -> Reading:
    """Read a tree from a text, and give all findings instead of raising.

    Args:
        text: The document.
        registry: The behaviours that it may name.
        file: The file name in places of problems.
        base: The folder of relative includes; the current one if none is given.
        **options: As of `ReadingOptions`.
    """
    problems = Problems()
    document = parse_document(text, problems, file=file, base=base)
    return _read(document, registry, problems, **options)


def _read(
    document: Document | None,
    registry: BehaviourRegistry,
    problems: Problems,
    *,
    clock: Clock = time.monotonic,
    main: str | None = None,
    dialect: str = "btcpp",
    blackboard: Blackboard | Mapping[str, Any] | None = None,
    substitutions: Substitutions | None = None,
    strict: bool = True,
    libraries: Sequence[str | Path] | Libraries = (),
    stubs: Stubs | None = None,
    mapping: LeafMapping | None = None,
    library: bool = False,
) -> Reading:
    if document is None:
        return Reading(None, tuple(problems), None)
    own_main = document.main_tree()
    own_trees = list(document.trees)
    if not isinstance(libraries, Libraries):
        libraries = Libraries(libraries)
    libraries.add_to(document)
    if mapping is not None:
        mapping.apply(document, problems)
    rules = dialect_named(dialect, document.root)
    known = registry = rules.extended(registry)
    if stubs is not None:
        registry = stubs.extend(document, registry)
    stubbed: dict[str, int] = {}
    verify(document, registry, problems, rules, strict=strict)
    if strict:
        check_elements(document, registry, problems, rules)
    main = main or own_main
    tree: Tree | None = None
    if main is not None:
        builder = Builder(
            document,
            registry,
            problems,
            rules,
            substitutions=substitutions,
            stubs=stubs,
            strict=strict,
        )
        place = document.root.place_of("main_tree_to_execute")
        scope = _scope(blackboard)
        root = builder.build(main, place)
        if root is not None:
            tree = _bound(root, builder, problems, document, registry, clock, scope, main, strict)
        if strict:
            check_unused(document, main, builder.built, problems)
            if tree is not None and not problems.errors:
                given = document.models.get(main, {})
                check_keys([*tree.nodes, *tree.goal], builder.places, problems, given)
        built = builder.built
        stubbed = builder.stubbed
    else:
        built = {}
        if not library and document.root.name == "root":
            names = ", ".join(document.trees) or "none"
            problems.error(
                document.root.place,
                f"which tree to run? <root> needs main_tree_to_execute; trees: {names}",
            )
    for tree_id in own_trees if strict else ():
        if tree_id not in built:  # only to find what is wrong with it
            builder = Builder(document, registry, problems, rules, stubs=stubs)
            builder.build(tree_id, document.trees[tree_id].place)
            builder.goal(tree_id)
            stubbed = {**builder.stubbed, **stubbed}
            built = {**built, **builder.built}
    reached = {document.trees[tree_id].place.file for tree_id in built if tree_id in document.trees}
    problems.extend(libraries.problems_of(reached, known, rules, stubs, strict=strict))
    if problems.errors:
        tree = None
    return Reading(tree, tuple(problems), document, stubbed, registry)


def _scope(blackboard: Blackboard | Mapping[str, Any] | None) -> Blackboard:
    if isinstance(blackboard, Blackboard):
        return blackboard
    scope = Blackboard()
    for key, value in (blackboard or {}).items():
        scope[key] = value
    return scope


def _bound(
    root: Any,
    builder: Builder,
    problems: Problems,
    document: Document,
    registry: BehaviourRegistry,
    clock: Clock,
    scope: Blackboard,
    tree_id: str,
    strict: bool,
) -> Tree | None:
    goal = builder.goal(tree_id) if strict else ()
    if strict and GOAL not in document.trees[tree_id].attributes:
        for subtree in (document.trees[name] for name in builder.built):
            if GOAL in subtree.attributes:
                problems.warning(
                    subtree.place_of(GOAL),
                    f"the '{GOAL}' of a sub-tree is ignored; main tree '{tree_id}' has none",
                )

    def report(node: Any, port: str, error: BtManipError) -> None:
        element = builder.places.get(id(node))
        if node in goal:
            problems.error(document.trees[tree_id].place_of(GOAL), f"{GOAL}: {error}")
            return
        if strict and port and element is not None and port not in element.attributes:
            return  # a port that is missing was reported already
        place = Place(document.file, 1, 1) if element is None else element.place
        if element is not None and port in element.attributes:
            place = element.attributes[port].value_place
        problems.error(place, str(error))

    try:
        return Tree(
            root,
            clock=clock,
            blackboard=scope,
            enums=registry.enums,
            tree_id=tree_id,
            document=document,
            report=report,
            goal=goal,
        )
    except BtManipError as error:
        problems.error(document.root.place, str(error))
        return None

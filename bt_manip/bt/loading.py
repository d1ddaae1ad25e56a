"""Reading trees: from files and texts to trees that run."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from py_trees.behaviour import Behaviour

from bt_manip.bt.analysis import check_tree
from bt_manip.bt.blackboard import Blackboard
from bt_manip.bt.goal import declarations
from bt_manip.bt.libraries import Libraries
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.reading_options import DEFAULTS, ReadingOptions
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.tree import Tree
from bt_manip.bt.xml.builder import Builder
from bt_manip.bt.xml.dialect import BTCPP, Dialect, choose_dialect
from bt_manip.bt.xml.document import Document, parse_document, read_document
from bt_manip.bt.xml.problem import ERROR, Problem, Problems
from bt_manip.bt.xml.reader import read_trees
from bt_manip.bt.xml.source import Element
from bt_manip.bt.xml.specs import ReadingContext
from bt_manip.bt.xml.static_checks import check_goals_below, check_unused
from bt_manip.exceptions import BtManipError, TreeError
from bt_manip.packages import missing


@dataclass(frozen=True)
class Reading:
    """The result of reading a document.

    Attributes:
        tree: The tree; None if the document cannot be used.
        problems: All findings, errors and warnings.
        document: The document, as far as it could be read.
        stubbed: The description of each stub, with the number of its nodes.
        registry: The behaviours, stubs included, and the nodes of the dialect.
        dialect: The dialect of the document.
    """

    tree: Tree | None
    problems: tuple[Problem, ...]
    document: Document | None
    stubbed: Mapping[str, int] = field(default_factory=dict)
    registry: BehaviourRegistry = field(default_factory=BehaviourRegistry)
    dialect: Dialect = BTCPP

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


def load_tree(
    path: str | Path,
    registry: BehaviourRegistry,
    options: ReadingOptions = DEFAULTS,
    **changes: Any,
) -> Tree:
    """Read a tree from a file.

    Args:
        path: The file.
        registry: The behaviours that it may name.
        options: How it is read.
        **changes: Other values for some of the options: ``clock=...``.

    Returns:
        A tree that can run.

    Raises:
        TreeError: If the document has errors; it lists them with file, line and column.
    """
    return read_tree(path, registry, options, **changes).usable_tree()


def parse_tree(
    text: str,
    registry: BehaviourRegistry,
    options: ReadingOptions = DEFAULTS,
    *,
    file: str = "<text>",
    base: Path | None = None,
    **changes: Any,
) -> Tree:
    """Read a tree from a text.

    Args:
        text: The document.
        registry: The behaviours that it may name.
        options: How it is read.
        file: The file name in places of problems.
        base: The folder of relative includes; the current one if none is given.
        **changes: Other values for some of the options: ``clock=...``.

    Returns:
        A tree that can run.

    Raises:
        TreeError: If the document has errors; it lists them with line and column.
    """
    return read_tree_text(text, registry, options, file=file, base=base, **changes).usable_tree()


def read_tree(
    path: str | Path,
    registry: BehaviourRegistry,
    options: ReadingOptions = DEFAULTS,
    **changes: Any,
) -> Reading:
    """Read a tree from a file, and give all findings instead of raising; see `load_tree`.

    Raises:
        TreeError: If the file cannot be opened.
    """
    problems = Problems()
    options = replace(options, **changes)
    libraries = Libraries.of(options.libraries)
    document = read_document(path, problems, libraries.sources)
    return _read(document, registry, problems, replace(options, libraries=libraries))


def read_tree_text(
    text: str,
    registry: BehaviourRegistry,
    options: ReadingOptions = DEFAULTS,
    *,
    file: str = "<text>",
    base: Path | None = None,
    **changes: Any,
) -> Reading:
    """Read a tree from a text, and give all findings instead of raising; see `parse_tree`."""
    problems = Problems()
    document = parse_document(text, problems, file=file, base=base)
    return _read(document, registry, problems, replace(options, **changes))


def _read(
    document: Document | None,
    registry: BehaviourRegistry,
    problems: Problems,
    options: ReadingOptions,
) -> Reading:
    """Check a document, build its main tree and collect the findings; libraries are added to it."""
    if document is None:
        return Reading(None, tuple(problems), None)
    main, own_trees = options.main or document.main_tree(), list(document.trees)
    dialect = choose_dialect(options.dialect, document.root, registry.dialects, problems)
    form = document.root.get("BTCPP_format")
    if options.dialect == "auto" and options.strict and dialect is BTCPP and form != "4":
        package = missing("dialect", "btcpp-3") if "btcpp-3" not in registry.dialects else ""
        problems.warning(
            document.root.place,
            'no BTCPP_format="4": read as version 4; --dialect btcpp-3 reads version 3'
            + (package and f", and {package}"),
            "no-format",
        )
    libraries = Libraries.of(options.libraries).extended(dialect.libraries)
    libraries.add_to(document)
    for source in document.sources.values():
        if source.findings is None:  # else another document named it before
            source.findings = Problems()
            dialect.translate(source.root, document, source.findings)
        problems.extend(source.findings)
    mapping = options.mapping
    if isinstance(mapping, Path):
        readers = [one.read_mapping for one in registry.dialects.values() if one.read_mapping]
        if not readers:
            raise TreeError(f"--map {mapping} {missing('dialect', 'moveit-pro')}")
        mapping = readers[0](mapping)
    if mapping is not None:
        mapping.apply(document, problems)
    context = ReadingContext(document, registry, problems, dialect, options)
    tree, built, stubbed = _build(context, main, own_trees)
    reached = {document.trees[name].place.file for name in built if name in document.trees}
    problems.extend(libraries.problems_of(reached, context))
    found = tuple(problems)
    if options.fatal_warnings:
        found = tuple(replace(problem, severity=ERROR) for problem in found)
    reading = Reading(tree, found, document, stubbed, context.registry, dialect)
    if reading.errors:
        return replace(reading, tree=None)
    if tree is not None:
        tree.warnings = reading.warnings
    return reading


def _build(
    context: ReadingContext, main: str | None, own_trees: list[str]
) -> tuple[Tree | None, dict[str, None], dict[str, int]]:
    """Build the tree that runs, and the document's others only to find their problems.

    Returns that tree, if any, the IDs of all that were built, and the number of nodes of each stub.
    """
    document, problems, options = context.document, context.problems, context.options
    specs = read_trees(context, own_trees if main is None else [*own_trees, main])
    builder = Builder(context, specs, options.substitutions)
    tree = None
    if main is not None:
        root = builder.build(main, document.root.place_of("main_tree_to_execute"))
        tree = None if root is None else _bind(main, root, builder, context)
        if options.strict and not builder.is_too_deep:
            check_unused(document, main, builder.built, problems)
            if tree is not None and not problems.errors:
                given = {*document.models.get(main, {}), *context.dialect.given}
                libraries = map(str, context.dialect.libraries)
                check_tree(tree, builder.places, problems, given, libraries)
    elif document.root.name == "root" and (
        not options.library or (options.strict and len(own_trees) > 1)
    ):
        add = problems.warning if options.library else problems.error
        names = ", ".join(document.top_trees()) or "none"
        add(
            document.root.place,
            "which tree to run? <root> has no main_tree_to_execute, and 'run "
            f"{document.file}:TREE' names one; trees that no other uses: {names}",
        )
    built, stubbed = builder.built, builder.stubbed
    if options.strict and not builder.is_too_deep:
        for tree_id in own_trees:
            if tree_id not in built:
                other = Builder(context, specs)
                other.build(tree_id, document.trees[tree_id].place)
                other.goal(tree_id)
                built |= other.built
                stubbed = {**other.stubbed, **stubbed}
    return tree, built, stubbed


def _bind(main: str, root: Behaviour, builder: Builder, context: ReadingContext) -> Tree | None:
    document, options = context.document, context.options
    goal: tuple[Node, ...] = ()
    if options.strict:
        goal = builder.goal(main)
        check_goals_below(document, main, builder.built, context.problems)
    try:
        return Tree(
            root,
            clock=options.clock,
            blackboard=_scope(options.blackboard),
            enums=context.registry.enums,
            tree_id=main,
            document=document,
            on_problem=builder.add_error,
            goal=goal,
            **_declarations(document.trees[main], context),
        )
    except BtManipError as error:
        context.problems.error(document.root.place, str(error))
        return None


def _declarations(element: Element, context: ReadingContext) -> dict[str, Any]:
    """Return the declarations of a tree's attributes; an error is collected."""
    try:
        return declarations({name: one.value for name, one in element.attributes.items()})
    except TreeError as error:
        name = str(error).partition(":")[0]
        context.problems.error(element.attributes[name].value_place, str(error))
        return {}


def _scope(given: Blackboard | Mapping[str, Any] | None) -> Blackboard:
    """Return the blackboard scope of the root, with the entries that are given."""
    if isinstance(given, Blackboard):
        return given
    scope = Blackboard()
    for key, value in (given or {}).items():
        scope[key] = value
    return scope

"""``bt-manip tree``: check, show, format and convert trees; models and schemas for editors."""

import os
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from bt_manip.cli.completion import complete_part
from bt_manip.cli.exit_codes import BAD_INPUT, SUCCESS
from bt_manip.cli.foreign_trees import ForeignTrees
from bt_manip.cli.json_output import findings_of, json_option, print_json
from bt_manip.cli.options import takes
from bt_manip.cli.plugin_group import PluginGroup
from bt_manip.cli.plugin_options import load_chosen_plugins
from bt_manip.exceptions import BtManipError
from bt_manip.files import read_bytes, replace_text
from bt_manip.registry import Parts, UnknownPartError

if TYPE_CHECKING:
    from bt_manip.bt import BehaviourRegistry, Place, Problem, Reading, ReadingOptions, Tree
    from bt_manip.runner import TreeSource

_output = click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Write to a file instead of the terminal.",
)


@click.group(cls=PluginGroup)
def tree() -> None:
    """Check, show, format and convert trees."""


@tree.command()
@click.argument(
    "files", nargs=-1, required=True, metavar="TREE...", shell_complete=complete_part("trees")
)
@takes(ForeignTrees, name="foreign")
@click.option("--engine", is_flag=True, help="Report only what BehaviorTree.CPP rejects.")
@click.option(
    "--scene", metavar="S", shell_complete=complete_part("scenes"),
    help="Also set the trees up in this scene: a registered name, or path.toml.",
)  # fmt: skip
@click.option(
    "--robot", metavar="R", shell_complete=complete_part("robots"),
    help="Also set the trees up with this robot: a registered name, or path.toml.",
)  # fmt: skip
@click.option("--strict", is_flag=True, help="Warnings are errors.")
@json_option
def check(
    files: tuple[str, ...], foreign: ForeignTrees, engine: bool,
    scene: str | None, robot: str | None, strict: bool, as_json: bool,
) -> int:  # fmt: skip
    """Print all errors and warnings of trees, each with file, line and column.

    With --scene or --robot, each tree is also set up in that cell, as by bt-manip run: the objects,
    configurations and robots that it names have to be there.

    Exits with 2 if there are errors.
    """
    from bt_manip.bt import Place, Problem

    parts, registry = _registered()
    options = replace(foreign.reading(), strict=not engine, library=True, fatal_warnings=strict)
    cell = {"scene": scene, "robot": robot}
    found: dict[Problem, None] = {}  # the problems of a library recur for many trees
    for text in files:
        try:
            problems = _findings(text, parts, registry, foreign, options, cell)
        except BtManipError as error:  # the others are checked all the same
            problems = [Problem(Place(text, 0, 0), str(error))]
        for problem in problems:
            if problem not in found:
                found[problem] = None
                if not as_json:
                    click.echo(str(problem))
    errors = sum(problem.is_error for problem in found)
    warnings = len(found) - errors
    foreign.print_stubs()
    if as_json:
        print_json(found)
    else:
        counted = (len(files), "tree"), (errors, "error"), (warnings, "warning")
        trees, *rest = (f"{number} {what}{'s' * (number != 1)}" for number, what in counted)
        click.echo(f"{trees}: {', '.join(rest)}", err=True)
    return BAD_INPUT if errors else SUCCESS


@tree.command()
@click.argument("name", metavar="TREE", shell_complete=complete_part("trees"))
@click.option(
    "--as",
    "form",
    type=click.Choice(["text", "dot", "svg"]),
    default="text",
    show_default=True,
    help="Output format.",
)
@takes(ForeignTrees, name="foreign")
@_output
def show(name: str, form: str, foreign: ForeignTrees, output: Path | None) -> None:
    """Print a tree, with the ports of its nodes."""
    from bt_manip.bt import draw_dot, draw_svg, draw_text
    from bt_manip.runner import make_tree

    parts, registry = _registered()
    draw: Any = {"text": draw_text, "dot": draw_dot, "svg": draw_svg}[form]
    source = _find(name, parts)
    if source.kind == "python":
        loaded = make_tree(source, {}, lambda: 0.0)
    else:
        options = replace(foreign.reading(), strict=False)
        loaded = _read(source, registry, foreign, options).usable_tree()
    foreign.print_stubs()
    _write(draw(loaded), output)


@tree.command("format")
@click.argument(
    "files", nargs=-1, required=True, type=click.Path(exists=True, dir_okay=False, path_type=Path)
)
@click.option(
    "--check", "only_check", is_flag=True, help="Print which files would change, and change none."
)
def format_(files: tuple[Path, ...], only_check: bool) -> int:
    """Rewrite documents in canonical form; comments, order and unknown attributes are kept.

    Nodes need not be known, whether they are declared or not.

    With --check, exits with 2 if a file would change.
    """
    from bt_manip.bt import decode, parse_source, write_source

    changed = 0
    for file in files:
        try:
            text = decode(read_bytes(file), str(file))
        except OSError as error:
            raise BtManipError(f"{file}: cannot be read: {error.strerror}") from None
        source = parse_source(text, str(file))
        if source.root.name != "root":
            raise BtManipError(f"{source.root.place}: no trees: <{source.root.name}>, not <root>")
        written = write_source(source)
        if written == text:
            continue
        changed += 1
        if not only_check:
            _write(written, file)
        click.echo(f"{file}: {'would change' if only_check else 'formatted'}")
    return BAD_INPUT if changed and only_check else SUCCESS


@tree.command()
@click.argument("name", metavar="TREE", shell_complete=complete_part("trees"))
@click.option(
    "--to",
    "form",
    metavar="NAME",
    shell_complete=complete_part("conversions"),
    help="Output language: xml, or one of bt-manip list conversions.  [default: python of XML, xml "
    "of Python]",
)
@click.option("--model", is_flag=True, help="Add the models of all behaviours, for Groot2.")
@takes(ForeignTrees, name="foreign")
@_output
def convert(
    name: str, form: str | None, model: bool, foreign: ForeignTrees, output: Path | None
) -> int:
    """Convert an XML document to Python, or a Python tree to XML."""
    from bt_manip.bt import Problems, Tree, tree_to_xml
    from bt_manip.runner import as_tree, make_any

    parts, registry = _registered()
    source = _find(name, parts)
    if source.kind == "python":
        if form not in (None, "xml"):
            raise BtManipError(f"'{name}' is Python, which is converted to xml only")
        written = make_any(source, {})
        if isinstance(written, Tree):
            written = as_tree(written, source, lambda: 0.0)  # not the document it was read from
        else:
            written = getattr(written, "root", written)
        text = tree_to_xml(written, registry, tree_id="MainTree", model=model)
        _write(text, output)
        return SUCCESS
    form = form or "python"
    known = ("xml", *parts.conversions.names())
    if form not in known:
        raise UnknownPartError("conversion", form, known, parts.conversions.note)
    write = None if form == "xml" else parts.conversions.get(form)
    options = replace(foreign.reading(), library=True)
    reading = _read(source, registry, foreign, options)
    reading.raise_errors()
    foreign.print_stubs()
    assert reading.document is not None
    if write is None:
        problems = Problems()
        reading.dialect.to_version_4(reading.document.root, reading.document, problems)
        for problem in problems:
            click.echo(str(problem), err=True)
        if problems.errors:
            return BAD_INPUT
        _write(tree_to_xml(reading.document, registry, model=model), output)
    else:
        _write(write(reading, options.stubs), output)
    return SUCCESS


@tree.command()
@click.option("--all", "built_in", is_flag=True, help="The nodes of the language too.")
@_output
def model(built_in: bool, output: Path | None) -> None:
    """Write the models of all behaviours, plugins' too, for the palette of Groot2."""
    from bt_manip.bt import Source, models_document, write_source

    _, registry = _registered()
    _write(write_source(Source(models_document(registry, built_in=built_in))), output)


@tree.command()
@_output
def schema(output: Path | None) -> None:
    """Write an XML schema of all behaviours, plugins' too, for the completion of editors."""
    from bt_manip.bt import tree_schema

    _, registry = _registered()
    _write(tree_schema(registry), output)


def _registered() -> tuple[Parts, "BehaviourRegistry"]:
    os.environ.setdefault("MUJOCO_GL", "disable")  # nothing is drawn here
    from bt_manip.runner import known_behaviours

    parts = load_chosen_plugins().parts
    return parts, known_behaviours(parts)


def _find(text: str, parts: Parts) -> "TreeSource":
    from bt_manip.runner import TreeSource, find_tree

    if Path(text).is_file() and not text.endswith(".py"):
        return TreeSource(text, "xml", path=Path(text))
    return find_tree(text, parts.trees.copies())


def _findings(
    text: str,
    parts: Parts,
    registry: "BehaviourRegistry",
    foreign: ForeignTrees,
    options: "ReadingOptions",
    cell: Mapping[str, str | None],
) -> "list[Problem]":
    from bt_manip.bt import NO_CELL, Problem
    from bt_manip.runner import make_tree, prepare_station, request_of, set_up

    source = _find(text, parts)
    found: list[Problem] = []
    severity = "error" if options.fatal_warnings else "warning"
    if source.kind == "python":
        tree: Tree | None = (made := make_tree(source, {}, lambda: 0.0))
        if made.goal and not made.goal_reads_cell:
            found = [Problem(_place(source), f"goal: {NO_CELL}", severity, "goal-without-cell")]
    else:
        reading = _read(source, registry, foreign, options)
        tree, found = reading.tree, list(reading.problems)
    if tree is not None and any(cell.values()):
        found += _goal_findings(tree, severity)
        station = prepare_station(request_of(source.name, parts, **cell), parts)
        try:
            set_up(tree, station)
        except BtManipError as error:
            found += findings_of(error, source.name, "not-in-the-cell")
    return found


def _goal_findings(tree: "Tree", severity: str) -> "list[Problem]":
    """Return a finding where a tree puts down what it holds, and declares no goal to judge it."""
    from bt_manip.bt import Place, Problem

    for node in tree.nodes:
        traits = getattr(node, "traits", None)
        releases = traits and "holding" in traits.needs and traits.leaves.get("holding") is False
        if releases and not tree.given_goal and isinstance(place := node._node_place, Place):
            text = (
                f"{node.registration} places an object, and the tree declares no goal to judge it "
                'by; add one to its main <BehaviorTree>: _goal="IsIn object={object} container=..."'
            )
            return [Problem(place, text, severity, "no-goal")]
    return []


def _place(source: "TreeSource") -> "Place":
    """Return the place of a function or tree of Python; line 1 where it cannot be told."""
    from bt_manip.bt import Place

    if source.path is None:
        return Place(source.name, 1, 1)
    begin = re.compile(rf"(def\s+)?{source.function}\b")
    lines = enumerate(read_bytes(source.path).decode(errors="replace").splitlines(), 1)
    return Place(str(source.path), next((i for i, line in lines if begin.match(line)), 1), 1)


def _read(
    source: "TreeSource",
    registry: "BehaviourRegistry",
    foreign: ForeignTrees,
    options: "ReadingOptions",
) -> "Reading":
    from bt_manip.bt import read_tree

    assert source.path is not None
    main = source.function or options.main
    reading = read_tree(source.path, registry, options, main=main)
    foreign.note(reading.stubbed)
    return reading


def _write(text: str, output: Path | None) -> None:
    if output is None:
        click.echo(text, nl=False)
        return
    try:
        replace_text(output, text)
    except OSError as error:
        raise BtManipError(f"{output}: cannot be written: {error.strerror}") from None

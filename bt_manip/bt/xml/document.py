"""A tree document with all files that it includes."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from bt_manip.bt.nodes.node import RESERVED
from bt_manip.bt.registry import FORBIDDEN
from bt_manip.bt.xml.problem import Problems
from bt_manip.bt.xml.source import Attribute, Element, Source, XmlError, decode, parse_source
from bt_manip.exceptions import TreeError
from bt_manip.files import read_bytes

EXPLICIT: Final = ("Action", "Condition", "Control", "Decorator")
"""Elements whose attribute ID names the node."""

EXPLICIT_OR_SUBTREE: Final = (*EXPLICIT, "SubTree")

_PORTS: Final = {
    "inputport": "input_port", "outputport": "output_port", "inoutport": "inout_port"
}  # fmt: skip

MAX_INCLUDES: Final = 1000
MAX_INCLUDE_DEPTH: Final = 100  # files that include each other in a chain


@dataclass
class Document:
    """A tree document, its included files read.

    Attributes:
        source: The document as parsed.
        path: The file, if it was one.
        file: The name of the file in places of problems.
        sources: All files by name, in the order in which they were met; this document's too.
        trees: The ``<BehaviorTree>`` elements by ID; the last one of an ID counts.
        models: The ports of sub-trees by ID, each with its default; None where it must be given.
        order: The names of the files in the order in which the engine checks them.
    """

    source: Source
    path: Path | None
    file: str
    sources: dict[str, Source] = field(default_factory=dict)
    trees: dict[str, Element] = field(default_factory=dict)
    models: dict[str, dict[str, str | None]] = field(default_factory=dict)
    order: list[str] = field(default_factory=list)

    @property
    def root(self) -> Element:
        """The root element."""
        return self.source.root

    @property
    def files(self) -> list[Path]:
        """The files that the document consists of."""
        return [Path(name) for name in self.sources if not name.startswith("<")]

    def top_level(self, name: str) -> Iterator[Element]:
        """Iterate over the elements with a name directly below the roots, of libraries too."""
        for source in self.sources.values():
            yield from (child for child in source.root.children if child.name == name)

    def main_tree(self) -> str | None:
        """Return the ID of the tree to run, or None if the document does not tell."""
        declared = self.root.get("main_tree_to_execute")
        if declared:
            return declared
        own = [child for child in self.root.children if child.name == "BehaviorTree"]
        if declared is None and len(own) == 1 and own[0].get("ID"):
            return own[0].get("ID")
        return next(iter(self.trees)) if len(self.trees) == 1 else None

    def top_trees(self) -> list[str]:
        """Return the IDs of this file's trees that no other tree names; of all if there are none.

        Trees without an ID are left out.
        """
        own = [one.get("ID") for one in self.root.children if one.name == "BehaviorTree"]
        used = {
            element.get("ID")
            for tree in self.trees.values()
            for element in tree.iterate()
            if element.name.startswith("SubTree")
        }
        names = [tree_id for tree_id in own if tree_id]
        return [tree_id for tree_id in names if tree_id not in used] or names


class Sources:
    """Parsed files by path, so that each is read once."""

    def __init__(self) -> None:
        self._read: dict[Path, Source | XmlError] = {}

    def read(self, path: Path) -> Source:
        """Return a parsed file; raise an `OSError` or an `XmlError` if it cannot be read."""
        resolved = path.resolve()
        if resolved not in self._read:
            try:
                self._read[resolved] = parse_source(decode(read_bytes(path), str(path)), str(path))
            except XmlError as error:
                self._read[resolved] = error
        source = self._read[resolved]
        if isinstance(source, XmlError):
            raise source
        return source


def read_document(
    path: str | Path,
    problems: Problems,
    sources: Sources | None = None,
    *,
    includes: bool = True,
) -> Document | None:
    """Read a file and, with `includes`, all files that it includes; None if it is no XML.

    Files in `sources` were read before, and are not read again.

    Raises:
        TreeError: If the file cannot be opened.
    """
    path = Path(path)
    sources = sources or Sources()
    try:
        source = sources.read(path)
    except OSError as error:
        raise TreeError(f"{path}: cannot be read: {error.strerror or error}") from None
    except XmlError as error:
        problems.error(error.place, error.reason)
        return None
    return _Reader(problems, sources, includes).document(source, str(path), path)


def parse_document(
    text: str, problems: Problems, *, file: str = "<text>", base: Path | None = None
) -> Document | None:
    """Read a document from a text; None if it is not well-formed XML.

    Relative includes start at `base`, by default the current folder.
    """
    try:
        source = parse_source(text, file)
    except XmlError as error:
        problems.error(error.place, error.reason)
        return None
    return _Reader(problems, Sources()).document(source, file, None, base)


class _Reader:
    def __init__(self, problems: Problems, sources: Sources, includes: bool = True) -> None:
        self._problems = problems
        self._sources = sources
        self._includes = includes
        self._auto_named = 0
        self._included = 0

    def document(
        self, source: Source, file: str, path: Path | None, base: Path | None = None
    ) -> Document:
        document = Document(source, path, file)
        folder = base or Path() if path is None else path.parent
        chain = [] if path is None else [path.resolve()]
        self._read(document, source, file, folder, chain)
        return document

    def _read(
        self, document: Document, source: Source, file: str, folder: Path, chain: list[Path]
    ) -> None:
        document.sources[file] = source
        for element in source.root.children:
            if element.name == "include" and self._includes:
                self._include(document, element, folder, chain)
        if file not in document.order:
            document.order.append(file)
        self._models(document, source.root)
        for element in source.root.children:
            if element.name == "BehaviorTree":
                self._tree(document, element)

    def _include(
        self, document: Document, element: Element, folder: Path, chain: list[Path]
    ) -> None:
        name = element.get("path")
        if name is None:
            self._problems.error(element.place, "<include> needs the attribute 'path'")
            return
        path = folder / name
        if "ros_pkg" in element.attributes and not Path(name).is_absolute():
            self._problems.error(
                element.place_of("ros_pkg"),
                "ros_pkg cannot be resolved without ROS; give a path relative to this file",
            )
            return
        place = element.place_of("path")
        try:
            resolved = path.resolve()
            if resolved in chain:
                names = " -> ".join(file.name for file in [*chain, resolved])
                self._problems.error(place, f"files include each other in a circle: {names}")
                return
            if len(chain) >= MAX_INCLUDE_DEPTH:
                self._problems.error(
                    place, f"files include each other deeper than {MAX_INCLUDE_DEPTH} levels"
                )
                return
            self._included += 1
            if self._included > MAX_INCLUDES:
                if self._included == MAX_INCLUDES + 1:
                    self._problems.error(place, f"more than {MAX_INCLUDES} files are included")
                return
            source = self._sources.read(path)
        except XmlError as error:
            self._problems.error(error.place, error.reason)
            return
        except (OSError, ValueError, RuntimeError) as error:
            reason = getattr(error, "strerror", None) or error
            self._problems.error(place, f"the included file '{path}' cannot be read: {reason}")
            return
        # Definitions of a file that was included before count again, as in the engine.
        self._read(document, source, str(path), path.parent, [*chain, resolved])

    def _models(self, document: Document, root: Element) -> None:
        for models in root.children:
            if models.name == "TreeNodesModel":
                for element in models.children:
                    self._check_model(element)
                    if element.name == "SubTree":
                        self._model(document, element)

    def _check_model(self, element: Element) -> None:
        """Warn of ports whose element is misspelt."""
        for port in element.children:
            near = _PORTS.get(port.name.lower().replace("_", ""))
            if near is not None and near != port.name:
                self._problems.warning(
                    port.place,
                    f"<{port.name}> declares nothing; did you mean <{near}>?",
                    "no-meaning",
                )

    def _model(self, document: Document, element: Element) -> None:
        tree_id = element.get("ID")
        if tree_id is None:
            self._problems.error(element.place, "the model of a SubTree needs the attribute 'ID'")
            return
        model = document.models.setdefault(tree_id, {})
        for kind in _PORTS.values():  # in this order: the last counts
            for port in element.children:
                if port.name == kind:
                    self._model_port(model, port)

    def _model_port(self, model: dict[str, str | None], port: Element) -> None:
        name = port.get("name")
        if name is None:
            self._problems.error(port.place, f"<{port.name}> needs the attribute 'name'")
            return
        problem = port_name_problem(name)
        if problem is not None:
            self._problems.error(port.place_of("name"), f"the port name '{name}' {problem}")
        default = port.get("default") or None
        if default == "{=}":
            self._problems.warning(
                port.place_of("default"),
                f"'{{=}}' in a model means the key '=' to BehaviorTree.CPP; write {{{name}}}",
            )
        model[name] = default

    def _tree(self, document: Document, element: Element) -> None:
        tree_id = element.get("ID")
        if tree_id is None:
            tree_id = f"BehaviorTree_{self._auto_named}"
            self._auto_named += 1
        known = document.trees.get(tree_id)
        if known is not None and known is not element:
            self._problems.warning(
                element.place_of("ID"),
                f"tree '{tree_id}' was defined before, at {known.place}; this definition counts",
                "defined-twice",
            )
        document.trees[tree_id] = element


def node_name(element: Element) -> str:
    """Return the registered name of an element's node; empty if its ID is missing."""
    return (element.get("ID") or "") if element.name in EXPLICIT else element.name


def port_attributes(element: Element) -> dict[str, Attribute]:
    """Return the attributes of an element that are ports of its node, or remaps, by name."""
    return {key: a for key, a in element.attributes.items() if is_port_name(key)}


def editor_attributes(element: Element) -> dict[str, str]:
    """Return the attributes of an element that only editors read, by name."""
    return {
        key: attribute.value
        for key, attribute in element.attributes.items()
        if key not in RESERVED and not is_port_name(key)
    }


def port_name_problem(name: str) -> str | None:
    """Return the problem with the name of a port, or None."""
    if not name:
        return "is empty"
    if "0" <= name[0] <= "9":
        return "starts with a digit"
    for char in name:
        if char in FORBIDDEN or ord(char) < 32 or ord(char) == 127:
            return f"contains the character {char!r}, which is not allowed"
    return "is reserved" if name in RESERVED else None


def is_port_name(name: str) -> bool:
    """Return whether an attribute names a port, not an editor's property."""
    first = name[:1]
    return (
        ("a" <= first <= "z" or "A" <= first <= "Z")
        and name not in RESERVED
        and port_name_problem(name) is None
    )

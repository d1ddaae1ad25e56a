"""Stubs: placeholders for the unknown nodes and sub-trees of a document."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ..exceptions import TreeError
from .nodes.declared import LEAVES, RESULTS, declare, model_port
from .nodes.node import Node, NodeKind
from .ports import Port
from .registry import BehaviourRegistry
from .xml.document import (
    EXPLICIT,
    Document,
    is_port_name,
    node_name,
    port_attributes,
    read_document,
)
from .xml.problem import Problems, hint
from .xml.source import Element, Text


@dataclass(frozen=True)
class Stubs:
    """Placeholders for unknown nodes and sub-trees.

    A document's own ``TreeNodesModel`` always declares nodes where stubs are allowed at all.

    Attributes:
        unknown: Whether all unknown leaves and sub-trees get a placeholder that succeeds.
        results: ``SUCCESS``, ``FAILURE``, ``RUNNING`` or the name of a known node, by the name
            of the node or sub-tree; also for some that are known.
        models: Files with a ``TreeNodesModel``: projects of Groot2, Nav2's list of its nodes.
    """

    unknown: bool = False
    results: Mapping[str, str] = field(default_factory=dict)
    models: Sequence[str | Path] = ()

    def __post_init__(self) -> None:
        """Read the files of models.

        Raises:
            TreeError: If one cannot be read or holds no models.
        """
        read: list[Document] = []
        for path in self.models:
            problems = Problems()
            document = read_document(path, problems, includes=False)
            if document is None or problems.errors:
                raise TreeError("\n".join(map(str, problems.errors)))
            if not any(document.top_level("TreeNodesModel")):
                raise TreeError(f"{path}: there is no <TreeNodesModel> in it")
            read.append(document)
        object.__setattr__(self, "_read", tuple(read))

    def extend(
        self, document: Document, registry: BehaviourRegistry, problems: Problems
    ) -> BehaviourRegistry:
        """Return a registry in which the nodes that a document uses are declared.

        The models of sub-trees are added to the document's.

        Args:
            document: The document, its libraries included.
            registry: The behaviours that are known.
            problems: Takes warnings of ports that the model of a stub does not declare.

        Raises:
            TreeError: If a result asked for does not suit the node.
        """
        documents: tuple[Document, ...] = self._read  # type: ignore[attr-defined]
        models = _node_models([document, *documents])
        for other in documents:
            document.models = {**other.models, **document.models}
        extended = registry.copy()
        for name, elements in _uses(document).items():
            known = registry.get(name) if name in registry else None
            asked, model = self.results.get(name), models.get(name)
            if asked is None:
                if known is not None and not self._is_other(known, elements, registry):
                    continue
                if model is None and (not self.unknown or name in document.trees):
                    continue
            if model is not None and known is None and (asked is not None or self.unknown):
                _complete(name, model, elements, problems)
            cls = self._declared(name, elements, known, asked, model, registry)
            if cls is not None:
                extended.replace(cls, name)
        return extended

    def result_of_tree(self, tree_id: str, document: Document) -> str | None:
        """Return the result of a sub-tree's stub; None for a sub-tree without a stub.

        Raises:
            TreeError: If a node was asked for.
        """
        asked = self.results.get(tree_id)
        if asked is not None:
            if asked.upper() not in RESULTS:
                raise TreeError(
                    f"'{tree_id}' is a sub-tree: its stub returns {', '.join(RESULTS)}, "
                    f"not '{asked}'"
                )
            return asked.upper()
        if tree_id in document.trees:
            return None
        return "SUCCESS" if self.unknown or tree_id in document.models else None

    def _is_other(
        self, known: type[Node], elements: Sequence[Element], registry: BehaviourRegistry
    ) -> bool:
        """Return whether the leaf of a document only shares its name with a known node."""
        return (
            self.unknown
            and known.kind in LEAVES
            and not registry.is_built_in(known.registration)
            and any(name not in known.ports for name in _port_names(elements))
        )

    def _declared(
        self,
        name: str,
        elements: Sequence[Element],
        known: type[Node] | None,
        asked: str | None,
        model: "_NodeModel | None",
        registry: BehaviourRegistry,
    ) -> type[Node] | None:
        like = None
        if asked is not None and asked.upper() not in RESULTS:
            if asked not in registry:
                raise TreeError(
                    f'--stub "{name}={asked}": neither one of {", ".join(RESULTS)} nor the name of '
                    f"a node{hint(asked, registry.names())}"
                )
            like = registry.get(asked)
        kind = _kind(elements, known, like, model)
        if kind is None:
            return None
        if asked is not None and like is None and kind not in LEAVES:
            raise TreeError(
                f"'{name}' is a {kind}: its stub is a known {kind}, not '{asked}', "
                f'as in --stub "{name}=Fallback"'
            )
        ports: dict[str, Port] = {} if model is None else dict(model.ports)
        if known is not None and like is None:
            ports = {
                p.name: model_port(p.direction, p.name, p.default_text or None, p.doc)
                for p in known.ports.values()
            }
        if model is None or known is not None:
            for port in _port_names(elements):
                ports.setdefault(port, model_port("inout", port, None))
        result = asked.upper() if asked is not None and like is None else "SUCCESS"
        return declare(name, kind, ports.values(), result=result, like=like)


@dataclass
class _NodeModel:
    kind: str
    ports: dict[str, Port]


def _complete(name: str, model: _NodeModel, elements: Iterable[Element], found: Problems) -> None:
    """Add the ports that a node has and its model lacks, with a warning for each."""
    ports = dict(model.ports)
    for element in elements:
        for key, attribute in port_attributes(element).items():
            if key not in model.ports:
                found.warning(attribute.place, f"the model of {name} declares no port '{key}'")
                ports.setdefault(key, model_port("inout", key, None))
    model.ports = ports


def _kind(
    elements: Sequence[Element],
    known: type[Node] | None,
    like: type[Node] | None,
    model: _NodeModel | None,
) -> str | None:
    """Return the kind of a node; None where nothing tells it."""
    if known is not None:
        return str(known.kind)
    if model is not None:
        return model.kind
    explicit = next((element.name for element in elements if element.name in EXPLICIT), None)
    if explicit is not None:
        return explicit
    if like is not None:
        return str(like.kind)
    return None if any(element.children for element in elements) else str(NodeKind.ACTION)


def _uses(document: Document) -> dict[str, list[Element]]:
    """Return the elements of all nodes of a document but sub-trees, by the name of the node."""
    uses: dict[str, list[Element]] = {}
    for tree in document.top_level("BehaviorTree"):
        for element in tree.iterate():
            name = node_name(element)
            if name and name not in ("SubTree", "BehaviorTree"):
                uses.setdefault(name, []).append(element)
    return uses


def _port_names(elements: Iterable[Element]) -> list[str]:
    return list({name: None for element in elements for name in port_attributes(element)})


def _node_models(documents: Iterable[Document]) -> dict[str, _NodeModel]:
    models_by_name: dict[str, _NodeModel] = {}
    for document in documents:
        for models in document.top_level("TreeNodesModel"):
            for element in models.children:
                name = element.get("ID")
                if element.name in EXPLICIT and name:
                    models_by_name.setdefault(name, _NodeModel(element.name, _model_ports(element)))
    return models_by_name


def _model_ports(element: Element) -> dict[str, Port]:
    ports = {}
    for port in element.children:
        direction, _, tag = port.name.partition("_")
        name = port.get("name") or ""
        if tag == "port" and is_port_name(name):
            doc = " ".join(item.text.strip() for item in port.content if isinstance(item, Text))
            ports[name] = model_port(direction, name, port.get("default"), doc)
    return ports

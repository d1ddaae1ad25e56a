"""Reading the elements of trees: each becomes the checked specification of a node.

This is the place that knows how a document writes trees, nodes, ports, scripts and remaps; the
builder looks at no element. The rules of BehaviorTree.CPP are errors wherever they are violated;
findings about ports, scripts and remaps count where a tree is built, as in the engine.
"""

from collections.abc import Iterable

from bt_manip.bt.literals import parse_boolean
from bt_manip.bt.nodes.binding import MAX_DEPTH
from bt_manip.bt.nodes.declared import declare
from bt_manip.bt.nodes.node import CONDITIONS, Node, NodeKind
from bt_manip.bt.ports import Port
from bt_manip.bt.registry import name_problem
from bt_manip.bt.script.parser import parse_script
from bt_manip.bt.xml.document import (
    EXPLICIT,
    EXPLICIT_OR_SUBTREE,
    is_port_name,
    node_name,
    port_attributes,
)
from bt_manip.bt.xml.problem import Problems
from bt_manip.bt.xml.source import Attribute, Element
from bt_manip.bt.xml.specs import NodeSpec, ReadingContext, SubTreeUse, TreeSpec
from bt_manip.bt.xml.static_checks import check_attributes, check_node
from bt_manip.exceptions import ScriptError, shortened
from bt_manip.packages import missing

SCRIPTS = tuple(CONDITIONS.values())


def read_trees(context: ReadingContext, tree_ids: Iterable[str] = ()) -> dict[str, TreeSpec]:
    """Read all trees of a document, and check the form of its files.

    Returns:
        The trees with `tree_ids`, and those that they name as sub-trees, of libraries too, by ID.
    """
    document = context.document
    own: dict[int, TreeSpec] = {}
    for file in document.order:
        root = document.sources[file].root
        if root.name == "root":
            _check_root(root, context.problems)
            for tree in root.children:
                if tree.name == "BehaviorTree":
                    reader = _TreeReader(context, context.problems, len(root.children) == 1)
                    own[id(tree)] = reader.read(tree)
        else:
            context.problems.error(
                root.place, f"the outermost element must be <root>; found <{root.name}>"
            )
    specs: dict[str, TreeSpec] = {}
    waiting = list(tree_ids)
    while waiting:
        tree_id = waiting.pop()
        element = document.trees.get(tree_id)
        if element is not None and tree_id not in specs:
            # Libraries report violated rules themselves, once for all documents.
            spec = own.get(id(element)) or _TreeReader(context, Problems()).read(element)
            specs[tree_id] = spec
            waiting += spec.subtrees
    return specs


def _check_root(root: Element, problems: Problems) -> None:
    models = [child for child in root.children if child.name == "TreeNodesModel"]
    for extra in models[1:]:
        problems.error(extra.place, "only one <TreeNodesModel> is allowed")
    for child in root.children:
        if child.name in EXPLICIT_OR_SUBTREE:
            if models and "ID" not in child.attributes:
                problems.error(child.place, f"<{child.name}> needs the attribute 'ID'")
        elif child.name not in ("include", "TreeNodesModel", "BehaviorTree"):
            problems.warning(
                child.place,
                f"<{child.name}> has no meaning here; known: <BehaviorTree>, <include>, "
                "<TreeNodesModel>",
                "no-meaning",
            )


class _TreeReader:
    """Reads the elements of one tree; the only one of its file (`is_single`) needs no ID.

    `rules` collects the violated rules of the engine, and the findings of the static checks.
    """

    def __init__(self, context: ReadingContext, rules: Problems, is_single: bool = False) -> None:
        self._context = context
        self._registry = context.registry
        self._strict = context.options.strict
        self._rules = rules
        self._is_single = is_single
        self._spec = TreeSpec()
        self._problems = self._spec.problems

    def read(self, tree: Element) -> TreeSpec:
        self._check_tree(tree)
        roots = [self._node(child, 1) for child in tree.children]
        if len(roots) == 1:
            self._spec.root = roots[0]
        return self._spec

    def _check_tree(self, tree: Element) -> None:
        tree_id = tree.get("ID")
        place = tree.place_of("ID")
        if tree_id:
            problem = self._tree_name_problem(tree_id)
            if problem is not None:
                self._rules.error(place, f"the tree name '{shortened(tree_id)}' {problem}")
            elif tree_id in self._registry:
                self._rules.error(
                    place, f"'{tree_id}' is the name of a node; a tree needs another one"
                )
        elif not self._is_single:
            self._rules.error(place, "<BehaviorTree> needs the attribute 'ID'")
        if len(tree.children) != 1:
            self._rules.error(tree.place, f"a tree has exactly 1 root, not {len(tree.children)}")
        if self._strict:
            check_attributes(tree, self._rules, self._context.dialect)

    def _tree_name_problem(self, name: str) -> str | None:
        return name_problem(self._context.dialect.plain_name(name))

    def _node(self, element: Element, depth: int) -> NodeSpec | None:
        """Read an element and its children; None if no such node is known."""
        if depth > MAX_DEPTH or self._spec.is_too_deep:
            if not self._spec.is_too_deep:
                self._rules.error(element.place, f"nested deeper than {MAX_DEPTH} levels")
            self._spec.is_too_deep = True
            return None
        spec = self._known_node(element)
        children: list[NodeSpec] = []
        for item in element.children:  # no comprehension: it would double the depth of calls
            child = self._node(item, depth + 1)
            if child is not None:
                children.append(child)
        if spec is not None and spec.subtree is None:
            spec.children = children
        return spec

    def _known_node(self, element: Element) -> NodeSpec | None:
        """Read an element by itself."""
        if element.name == "BehaviorTree":
            self._check_tree(element)
            self._problems.error(element.place, "a <BehaviorTree> cannot stand inside another")
            return None
        if self._strict:
            check_attributes(element, self._rules, self._context.dialect)
        explicit = element.name in EXPLICIT_OR_SUBTREE
        if explicit and not element.get("ID"):
            self._rules.error(element.place, f"<{element.name}> needs the attribute 'ID'")
            return None
        name = node_name(element)
        if name == "SubTree":
            return self._subtree(element, element.get("ID") or "")
        problem = None if explicit else name_problem(name)
        if problem is not None:
            self._rules.error(element.place, f"the node name '{shortened(name)}' {problem}")
            return None
        if name not in self._registry:
            near = self._rules.hint(name, [*self._registry.names(), *EXPLICIT_OR_SUBTREE])
            others = self._registry.dialects.values()
            if mine := next((one.name for one in others if name in one.nodes), ""):
                near = f"; --dialect {mine} has it"
            elif package := missing("behaviour", name) or missing("node of a dialect", name):
                near = f"; it {package}"
            if element.children and name_problem(name) is None:
                like = "Fallback" if len(element.children) > 1 else "RetryUntilSuccessful"
                near += f"; --stub {name}={like} lets it do the same as another"
            if name in self._context.document.trees:
                near = f'; to tick the tree of that name write <SubTree ID="{name}"/>'
            place = element.place_of("ID") if explicit else element.place
            self._rules.error(place, f"no node is named '{shortened(name)}'{near}")
            return None
        cls = self._registry.get(name)
        self._check_children(element, name, cls.kind)
        if self._strict:
            check_node(element, name, cls, self._rules)
        if not explicit and "ID" in element.attributes:
            self._problems.error(
                element.place_of("ID"),
                f"<{name}> says already which node it is; it has no attribute 'ID'",
            )
        spec = self._spec_of(element, cls, name)
        for key, attribute in port_attributes(element).items():
            port = cls.ports.get(key)
            if port is None:
                self._problems.unknown(
                    attribute.place, f"{name} has no port", key, [*cls.ports, "name", *SCRIPTS]
                )
            elif self._is_valid(port, attribute):
                spec.ports[key] = attribute.value
        return spec

    def _check_children(self, element: Element, name: str, kind: NodeKind) -> None:
        count = len(element.children)
        error = None
        if kind is NodeKind.DECORATOR and count != 1:
            error = f"{name} must have exactly 1 child, not {count}"
        elif kind is NodeKind.CONTROL and count == 0:
            error = f"{name} must have at least 1 child"
        elif name == "TryCatch" and count < 2:
            error = "TryCatch must have at least 2 children"
        elif kind in (NodeKind.ACTION, NodeKind.CONDITION) and count:
            error = f"{name} cannot have children; it has {count}"
        if error is not None:
            self._rules.error(element.place, error)
        if name != "ReactiveSequence":
            return
        for child in element.children:
            if child.name in EXPLICIT:
                add = self._rules.warning if self._strict else self._rules.error
                add(
                    child.place,
                    "BehaviorTree.CPP refuses this form directly below a ReactiveSequence; "
                    f"there, write <{child.get('ID')} .../>",
                )
        asynchronous = [child for child in element.children if child.name == "AsyncSequence"]
        if len(asynchronous) > 1:
            self._rules.error(
                asynchronous[1].place,
                "a ReactiveSequence cannot have more than one AsyncSequence among its children",
            )

    def _spec_of(self, element: Element, cls: type[Node], registration: str) -> NodeSpec:
        """Read the part of an element that is the same for nodes and sub-trees."""
        spec = NodeSpec(element, cls, registration, element.get("name"))
        if any((ord(c) < 32 and c not in "\t\n\r") or ord(c) == 127 for c in spec.name or ""):
            self._problems.error(
                element.place_of("name"), "the name of a node cannot contain control characters"
            )
        for key in SCRIPTS:
            attribute = element.attributes.get(key)
            if attribute is not None:
                try:
                    spec.scripts[key] = parse_script(
                        attribute.value, double_quotes=self._context.dialect.double_quotes
                    )
                except ScriptError as error:
                    self._problems.error(attribute.value_place, f"{key}: {error}")
        return spec

    def _is_valid(self, port: Port, attribute: Attribute) -> bool:
        """Return whether a port takes the text of an attribute; report it if it does not."""
        text, type = attribute.value, port.type
        if len(text) >= 3 and text[0] == "{" and text[-1] == "}":
            return True
        if not type.strong or (type.is_enum and not self._strict):
            return True
        if type.is_enum and text in self._registry.enums:
            return True
        if type.parse is None:
            message = (
                f"port '{port.name}' takes no text, only an entry as {{key}}: "
                f"a {type.name} cannot be written as text"
            )
        else:
            try:
                type.parse(text)
            except Exception as error:  # a parser of a behaviour's own may raise anything
                message = (
                    f"port '{port.name}': {error}; expected {type.name}, or an entry as {{key}}"
                )
            else:
                return True
        self._problems.error(attribute.value_place, message)
        return False

    def _subtree(self, element: Element, tree_id: str) -> NodeSpec:
        place = element.place_of("ID")
        if element.children:
            self._rules.error(
                element.children[0].place, f'<SubTree ID="{tree_id}"> cannot have children'
            )
        problem = self._tree_name_problem(tree_id)
        if problem is not None:
            self._rules.error(place, f"the tree name '{shortened(tree_id)}' {problem}")
        elif tree_id in self._registry:
            self._rules.error(
                place,
                f"'{tree_id}' is the name of a node, not of a tree; write <{tree_id} .../>",
            )
        spec = self._spec_of(element, self._registry.get("SubTree"), "SubTree")
        remaps = {key: attribute.value for key, attribute in port_attributes(element).items()}
        spec.subtree = use = SubTreeUse(tree_id, place, remaps)
        text = element.get("_autoremap")
        if text is not None:
            try:
                use.autoremap = text if parse_boolean(text) else False
            except ValueError as error:
                use.problems.error(element.place_of("_autoremap"), f"_autoremap: {error}")
        for name, default in self._context.document.models.get(tree_id, {}).items():
            if use.autoremap or name in element.attributes:
                continue
            if default is not None and not is_port_name(name):
                continue  # such as '__shared_blackboard', which Groot writes into models
            if default is None:
                use.problems.error(
                    element.place,
                    f"the sub-tree '{tree_id}' needs the port '{name}', as its model says",
                )
            else:
                remaps[name] = default
        stubs = self._context.options.stubs
        result = stubs and stubs.result_of_tree(tree_id, self._context.document)
        if result:
            leaf = declare(tree_id, ports=list(remaps), result=result)
            keys = {key: f"{{{key}}}" for key in remaps}
            use.stub = NodeSpec(element, leaf, tree_id, ports=keys)
        else:
            self._spec.subtrees.append(tree_id)
        return spec

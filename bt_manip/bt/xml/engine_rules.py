"""BehaviorTree.CPP's own errors: the rules that the engine checks before it makes a node."""

from bt_manip.bt.nodes.binding import MAX_DEPTH
from bt_manip.bt.nodes.node import NodeKind
from bt_manip.bt.registry import name_problem
from bt_manip.bt.xml.context import ReadingContext
from bt_manip.bt.xml.document import EXPLICIT_OR_SUBTREE
from bt_manip.bt.xml.problem import hint
from bt_manip.bt.xml.source import Element, Source
from bt_manip.exceptions import shortened


def check_engine_rules(context: ReadingContext) -> None:
    """Check all files of a document by the rules of BehaviorTree.CPP.

    Without ``strict``, the forms that only the engine refuses are errors too.
    """
    document = context.document
    checks = _EngineRules(context)
    for name in document.order:
        checks.file(document.sources[name])


class _EngineRules:
    def __init__(self, context: ReadingContext) -> None:
        self._strict = context.options.strict
        self._document = context.document
        self._registry = context.registry
        self._problems = context.problems
        self._dialect = context.dialect

    def file(self, source: Source) -> None:
        root = source.root
        if root.name != "root":
            self._problems.error(
                root.place, f"the outermost element must be <root>; found <{root.name}>"
            )
            return
        models = [child for child in root.children if child.name == "TreeNodesModel"]
        for extra in models[1:]:
            self._problems.error(extra.place, "only one <TreeNodesModel> is allowed")
        if models:
            for child in root.children:
                if child.name in EXPLICIT_OR_SUBTREE and "ID" not in child.attributes:
                    self._problems.error(child.place, f"<{child.name}> needs the attribute 'ID'")
        single = len(root.children) == 1
        for child in root.children:
            if child.name == "BehaviorTree":
                self._tree(child, single)
                self._nodes(child, single)
            elif child.name not in ("include", "TreeNodesModel", *EXPLICIT_OR_SUBTREE):
                self._problems.warning(
                    child.place,
                    f"<{child.name}> has no meaning here; known: <BehaviorTree>, <include>, "
                    "<TreeNodesModel>",
                )

    def _tree(self, element: Element, single: bool) -> None:
        tree_id = element.get("ID")
        place = element.place_of("ID")
        if not tree_id and not single:
            self._problems.error(place, "<BehaviorTree> needs the attribute 'ID'")
        elif tree_id:
            problem = self._name_problem(tree_id)
            if problem is not None:
                self._problems.error(place, f"the tree name '{shortened(tree_id)}' {problem}")
            elif tree_id in self._registry:
                self._problems.error(
                    place, f"'{tree_id}' is the name of a node; a tree needs another one"
                )
        if len(element.children) != 1:
            self._problems.error(
                element.place, f"a tree has exactly 1 root, not {len(element.children)}"
            )

    def _nodes(self, tree: Element, single: bool) -> None:
        stack = [(child, 1) for child in reversed(tree.children)]
        while stack:
            node, depth = stack.pop()
            if depth > MAX_DEPTH:
                self._problems.error(node.place, f"nested deeper than {MAX_DEPTH} levels")
                return
            self._node(node, single)
            stack.extend((child, depth + 1) for child in reversed(node.children))

    def _name_problem(self, name: str) -> str | None:
        return name_problem(self._dialect.plain_name(name))

    def _node(self, element: Element, single: bool) -> None:
        count = len(element.children)
        name = element.name
        explicit = name in EXPLICIT_OR_SUBTREE
        node_id = element.get("ID") or ""
        if explicit and not node_id:
            self._problems.error(element.place, f"<{name}> needs the attribute 'ID'")
            return
        if name == "SubTree":
            self._subtree(element, node_id)
            return
        if name == "BehaviorTree":
            self._tree(element, single)  # it is refused when its place is built
            return
        lookup = node_id if explicit else name
        if not explicit:
            problem = name_problem(name)
            if problem is not None:
                self._problems.error(element.place, f"the node name '{shortened(name)}' {problem}")
                return
        if lookup not in self._registry:
            near = hint(lookup, [*self._registry.names(), *EXPLICIT_OR_SUBTREE])
            if lookup in self._document.trees:
                near = f'; to tick the tree of that name write <SubTree ID="{lookup}"/>'
            place = element.place_of("ID") if explicit else element.place
            self._problems.error(place, f"no node is named '{shortened(lookup)}'{near}")
            return
        kind = self._registry.get(lookup).kind
        if kind is NodeKind.DECORATOR and count != 1:
            self._problems.error(element.place, f"{lookup} must have exactly 1 child, not {count}")
        elif kind is NodeKind.CONTROL:
            if count == 0:
                self._problems.error(element.place, f"{lookup} must have at least 1 child")
            elif lookup == "TryCatch" and count < 2:
                self._problems.error(element.place, "TryCatch must have at least 2 children")
            elif lookup == "ReactiveSequence":
                self._reactive(element)
        elif kind in (NodeKind.ACTION, NodeKind.CONDITION) and count:
            self._problems.error(element.place, f"{lookup} cannot have children; it has {count}")

    def _reactive(self, element: Element) -> None:
        for child in element.children:
            if child.name in EXPLICIT_OR_SUBTREE and child.name != "SubTree":
                add = self._problems.warning if self._strict else self._problems.error
                add(
                    child.place,
                    "BehaviorTree.CPP refuses this form directly below a ReactiveSequence; "
                    f"there, write <{child.get('ID')} .../>",
                )
        asynchronous = [c for c in element.children if c.name == "AsyncSequence"]
        if len(asynchronous) > 1:
            self._problems.error(
                asynchronous[1].place,
                "a ReactiveSequence cannot have more than one AsyncSequence among its children",
            )

    def _subtree(self, element: Element, tree_id: str) -> None:
        if element.children:
            self._problems.error(
                element.children[0].place, f'<SubTree ID="{tree_id}"> cannot have children'
            )
        problem = self._name_problem(tree_id)
        if problem is not None:
            self._problems.error(
                element.place_of("ID"), f"the tree name '{shortened(tree_id)}' {problem}"
            )
        elif tree_id in self._registry:
            self._problems.error(
                element.place_of("ID"),
                f"'{tree_id}' is the name of a node, not of a tree; write <{tree_id} .../>",
            )

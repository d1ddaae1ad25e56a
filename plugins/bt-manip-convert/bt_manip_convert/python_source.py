"""Writing a document as Python source that builds the same document."""

import keyword
import re
import sys
from collections.abc import Collection, Sequence
from typing import Any, Final

from bt_manip.bt import (
    CONDITIONS,
    BehaviourRegistry,
    Document,
    Element,
    Node,
    Reading,
    Stubs,
    SubTree,
    declare,
    editor_attributes,
    node_name,
    parse_goal,
    port_attributes,
    write_element,
)
from bt_manip.exceptions import TreeError

_GOAL: Final = "_goal"
_WIDTH = 100
_MAX_BRACKETS: Final = 200  # brackets in brackets that Python's tokenizer reads
_PYTHON_OF: Final = {attribute: name for name, attribute in CONDITIONS.items()}
"""Keywords of the scripts around a tick, by their attributes."""


def to_python(reading: Reading, stubs: Stubs | None = None) -> str:
    """Write a document as a Python module.

    The module has a function for each tree, and ``document()``, from which
    `bt_manip.bt.tree_to_xml` makes the same document again.

    Args:
        reading: A document that was read without errors, with the behaviours that it names.
        stubs: Placeholders for unknown sub-trees with which it was read.

    Returns:
        The source of the module.

    Raises:
        TreeError: If a behaviour's class cannot be imported by its name, or a tree is nested
            deeper than Python source can be.
    """
    assert reading.document is not None
    return _Writer(reading.document, reading.registry, stubs).module()


class _Writer:
    def __init__(
        self, document: Document, registry: BehaviourRegistry, stubs: Stubs | None
    ) -> None:
        self._document = document
        self._stubs = stubs
        self._registry = registry
        self._imports: dict[str, set[str]] = {}
        self._reached = self._reached_trees()
        self._functions = self._function_names()
        self._declared: dict[str, tuple[str, str]] = {}

    def _reached_trees(self) -> dict[str, Element]:
        """Return the document's own trees, and the library trees that they use."""
        trees = self._document.trees
        own = self._document.source.root.children
        reached = {tree_id: tree for tree_id, tree in trees.items() if tree in own}
        waiting = list(reached.values())
        while waiting:
            for element in waiting.pop().iterate():
                tree_id = element.get("ID") or ""
                if element.name == "SubTree" and tree_id in trees and tree_id not in reached:
                    reached[tree_id] = trees[tree_id]
                    waiting.append(trees[tree_id])
        return reached

    def _function_names(self) -> dict[str, str]:
        names: dict[str, str] = {}
        for tree_id in self._reached:
            base = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", tree_id).lower()
            base = re.sub(r"[^a-z0-9_]", "_", base)
            base = base if base[:1].isalpha() else f"tree_{base}"
            if keyword.iskeyword(base) or base in ("document", "as_written"):
                base += "_tree"
            names[tree_id] = _unused(base, names.values())
        return names

    def module(self) -> str:
        functions = [self._function(tree_id, element) for tree_id, element in self._reached.items()]
        whole = self._document_function()
        imports = [
            f"from {module} import {', '.join(sorted(names))}"
            if len(names) == 1
            else f"from {module} import (\n"
            + "".join(f"    {name},\n" for name in sorted(names))
            + ")"
            for module, names in sorted(self._imports.items())
        ]
        main = self._document.main_tree()
        title = f"The tree {main}." if main else "Trees."
        head = f'"""{_escaped(title)}"""\n\n' + "\n".join(imports)
        if self._declared:
            head += "\n\n" + "\n".join(text for _, text in sorted(self._declared.values()))
        return "\n\n\n".join([head, *functions, whole]) + "\n"

    def _use(self, name: str, module: str = "bt_manip.bt") -> str:
        self._imports.setdefault(module, set()).add(name)
        return name

    def _function(self, tree_id: str, element: Element) -> str:
        node = self._use("Node")
        root = self._node(element.children[0])
        if root.nesting > _MAX_BRACKETS:
            raise TreeError(
                f"{element.place}: the tree '{tree_id}' is nested too deep for Python: "
                f"{root.nesting} brackets in each other, at most {_MAX_BRACKETS}; "
                "make a part of it a sub-tree"
            )
        call = _layout(root, 1)
        return (
            f"def {self._functions[tree_id]}() -> {node}:\n"
            f'    """Build the tree {_escaped(tree_id)}."""\n'
            f"    return {call}"
        )

    def _document_function(self) -> str:
        source = self._document.source
        ids = {id(element): tree_id for tree_id, element in self._document.trees.items()}
        content: list[Any] = []
        for item in source.root.content:
            if isinstance(item, Element) and id(item) in ids:
                content.append(self._definition(ids[id(item)], item))
            elif isinstance(item, Element):
                content.append(_Call(self._use("Raw"), [_text(write_element(item))]))
            else:
                content.append(self._comment(item))
        arguments: list[Any] = [_list(content)]
        attributes = {a.name: a.value for a in source.root.attributes.values()}
        arguments.append(("attributes", _text(attributes)))
        arguments += self._comments("before", source.prologue)
        arguments += self._comments("after", source.epilogue)
        call = _layout(_Call(self._use("TreeDocument"), arguments), 1)
        return (
            "def document() -> TreeDocument:\n"
            '    """Build the whole document."""\n'
            f"    return {call}"
        )

    def _definition(self, tree_id: str, element: Element) -> Any:
        named = element.get("ID") is not None
        arguments: list[Any] = [_text(tree_id if named else ""), f"{self._functions[tree_id]}()"]
        others = {
            a.name: a.value for a in element.attributes.values() if a.name not in ("ID", _GOAL)
        }
        if others:
            arguments.append(("attributes", _text(others)))
        index = element.content.index(element.children[0])
        arguments += self._comments("before", element.content[:index])
        arguments += self._comments("after", element.content[index + 1 :])
        goal = element.get(_GOAL)
        if goal is not None:
            conditions = parse_goal(goal, self._registry)
            arguments.append(("goal", _list([self._condition(item) for item in conditions])))
        return _Call(self._use("TreeDefinition"), arguments)

    def _condition(self, condition: Node) -> Any:
        ports = condition.ports
        given = [
            (ports[name].attribute, _value(ports[name], text))
            for name in condition.given
            if (text := condition.port_text(name)) is not None
        ]
        return _Call(self._class(condition.registration, type(condition)), given)

    def _comments(self, name: str, items: Sequence[Any]) -> list[Any]:
        """Return comments as an argument of this name; none if there are none."""
        return [(name, _list([self._comment(item) for item in items]))] if items else []

    def _comment(self, item: Any) -> Any:
        if getattr(item, "kind", "") == "instruction":
            return _Call(self._use("Raw"), [_text(item.text)])
        kind = [] if hasattr(item, "kind") else [("kind", _text("text"))]  # text between tags
        return _Call(self._use("Comment"), [_text(item.text), *kind])

    def _node(self, element: Element) -> Any:
        arguments: list[Any] = []
        name = element.get("name")
        if name is not None:
            arguments.append(_text(name))
        if element.name == "SubTree":
            call = self._subtree(element, arguments)
        else:
            registered = node_name(element)
            cls = self._registry.get(registered)
            children = [
                self._node(item) if isinstance(item, Element) else self._comment(item)
                for item in (element.content if element.children else ())
            ]
            if len(children) == 1:
                arguments.append(children[0])
            elif children:
                arguments.append(_list(children))
            arguments += self._ports(element, cls)
            call = _Call(self._class(registered, cls), arguments)
        return self._written(element, call)

    def _written(self, element: Element, call: Any) -> Any:
        extra: list[Any] = []
        if element.name != node_name(element):
            extra.append(("tag", _text(element.name)))
        others = editor_attributes(element)
        if others:
            extra.append(("attributes", _text(others)))
        if not element.children:
            extra += self._comments("comments", element.content)
        if not extra:
            return call
        return _Call(self._use("as_written"), [call, *extra])

    def _subtree(self, element: Element, arguments: list[Any]) -> Any:
        tree_id = element.get("ID") or ""
        result = None
        if self._stubs is not None:
            result = self._stubs.result_of_tree(tree_id, self._document)
        if result is None and tree_id in self._functions:
            arguments.append(f"{self._functions[tree_id]}()")
        elif result is not None:
            cls = declare(tree_id, result=result)
            arguments.append(f"{self._declaration(tree_id, cls)}()")
        arguments.append(("tree_id", _text(tree_id)))
        remaps = {name: a.value for name, a in port_attributes(element).items()}
        if remaps:
            arguments.append(("remap", _text(remaps)))
        autoremap = element.get("_autoremap")
        if autoremap is not None:
            arguments.append(("autoremap", _text(autoremap)))
        arguments += self._scripts(element)
        return _Call(self._use("SubTree"), arguments)

    def _ports(self, element: Element, cls: type[Node]) -> list[Any]:
        arguments: list[Any] = []
        for name, attribute in port_attributes(element).items():
            port = cls.ports.get(name)
            if port is not None:
                arguments.append((port.attribute, _value(port, attribute.value)))
        return arguments + self._scripts(element)

    def _scripts(self, element: Element) -> list[Any]:
        return [
            (_PYTHON_OF[a.name], _text(a.value))
            for a in element.attributes.values()
            if a.name in _PYTHON_OF
        ]

    def _class(self, name: str, cls: type[Node]) -> str:
        if hasattr(cls, "declaration"):
            return self._declaration(name, cls)
        if cls is SubTree or "<" in cls.__qualname__ or "." in cls.__qualname__:
            raise TreeError(f"the class of '{name}' cannot be imported: {cls.__qualname__}")
        return self._use(cls.__name__, _shortest_module(cls))

    def _declaration(self, name: str, cls: type[Node]) -> str:
        """Declare a stub at the top of the module, and give its name in Python."""
        if name in self._declared:
            return self._declared[name][0]
        base = re.sub(r"\W", "_", name)
        base = base if base[:1].isalpha() else f"node_{base}"
        taken = {variable for variable, _ in self._declared.values()}
        taken |= {*self._functions.values(), *dir(sys.modules["bt_manip.bt"]), "document"}
        variable = _unused(base, taken | {*keyword.kwlist})
        given: dict[str, Any] = cls.declaration  # type: ignore[attr-defined]
        arguments: list[Any] = [_text(name), _text(given["kind"])]
        if given["ports"]:
            arguments.append(_list([_text(port) for port in given["ports"]]))
        if given["result"] != "SUCCESS":
            arguments.append(("result", _text(given["result"])))
        if given["like"] is not None:
            arguments.append(("like", self._class(given["like"].registration, given["like"])))
        call = _layout(_Call(self._use("declare"), arguments), 0)
        self._declared[name] = (variable, f"{variable} = {call}")
        return variable


def _unused(base: str, taken: Collection[str]) -> str:
    name, count = base, 2
    while name in taken:
        name, count = f"{base}_{count}", count + 1
    return name


def _escaped(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"')


def _shortest_module(cls: type[Node]) -> str:
    """Return the shortest of the packages around a class that hands the class on."""
    names = cls.__module__.split(".")
    for count in range(1, len(names)):
        package = sys.modules.get(".".join(names[:count]))
        if getattr(package, cls.__name__, None) is cls:
            return ".".join(names[:count])
    return cls.__module__


class _Call:
    """A call in Python source; `nesting` counts the brackets around its innermost argument."""

    def __init__(self, name: str, arguments: list[Any], brackets: str = "()") -> None:
        self.opening, self.arguments, self.closing = name + brackets[0], arguments, brackets[1]
        values = [item[1] if isinstance(item, tuple) else item for item in arguments]
        self.nesting: int = 1 + max((getattr(value, "nesting", 0) for value in values), default=0)


def _list(items: list[Any]) -> _Call:
    return _Call("", items, "[]")


def _value(port: Any, text: str) -> str:
    """Write a literal as a Python number or truth value, where that gives the same text again."""
    kind = port.type
    if kind.python in (int, float, bool) and kind.parse is not None and kind.format is not None:
        try:
            value = kind.parse(text)
        except ValueError:
            return _text(text)
        if kind.format(value) == text:
            return repr(value)
    return _text(text)


def _text(value: str | dict[str, str]) -> str:
    """Write a text, or texts by name, with double quotes where they do not need escaping."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_text(k)}: {_text(v)}" for k, v in value.items()) + "}"
    plain = repr(value)
    if plain[0] == "'" and '"' not in value:
        return '"' + plain[1:-1].replace("\\'", "'") + '"'
    return plain


def _flat(item: Any) -> str:
    if isinstance(item, tuple):
        return f"{item[0]}={_flat(item[1])}"
    if isinstance(item, _Call):
        return item.opening + ", ".join(map(_flat, item.arguments)) + item.closing
    return str(item)


def _layout(item: Any, depth: int) -> str:
    """Write a call on one line, or with an argument a line where it is too long."""
    flat = _flat(item)
    if len(flat) + 4 * depth + 8 <= _WIDTH and "\n" not in flat:
        return flat
    if isinstance(item, tuple):
        return f"{item[0]}={_layout(item[1], depth)}"
    if not isinstance(item, _Call) or not item.arguments:
        return flat
    indent = "    " * (depth + 1)
    lines = [f"{indent}{_layout(argument, depth + 1)}," for argument in item.arguments]
    return "\n".join([item.opening, *lines, "    " * depth + item.closing])

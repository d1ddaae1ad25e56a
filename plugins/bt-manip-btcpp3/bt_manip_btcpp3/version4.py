"""Writing documents of version 3, once read, as documents of version 4."""

import re
from collections.abc import Iterator

from bt_manip.bt import Document, Element, Problems, is_pointer, node_name

CALM = frozenset(
    "BehaviorTree Sequence Fallback SequenceStar Inverter ForceSuccess ForceFailure Repeat "
    "RetryUntilSuccessful KeepRunningUntilFailure IfThenElse Delay SubTree".split()
)
"""Nodes that neither halt a running child nor tick others before it; all others are restless."""

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")


def to_version_4(root: Element, document: Document, problems: Problems) -> None:
    """Rewrite a file that was read as version 3.

    Errors are what version 4 cannot say. Warnings are where it ticks a leaf more or less often, or
    later; without them the leaves are ticked as before.
    """
    root.set("BTCPP_format", "4")
    root.attributes = {"BTCPP_format": root.attributes.pop("BTCPP_format"), **root.attributes}
    restless = _restless_trees(document)
    for tree in root.children:
        if tree.name == "BehaviorTree":
            disturbed = tree.get("ID") in restless
            for element, inside in _nodes(tree, disturbed):
                _convert(element, inside, document, problems)
        elif tree.name == "TreeNodesModel":
            _convert_models(tree, document)


def _nodes(element: Element, disturbed: bool) -> Iterator[tuple[Element, bool]]:
    """Yield the elements below one, the last ones first, and whether a restless node is above."""
    disturbed = disturbed or node_name(element) not in CALM
    for child in element.children:
        yield from _nodes(child, disturbed)
        yield child, disturbed


def _restless_trees(document: Document) -> set[str]:
    """Return the trees that are used below a restless node, directly or not."""
    found: set[str] = set()
    while True:
        more = {
            element.get("ID") or ""
            for tree_id, tree in document.trees.items()
            for element, disturbed in _nodes(tree, tree_id in found)
            if disturbed and element.name == "SubTree"
        }
        if more <= found:
            return found
        found |= more


def _convert(element: Element, disturbed: bool, document: Document, problems: Problems) -> None:
    name = node_name(element)
    if name == "SequenceStar":
        rename(element, "SequenceWithMemory")
        if disturbed:
            problems.warning(
                element.place,
                "a SequenceWithMemory that was halted goes on where it was, and it pauses after "
                "each child, so that nodes around it are ticked in between",
            )
    elif name in ("Repeat", "RetryUntilSuccessful") and disturbed:
        problems.warning(
            element.place, f"{name} pauses after each round, so that nodes around it are ticked"
        )
    elif name == "Parallel":
        _parallel(element, problems)
    elif name.startswith("BlackboardCheck"):
        _check(element, name, problems)
    elif name == "SetBlackboard" and is_pointer(element.get("value") or ""):
        problems.warning(
            element.place, "SetBlackboard fails in version 4 where the other entry was not written"
        )
    elif name == "SubTree":
        _sub_tree(element, document, problems)


def rename(element: Element, name: str) -> None:
    """Change the name of an element's node."""
    if element.name == node_name(element):
        element.name = name
    else:
        element.set("ID", name)


def _parallel(element: Element, problems: Problems) -> None:
    count = len(element.children)
    old = element.attributes.pop("threshold", None)
    needed = element.get("success_threshold") if old is None else old.value
    tolerated = element.attributes.pop("failure_threshold", None)
    element.attributes.pop("success_threshold", None)
    failures = tolerated.value if tolerated is not None else "1"
    if old is not None:
        if is_pointer(old.value):
            problems.error(old.place, "version 4 cannot derive failure_count from an entry")
            return
        failures = str(count + 1 - _number(old.value, count))
    if "0" in (needed, failures):
        problems.error(element.place, "a threshold of 0 is never reached in version 3")
    element.set("success_count", needed or "")
    if failures != "1":
        element.set("failure_count", failures)
    if is_pointer(needed or "") or _number(needed or "", count) != count:
        problems.warning(
            element.place,
            "version 3 counts the children in their order, and may tick some more before the "
            "verdict",
        )


def _number(text: str, count: int) -> int:
    try:
        number = int(text)
    except ValueError:
        return 0
    return count + 1 + number if number < 0 else number


def _check(element: Element, name: str, problems: Problems) -> None:
    values = []
    for key in ("value_A", "value_B"):
        text = element.get(key) or ""
        element.attributes.pop(key, None)
        if is_pointer(text):
            values.append(text[1:-1])
        elif name == "BlackboardCheckString":
            values.append(f"'{text}'")
        else:
            values.append(text)
    result = element.attributes.pop("return_on_mismatch", None)
    rename(element, "Precondition")
    element.set("if", " == ".join(values))
    element.set("else", result.value if result is not None else "FAILURE")
    problems.warning(
        element.place,
        "a Precondition is not tested again while its child runs, and an entry that is missing is "
        "an error of the tree",
    )


def _sub_tree(element: Element, document: Document, problems: Problems) -> None:
    if "__outside" in element.attributes:
        problems.error(
            element.place,
            "version 3 writes the constants after '__autoremap' to the caller's entries; put "
            "'__autoremap' after them, or set the entries before",
        )
    for key, attribute in element.attributes.items():
        if key[0] != "_" and _NUMBER.fullmatch(attribute.value):
            problems.warning(
                attribute.value_place,
                f"{key}={attribute.value} is a number in version 4, a text in version 3",
            )
    shared = element.attributes.pop("__shared_blackboard", None)
    if shared is not None:
        for key in [*element.attributes]:
            if key[0] != "_" and key != "ID":
                del element.attributes[key]  # it has no meaning there
        element.set("_autoremap", "true")
    if "_autoremap" not in element.attributes:
        return
    inner = document.trees.get(element.get("ID") or "")
    for inside in () if inner is None else inner.iterate():
        for attribute in inside.attributes.values():
            private = attribute.value.startswith("{_")
            if private or (attribute.name == "output_key" and attribute.value.startswith("_")):
                problems.error(
                    attribute.value_place,
                    f"a key that starts with '_' is not remapped automatically in version 4; the "
                    f"<SubTree> of {element.place} does that",
                )


def _convert_models(models: Element, document: Document) -> None:
    """Drop defaults of sub-trees, which version 4 would apply, and ports that some use lacks."""
    uses: dict[str, list[Element]] = {}
    for tree in document.trees.values():
        for element in tree.iterate():
            if element.name == "SubTree":
                uses.setdefault(element.get("ID") or "", []).append(element)
    for model in models.children:
        if model.name in ("SubTree", "SubTreePlus"):
            model.name = "SubTree"
            for port in model.children:
                port.attributes.pop("default", None)
                key = port.get("name") or ""
                users = uses.get(model.get("ID") or "", [])
                if key[:1] == "_" or any(key not in use.attributes for use in users):
                    model.content.remove(port)
        elif model.get("ID") == "SequenceStar":
            models.content.remove(model)

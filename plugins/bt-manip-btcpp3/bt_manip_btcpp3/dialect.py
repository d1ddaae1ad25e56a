"""How documents of BehaviorTree.CPP 3 are recognised and read."""

import re

from bt_manip.bt import (
    Dialect,
    Document,
    Element,
    Problems,
    is_pointer,
    node_name,
    port_attributes,
)
from bt_manip_btcpp3 import nodes
from bt_manip_btcpp3.version4 import rename, to_version_4

NODES = {
    name: cls
    for name, cls in vars(nodes).items()
    if getattr(cls, "__module__", "") == nodes.__name__ and name[0].isupper()
}
ONLY_4 = frozenset(
    "AsyncFallback AsyncSequence LoopBool LoopDouble LoopInt LoopString ParallelAll Precondition "
    "RunOnce Script ScriptCondition SequenceWithMemory SkipUnlessUpdated Sleep TryCatch "
    "UnsetBlackboard WaitValueUpdate WasEntryUpdated".split()
)
"""Nodes that version 3.8 lacks; where a document names them, they are those of its project."""

FORMER = {"RetryUntilSuccesful": "RetryUntilSuccessful", "FallbackStar": "Fallback"}
"""Names of versions 3.0 to 3.5."""

THRESHOLDS = ("threshold", "success_threshold", "failure_threshold")
FLAGS = ("__shared_blackboard", "__autoremap")
SCRIPTS = frozenset(
    "_successIf _failureIf _skipIf _while _onSuccess _onFailure _onHalted _post _autoremap".split()
)
"""Attributes to which version 4 gives a meaning, and version 3 does not."""

_NEGATIVE = re.compile(r"-[0-9]{1,9}$")
_PLAIN = re.compile(r"[A-Za-z_][\w-]*")
_POINTER = re.compile(r"\$(\{.+\})")


def trait_of(element: Element) -> str:
    """Return a trait that only documents of version 3 have, or an empty text."""
    name = node_name(element)
    if name in FORMER or name == "SequenceStar" or name.startswith("BlackboardCheck"):
        return f"<{name}>"
    if name == "SubTreePlus":
        return "<SubTreePlus>"
    if name == "Parallel":
        return next((f"Parallel's '{key}'" for key in THRESHOLDS if key in element.attributes), "")
    if name == "SubTree":
        if flag := next((flag for flag in FLAGS if flag in element.attributes), ""):
            return f"'{flag}'"
        for key, attribute in port_attributes(element).items():
            if not is_pointer(text := attribute.value):
                return f"{key}=\"{text}\", by which version 3 means the entry '{text}'"
    return ""


def is_version_3(root: Element, problems: Problems) -> bool:
    """Return whether a document is of version 3, and warn of it.

    One with another ``BTCPP_format`` than 4 is; so is one without, if it has a trait of version 3
    and none of version 4.
    """
    form = root.get("BTCPP_format")
    if form == "4":
        return False
    trees = [child for child in root.children if child.name == "BehaviorTree"]
    elements = [element for tree in trees for element in tree.iterate()]
    if form is None and any(e.attributes.keys() & SCRIPTS for e in elements):
        return False
    found = ((trait_of(element), element.place) for element in elements)
    trait, place = next((one for one in found if one[0]), ("", root.place))
    if form is None and not trait:
        return False
    why = f'BTCPP_format="{form}"' if form is not None else f'no BTCPP_format="4", but {trait}'
    problems.warning(
        place,
        f"{why}: read as BehaviorTree.CPP 3 (--dialect btcpp-3); 'bt-manip tree convert --to xml' "
        "writes version 4",
    )
    return True


def translate(root: Element, document: Document, problems: Problems) -> None:
    """Rewrite nodes of this dialect as nodes of version 4 with the same meaning."""
    if root.get("BTCPP_format") == "4":
        problems.error(root.place_of("BTCPP_format"), "this file is of version 4, not of version 3")
        return
    main = document.main_tree()
    for tree_id in [*document.models]:
        if tree_id != main:  # version 3 does not read them; those of the main tree are for --set
            del document.models[tree_id]
    for tree in root.children:
        if tree.name == "BehaviorTree":
            for element in tree.iterate():
                if element is not tree:
                    _translate(element, document, problems)


def _translate(element: Element, document: Document, problems: Problems) -> None:
    for key, attribute in element.attributes.items():
        if key in ("msec", "delay_msec") and _NEGATIVE.match(attribute.value):
            attribute.value = str(int(attribute.value) % 2**32)  # as the conversion of C does
        attribute.value = _POINTER.sub(r"\1", attribute.value)
        if key in SCRIPTS:
            problems.error(attribute.place, f"'{key}' is no port: version 4 reserves this name")
        if attribute.value.startswith("{@"):
            problems.error(
                attribute.value_place, "a key that starts with '@' is of the root in version 4"
            )
    name = node_name(element)
    if name == "ReactiveSequence":
        for child in element.children:  # version 4 refuses <Action ID="..."> there
            if child.name != node_name(child) and _PLAIN.fullmatch(node_name(child)):
                child.name = child.attributes.pop("ID").value
    if name in FORMER:
        rename(element, FORMER[name])
    elif name == "Parallel" and not element.attributes.keys() & {*THRESHOLDS[:2]}:
        problems.error(element.place, "Parallel needs the port 'success_threshold'")
    elif name == "WhileDoElse" and len(element.children) != 3:
        problems.error(element.place, "WhileDoElse has 3 children in version 3")
    elif element.name in ("SubTree", "SubTreePlus"):
        _sub_tree(element, problems)
    elif element.name != name and name in document.trees:
        element.name = "SubTree"
        _sub_tree(element, problems)


def _sub_tree(element: Element, problems: Problems) -> None:
    plus, element.name = element.name == "SubTreePlus", "SubTree"
    element.attributes.pop("name", None)  # the engine takes the ID
    ports, given, element.attributes = port_attributes(element), element.attributes, {}
    outside = []
    for key, attribute in given.items():
        if key == FLAGS[not plus]:
            problems.warning(attribute.place, f"'{key}' means nothing in this element")
            continue
        if key == FLAGS[plus]:
            if attribute.value not in ("1", "true", "TRUE", "True"):
                continue
            attribute.name = "_autoremap" if plus else key
        elif key in ("ID", "_description"):
            pass
        elif key not in ports:
            problems.error(attribute.place, f"'{key}' cannot be the key of a sub-tree in version 4")
        elif not plus:
            if is_pointer(attribute.value):
                problems.warning(
                    attribute.value_place,
                    f"a <SubTree> of version 3 has no braces: this is the entry "
                    f"'{attribute.value}', braces included",
                )
            attribute.value = f"{{{attribute.value}}}"
        elif "_autoremap" in element.attributes and not is_pointer(attribute.value):
            outside.append(key)
        element.attributes[attribute.name] = attribute
    if outside:
        element.set(nodes.OUTSIDE, " ".join(outside))


BTCPP3 = Dialect(
    "btcpp-3",
    "BehaviorTree.CPP 3",
    nodes=NODES,
    without=ONLY_4,
    attributes=frozenset({*FLAGS, nodes.OUTSIDE}),
    recognises=is_version_3,
    translate=translate,
    to_version_4=to_version_4,
)

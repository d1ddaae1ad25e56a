"""What a node carries only for people and editors: comments, and the form it was written in."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from bt_manip.bt.nodes.node import Node


@dataclass(frozen=True)
class Comment:
    """A comment among the children of a node, in Python as in a document.

    Attributes:
        text: What stands between ``<!--`` and ``-->``.
        kind: ``comment``; or ``text`` for text, which the tree language ignores.
    """

    text: str
    kind: str = "comment"


NodeT = TypeVar("NodeT", bound="Node")


def as_written(
    node: NodeT,
    *,
    tag: str | None = None,
    attributes: Mapping[str, str] | None = None,
    comments: Sequence[Comment] = (),
) -> NodeT:
    """Let a node keep the form that it has in a document.

    Args:
        node: The node.
        tag: The element, where it is not the node's own name: ``Action`` for ``<Action ID=...>``.
        attributes: Attributes that only editors know, such as ``_collapsed``.
        comments: Comments inside the element of a leaf, or after the last child.

    Returns:
        The same node.
    """
    node.tag = tag
    node.attributes = dict(attributes or {})
    node.remarks = [*node.remarks, *((len(node.children), comment) for comment in comments)]
    return node

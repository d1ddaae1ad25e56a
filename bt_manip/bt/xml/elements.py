"""What a document consists of: elements, attributes, comments and texts, each with its place."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from bt_manip.bt.xml.problem import Place


@dataclass
class Attribute:
    """An attribute of an element, with the places of its name and of its value."""

    name: str
    value: str
    place: Place
    value_place: Place
    well_formed: bool = True


@dataclass
class SourceComment:
    """A comment; also a processing instruction, with ``<?`` and ``?>`` around it.

    ``spaced`` tells that an empty line stands before it, here and in an element.
    """

    text: str
    place: Place
    kind: str = "comment"
    spaced: bool = False


@dataclass
class Text:
    """Text between tags; the tree language ignores it, and writing keeps it."""

    text: str
    place: Place


@dataclass
class Element:
    """An element of a document."""

    name: str
    place: Place
    attributes: dict[str, Attribute] = field(default_factory=dict)
    content: "list[Element | SourceComment | Text]" = field(default_factory=list)
    spaced: bool = False

    @property
    def children(self) -> "list[Element]":
        """The elements directly below."""
        return [item for item in self.content if isinstance(item, Element)]

    def get(self, name: str) -> str | None:
        """Give the value of an attribute, or None."""
        attribute = self.attributes.get(name)
        return None if attribute is None else attribute.value

    def place_of(self, name: str) -> Place:
        """Give the place of an attribute, or of the element if it does not have it."""
        attribute = self.attributes.get(name)
        return self.place if attribute is None else attribute.place

    def iterate(self) -> "Iterator[Element]":
        """Iterate over this element and all elements below, from top to bottom."""
        stack = [self]
        while stack:
            element = stack.pop()
            yield element
            stack.extend(reversed(element.children))


@dataclass
class Source:
    """A parsed document: its root element, and what stands before and after it."""

    root: Element
    prologue: list[SourceComment | Text] = field(default_factory=list)
    epilogue: list[SourceComment | Text] = field(default_factory=list)

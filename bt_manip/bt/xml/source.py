"""Reading XML with the place of every tag and attribute.

The parser keeps comments, order and places, and is as lenient as the engine's: ``&&`` and ``<`` may
stand in attribute values as they are, since many trees are written so, and line breaks in values
stay line breaks. It expands nothing but characters: documents with a document type, and so with
entities of their own, are refused.
"""

import re
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final

from bt_manip.bt.xml.problem import Place, Problems
from bt_manip.exceptions import TreeError

NOWHERE: Final = Place("<tree>", 1, 1)
"""The place of elements that were not read from a file."""

MAX_CHARACTERS: Final = 16_000_000
MAX_NESTING: Final = 498  # of the engine's parser
MAX_ELEMENTS: Final = 70_000  # of a document, with comments; a tree has at most 65,535 nodes
MAX_ATTRIBUTES: Final = 1_000  # of an element

# Excluding characters of ASCII compiles in a fiftieth of the time of including the others.
_NAME: Final = r"[^\x00-9;-@\[-^`{-\x7f][^\x00-,/;-@\[-^`{-\x7f]*"
"""Letters, digits, ``_:.-`` and all above ASCII; the first is no digit, no ``.``, no ``-``."""
_ATTRIBUTE: Final = re.compile(
    rf"\s*(?P<name>{_NAME})(?P<equals>\s*=\s*)?(?:\"(?P<double>[^\"]*)\"|'(?P<single>[^']*)')?"
)
_TAG_START: Final = re.compile(rf"<(?P<close>/?)(?P<name>{_NAME})")
_TAG_END: Final = re.compile(r"\s*(?P<empty>/?)>")
_REFERENCE: Final = re.compile(
    r"&(?:#(?P<dec>[0-9]{1,7})|#x(?P<hex>[0-9a-fA-F]{1,6})|(?P<name>\w+));"
)
_ENTITIES: Final = {"lt": "<", "gt": ">", "amp": "&", "quot": '"', "apos": "'"}


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
    """An element of a document; `tag` is how it was written, if it has no content."""

    name: str
    place: Place
    attributes: dict[str, Attribute] = field(default_factory=dict)
    content: "list[Element | SourceComment | Text]" = field(default_factory=list)
    spaced: bool = False
    tag: str = field(default="", compare=False, repr=False)

    @property
    def children(self) -> "list[Element]":
        """The elements directly below."""
        return [item for item in self.content if isinstance(item, Element)]

    def set(self, name: str, value: str) -> None:
        """Set the value of an attribute."""
        self.attributes[name] = Attribute(name, value, self.place, self.place)

    def get(self, name: str) -> str | None:
        """Return the value of an attribute, or None."""
        attribute = self.attributes.get(name)
        return None if attribute is None else attribute.value

    def place_of(self, name: str) -> Place:
        """Return the place of an attribute, or of the element if it does not have it."""
        attribute = self.attributes.get(name)
        return self.place if attribute is None else attribute.place

    def iterate(self) -> "Iterator[Element]":
        """Iterate over this element and all elements below, from top to bottom."""
        stack = [self]
        while stack:
            element = stack.pop()
            yield element
            stack.extend(reversed(element.children))


def make_element(name: str, attributes: Mapping[str, str] | None = None) -> Element:
    """Make an element that was not read from a file."""
    element = Element(name, NOWHERE)
    for key, value in (attributes or {}).items():
        element.set(key, value)
    return element


@dataclass
class Source:
    """A parsed document: its root element, and the items before and after it.

    `findings` are those of the translation from its dialect; None before that.
    """

    root: Element
    prologue: list[SourceComment | Text] = field(default_factory=list)
    epilogue: list[SourceComment | Text] = field(default_factory=list)
    findings: Problems | None = None


class XmlError(TreeError):
    """A document that is not well-formed: the place of the error, and why."""

    def __init__(self, place: Place, reason: str) -> None:
        super().__init__(f"{place}: error: {reason}")
        self.place = place
        self.reason = reason


def decode(data: bytes, file: str) -> str:
    """Decode the bytes of a document; raise an `XmlError` if it is not UTF-8."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start].decode("utf-8-sig", "replace")
        line = before.count("\n") + 1
        column = len(before) - before.rfind("\n")
        place = Place(file, line, column)
        raise XmlError(place, f"not UTF-8: {error.reason}") from None


def parse_source(text: str, file: str = "<text>") -> Source:
    """Parse a document to a tree of elements, with places in `file`.

    An `XmlError` is raised for what is not well-formed, or larger or deeper than it may be.
    """
    return _Parser(text.removeprefix("\ufeff"), file).parse()


class _Parser:
    def __init__(self, text: str, file: str) -> None:
        self._text = text
        self._file = file
        self._spaced = False
        self._lines = [0]
        self._lines += [found.end() for found in re.finditer("\n", text)]
        self._source = Source(Element("", self._place(0)))
        self._open: list[Element] = []  # the elements around the position
        self._count = 0  # of elements, comments and texts
        self._done = False  # whether the root element is closed

    def _place(self, position: int) -> Place:
        line = bisect_right(self._lines, position)
        return Place(self._file, line, position - self._lines[line - 1] + 1)

    def _error(self, position: int, reason: str) -> XmlError:
        return XmlError(self._place(position), reason)

    def parse(self) -> Source:
        text = self._text
        if len(text) > MAX_CHARACTERS:
            raise self._error(0, f"the document has more than {MAX_CHARACTERS} characters")
        if "\0" in text:
            raise self._error(text.index("\0"), "a NUL character is no part of XML")
        position = 0
        while position < len(text):
            start = text.find("<", position)
            self._spaced = False
            self._add_text(position, len(text) if start < 0 else start)
            if start < 0:
                break
            if text.startswith("<!--", start):
                position = self._close(start, "-->", "the comment is not closed", 4)
                body = text[start + 4 : position - 3]
                self._add(SourceComment(body, self._place(start), spaced=self._spaced))
            elif text.startswith("<![CDATA[", start):
                if not self._open:
                    raise self._error(start, "text stands outside of the root element")
                position = self._close(start, "]]>", "the CDATA section is not closed")
                self._add(Text(text[start + 9 : position - 3], self._place(start)))
            elif text.startswith("<!", start):
                raise self._error(
                    start, "document types and entities are not allowed in tree documents"
                )
            elif text.startswith("<?", start):
                position = self._close(start, "?>", "the processing instruction is not closed")
                self._add_instruction(start, position)
            else:
                tag = _TAG_START.match(text, start)
                if tag is None:
                    raise self._error(start, "expected a tag; '<' starts one")
                if tag["close"]:
                    position = self._end_tag(tag["name"], start, tag.end())
                else:
                    position = self._start_tag(tag["name"], start, tag.end())
                self._done = not self._open
        if self._open:
            raise XmlError(self._open[-1].place, f"<{self._open[-1].name}> is not closed")
        if not self._source.root.name:
            raise self._error(0, "the document is empty; expected <root>")
        return self._source

    def _close(self, start: int, mark: str, reason: str, opening: int = 2) -> int:
        end = self._text.find(mark, start + opening)
        if end < 0:
            raise self._error(start, reason)
        return end + len(mark)

    def _count_item(self, place: Place) -> None:
        self._count += 1
        if self._count > MAX_ELEMENTS:
            reason = f"the document has more than {MAX_ELEMENTS} elements, comments and texts"
            raise XmlError(place, reason)

    def _add(self, item: SourceComment | Text) -> None:
        self._count_item(item.place)
        if self._open:
            self._open[-1].content.append(item)
        else:
            (self._source.epilogue if self._done else self._source.prologue).append(item)

    def _add_text(self, start: int, end: int) -> None:
        piece = self._text[start:end]
        if not piece or piece.isspace():
            self._spaced = piece.count("\n") > 1
            return
        first = start + len(piece) - len(piece.lstrip())
        if not self._open:
            raise self._error(first, "text stands outside of the root element")
        self._add(Text(_unescape(piece)[0], self._place(first)))

    def _add_instruction(self, start: int, end: int) -> None:
        instruction = SourceComment(self._text[start:end], self._place(start), "instruction")
        only = all(
            isinstance(item, SourceComment) and item.kind == "instruction"
            for item in self._source.prologue
        )
        if self._open or self._done or not only:
            raise self._error(start, "a processing instruction stands before all else, or nowhere")
        self._add(instruction)

    def _end_tag(self, name: str, start: int, position: int) -> int:
        end = _TAG_END.match(self._text, position)
        if end is None or end["empty"]:
            raise self._error(start, f"</{name} is not closed by '>'")
        if not self._open:
            raise self._error(start, f"</{name}> closes nothing")
        opened = self._open.pop()
        if opened.name != name:
            raise self._error(
                start, f"expected </{opened.name}> (opened at line {opened.place.line}), "
                f"found </{name}>"
            )  # fmt: skip
        return end.end()

    def _start_tag(self, name: str, start: int, position: int) -> int:
        if self._done:
            raise self._error(start, "a document has one root element; found another")
        text = self._text
        element = Element(name, self._place(start), spaced=self._spaced)
        self._count_item(element.place)
        while (end := _TAG_END.match(text, position)) is None:
            found = _ATTRIBUTE.match(text, position)
            if found is None:
                where = position + len(text[position:]) - len(text[position:].lstrip())
                if where >= len(text):
                    raise self._error(start, f"<{name} is not closed by '>'")
                raise self._error(
                    where, f"expected an attribute or '>' in <{name}>, found '{text[where]}'"
                )
            key = found["name"]
            where = found.start("name")
            group = "double" if found["double"] is not None else "single"
            raw = found[group]
            if not found["equals"] or raw is None:
                raise self._error(where, f"attribute '{key}' has no value in quotes")
            if key in element.attributes:
                raise self._error(where, f"attribute '{key}' stands twice in <{name}>")
            if len(element.attributes) == MAX_ATTRIBUTES:
                raise self._error(where, f"<{name}> has more than {MAX_ATTRIBUTES} attributes")
            value, well_formed = _unescape(raw)
            element.attributes[key] = Attribute(
                key, value, self._place(where), self._place(found.start(group)), well_formed
            )
            position = found.end()
        if self._open:
            self._open[-1].content.append(element)
        else:
            self._source.root = element
        if end["empty"]:
            element.tag = text[start : end.end()]
        else:
            self._open.append(element)
            if len(self._open) > MAX_NESTING:
                raise self._error(start, f"nested deeper than {MAX_NESTING} levels")
        return end.end()


def _unescape(raw: str) -> tuple[str, bool]:
    """Replace references to characters; tell whether the text was well-formed XML."""
    well_formed = "<" not in raw
    if "\r" in raw:
        raw = raw.replace("\r\n", "\n").replace("\r", "\n")
    if "&" not in raw:
        return raw, well_formed
    well_formed = well_formed and "&" not in _REFERENCE.sub("", raw)

    def replace(found: re.Match[str]) -> str:
        nonlocal well_formed
        if found["name"]:
            if found["name"] not in _ENTITIES:
                well_formed = False
            return _ENTITIES.get(found["name"], found[0])
        code = int(found["dec"]) if found["dec"] else int(found["hex"], 16)
        if code == 0 or code > 0x10FFFF or 0xD800 <= code < 0xE000:
            well_formed = False
            return found[0]
        return chr(code)

    return _REFERENCE.sub(replace, raw), well_formed

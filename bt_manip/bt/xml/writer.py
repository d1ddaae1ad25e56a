"""Writing documents: the same content in one clean form."""

from typing import Final

from bt_manip.bt.xml.source import Element, Source, SourceComment, Text

WIDTH: Final = 100
"""Tags that would be longer have one attribute a line."""

_INDENT: Final = "  "
_IN_TEXT: Final = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;"})
_IN_ATTRIBUTES: Final = _IN_TEXT | str.maketrans(
    {'"': "&quot;", "\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}
)


def write_source(source: Source) -> str:
    """Write a document, with its comments and its order, indented by two spaces.

    The text ends in a line break; any XML reader finds the same values in it. Empty lines stay,
    one of each group.
    """
    lines: list[str] = []
    for item in (*source.prologue, source.root, *source.epilogue):
        _write_item(item, 0, lines)
    return "\n".join(lines) + "\n"


def write_element(element: Element) -> str:
    """Write one element by itself."""
    lines: list[str] = []
    _write_item(element, 0, lines)
    return "\n".join(lines)


def _write_item(item: SourceComment | Text | Element, depth: int, lines: list[str]) -> None:
    indent = _INDENT * depth
    if not isinstance(item, Text) and item.spaced and lines:
        lines.append("")
    if isinstance(item, Text):
        lines.append(indent + escape(item.text.strip(), quotes=False))
        return
    if isinstance(item, SourceComment):
        lines.append(indent + (item.text if item.kind == "instruction" else f"<!--{item.text}-->"))
        return
    content = [inner for inner in item.content if not isinstance(inner, Text) or inner.text.strip()]
    tag = _start_tag(item, indent, ">" if content else "/>")
    if content and not any(isinstance(inner, Element) for inner in content):
        # On the same line: schemas allow no white space in an element without children.
        inside: list[str] = []
        for inner in content:
            _write_item(inner, 0, inside)
        lines.append(f"{tag}{''.join(inside)}</{item.name}>")
        return
    lines.append(tag)
    for inner in content:
        _write_item(inner, depth + 1, lines)
    if content:
        lines.append(f"{indent}</{item.name}>")


def _start_tag(element: Element, indent: str, end: str) -> str:
    attributes = [f'{a.name}="{escape(a.value)}"' for a in element.attributes.values()]
    tag = indent + " ".join([f"<{element.name}", *attributes]) + end
    if len(tag) > WIDTH and len(attributes) > 1:
        inner = "\n" + indent + _INDENT * 2
        tag = indent + inner.join([f"<{element.name}", *attributes]) + end
    return tag


def escape(text: str, *, quotes: bool = True) -> str:
    """Write special characters of XML as references, for attributes (`quotes`) or for text."""
    return text.translate(_IN_ATTRIBUTES if quotes else _IN_TEXT)

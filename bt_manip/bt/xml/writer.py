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

    Args:
        source: The document.

    Returns:
        Its text, ending in a line break; any XML reader finds the same values in it. Empty lines
        stay, one of each group.
    """
    lines: list[str] = []
    for item in (*source.prologue, source.root, *source.epilogue):
        _write_item(item, 0, lines)
    return "\n".join(lines) + "\n"


def write_element(element: Element) -> str:
    """Write one element by itself."""
    lines: list[str] = []
    _write_element(element, 0, lines)
    return "\n".join(lines)


def _write_item(item: SourceComment | Text | Element, depth: int, lines: list[str]) -> None:
    if not isinstance(item, Text) and item.spaced and lines:
        lines.append("")
    if isinstance(item, Element):
        _write_element(item, depth, lines)
    elif isinstance(item, Text):
        lines.append(_INDENT * depth + escape(item.text.strip(), quotes=False))
    elif item.kind == "instruction":
        lines.append(_INDENT * depth + item.text)
    else:
        lines.append(_INDENT * depth + f"<!--{item.text}-->")


def _write_element(element: Element, depth: int, lines: list[str]) -> None:
    indent = _INDENT * depth
    attributes = [f'{a.name}="{escape(a.value)}"' for a in element.attributes.values()]
    content = [item for item in element.content if not _is_blank(item)]
    end = ">" if content else "/>"
    tag = indent + " ".join([f"<{element.name}", *attributes]) + end
    if len(tag) > WIDTH and len(attributes) > 1:
        inner = "\n" + indent + _INDENT * 2
        tag = indent + inner.join([f"<{element.name}", *attributes]) + end
    if content and not any(isinstance(item, Element) for item in content):
        # On the same line: schemas allow no white space in an element without children.
        inside: list[str] = []
        for item in content:
            _write_item(item, 0, inside)
        lines.append(f"{tag}{''.join(inside)}</{element.name}>")
        return
    lines.append(tag)
    for item in content:
        _write_item(item, depth + 1, lines)
    if content:
        lines.append(f"{indent}</{element.name}>")


def _is_blank(item: SourceComment | Text | Element) -> bool:
    return isinstance(item, Text) and not item.text.strip()


def escape(text: str, *, quotes: bool = True) -> str:
    """Write special characters of XML as references.

    Args:
        text: The text.
        quotes: Whether it stands in an attribute: quotes and line breaks are escaped too.
    """
    return text.translate(_IN_ATTRIBUTES if quotes else _IN_TEXT)

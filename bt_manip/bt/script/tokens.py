"""Cutting a script into tokens."""

import re
from typing import Final, NamedTuple

from bt_manip.exceptions import ScriptError, shortened

MAX_SCRIPT: Final = 2**16
"""Maximum number of characters of a script."""


class Token(NamedTuple):
    """A piece of a script.

    Attributes:
        kind: ``string``, ``integer``, ``real``, ``name``, ``operator`` or ``end``.
        text: Its text; of a string, the part between the quotes.
        position: Where it starts, from 0.
    """

    kind: str
    text: str
    position: int


_TOKEN: Final = re.compile(
    r"""
      (?P<space>[ \t\n\r]+)
    | '(?P<string>[^']*)'
    | "(?P<quoted>[^"]*)"
    | (?P<hex>0[xX][0-9a-fA-F]+)
    | (?P<real>[0-9]+\.[0-9]+(?:[eE][+-]?[0-9]+)?|[0-9]+[eE][+-]?[0-9]+)
    | (?P<integer>[0-9]+)
    | (?P<name>[A-Za-z_@][A-Za-z0-9_]*)
    | (?P<operator>\.\.|&&|\|\||==|!=|<=|>=|:=|\+=|-=|\*=|/=|[-+*/&|^~!<>=?:();])
    """,
    re.VERBOSE,
)
_KINDS: Final = {"hex": "integer", "quoted": "string"}
_NUMBER_TAIL: Final = re.compile(r"[A-Za-z_@][A-Za-z0-9_]*|\.(?!\.)[A-Za-z0-9_.]*")
_HEX_TAIL: Final = re.compile(r"[A-Za-z0-9_.][A-Za-z0-9_.]*")


def tokenize(text: str, *, double_quotes: bool = False) -> list[Token]:
    """Cut a script into tokens, ``end`` being the last one; errors are `ScriptError`."""
    if len(text) > MAX_SCRIPT:
        raise ScriptError(f"longer than {MAX_SCRIPT} characters")
    tokens: list[Token] = []
    position = 0
    while position < len(text):
        found = _TOKEN.match(text, position)
        if found is None:
            raise _invalid(text, position)
        kind = found.lastgroup or ""
        if kind == "quoted" and not double_quotes:
            raise _invalid(text, position)
        end = found.end()
        if kind in ("integer", "real", "hex"):
            tail = (_HEX_TAIL if kind == "hex" else _NUMBER_TAIL).match(text, end)
            if tail is not None:
                raise _invalid(text, position, tail.end())
        if kind != "space":
            tokens.append(Token(_KINDS.get(kind, kind), found[kind], position))
        position = end
    tokens.append(Token("end", "", len(text)))
    return tokens


def _invalid(text: str, position: int, end: int | None = None) -> ScriptError:
    if text[position] == "'":
        end = len(text)
    piece = text[position : end or position + 1]
    hint = ""
    if piece == '"':
        hint = "; strings stand between single quotes"
    elif piece.startswith("'"):
        hint = "; the closing quote is missing"
    elif piece == "%":
        hint = "; there is no such operator"
    return ScriptError(f"invalid token '{shortened(piece)}' at position {position}{hint}")

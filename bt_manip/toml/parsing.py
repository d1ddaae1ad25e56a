"""Parsing of TOML with bounds on size and nesting."""

import re
import tomllib
from pathlib import Path
from typing import Any

from bt_manip.files import read_text

MAX_TOML_BYTES = 2**18  # 256 kB, of which the worst takes about a second

MAX_TOML_NESTING = 64
"""Deepest nesting of tables, lists and dotted keys."""

_TEXT = re.compile(  # strings, also unterminated ones, and comments: a search takes linear time
    r'''"""(?:\\.|[^\\])*?(?:"""|\\?\Z)|\'\'\'.*?(?:\'\'\'|\Z)'''
    r"""|"(?:\\.|[^"\\\n])*"?|\'[^\'\n]*\'?|#[^\n]*""",
    re.DOTALL,
)
_DOTTED = re.compile(r"[\w-]+(?:[ \t]*\.[ \t]*[\w-]+)*")


def read_toml(path: Path) -> dict[str, Any]:
    """Return the content of a TOML file.

    Raises:
        OSError: If it cannot be read.
        ValueError: As for `parse_toml`.
    """
    return parse_toml(read_text(path, MAX_TOML_BYTES))


def parse_toml(text: str) -> dict[str, Any]:
    """Return the content of a TOML text.

    Raises:
        ValueError: If it is not TOML, or nested deeper than `MAX_TOML_NESTING`.
    """
    bare = _TEXT.sub("s", text)
    depth = 0
    for bracket in re.findall(r"[][{}]", bare):
        depth += 1 if bracket in "[{" else -1
        if depth > MAX_TOML_NESTING:
            break
    dots = max((key[0].count(".") for key in _DOTTED.finditer(bare)), default=0)
    if depth > MAX_TOML_NESTING or dots >= MAX_TOML_NESTING:
        raise ValueError(f"nested deeper than {MAX_TOML_NESTING} levels")
    return tomllib.loads(text)

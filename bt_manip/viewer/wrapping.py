"""Printing lines that fit the terminal."""

import textwrap

from rich.console import Console
from rich.text import Text


def print_wrapped(console: Console, line: str, *, indent: int = 2, style: str = "") -> None:
    """Print a line, wrapped between words where it is longer than the console is wide.

    Args:
        console: Where to print.
        line: The text; nothing in it is markup.
        indent: Spaces before its second and further lines.
        style: Style of the text.
    """
    fitting = textwrap.wrap(
        line, console.width, subsequent_indent=" " * indent,
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip
    console.print(Text("\n".join(fitting), style=style), highlight=False, soft_wrap=True)

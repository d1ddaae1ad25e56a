"""Printing lines that fit the terminal."""

import textwrap

from rich.console import Console
from rich.text import Text


def print_wrapped(console: Console, line: str, *, indent: int = 2, style: str = "") -> None:
    """Print a line, wrapped between words to the width of the console.

    Args:
        console: Console to print to.
        line: Plain text, in which markup has no effect.
        indent: Spaces before continuation lines.
        style: Style of the text.
    """
    fitting = textwrap.wrap(
        line, console.width, subsequent_indent=" " * indent,
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip
    console.print(Text("\n".join(fitting), style=style), highlight=False, soft_wrap=True)

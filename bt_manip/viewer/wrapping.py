"""Printing lines that fit the terminal."""

import textwrap

from rich.console import Console
from rich.text import Text


def print_wrapped(console: Console, *lines: str, indent: int = 2, style: str = "") -> None:
    """Print lines, each wrapped between words to the width of the console.

    Args:
        console: Console to print to.
        *lines: Plain text, in which markup has no effect.
        indent: Spaces before continuation lines.
        style: Style of the text.
    """
    wrapper = textwrap.TextWrapper(
        console.width, subsequent_indent=" " * indent,
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip
    fitting = [part for line in lines for part in wrapper.wrap(line)]
    console.print(Text("\n".join(fitting), style=style), highlight=False, soft_wrap=True)

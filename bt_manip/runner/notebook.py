"""HTML for the rich display of objects in notebooks."""

from base64 import b64encode
from collections.abc import Mapping
from html import escape


def html_table(title: str, rows: Mapping[str, object]) -> str:
    """Return a titled table of names and values; empty values are left out."""
    cells = (
        f"<tr><th style='text-align:left'>{escape(name)}</th>"
        f"<td style='text-align:left'>{escape(str(value))}</td></tr>"
        for name, value in rows.items()
        if value not in (None, "")
    )
    return f"<b>{escape(title)}</b><table>{''.join(cells)}</table>"


def html_image(png: bytes | None) -> str:
    """Return a PNG image, or nothing without one."""
    return f'<img src="data:image/png;base64,{b64encode(png).decode()}"/>' if png else ""

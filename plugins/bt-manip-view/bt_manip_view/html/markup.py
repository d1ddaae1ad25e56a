"""HTML of self-contained pages."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape

from bokeh.resources import Resources

POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' blob:; worker-src blob:; "
    "style-src 'unsafe-inline'; img-src data: blob:; font-src data:; connect-src data: blob:"
)
"""Content security policy: the page loads nothing from outside its file."""

REPORT_STYLE = """
:root{color-scheme:light}
body{font:15px/1.5 system-ui,sans-serif;color:#212529;background:#f1f3f5;margin:0}
main{max-width:1280px;margin:0 auto;padding:1.5rem}
h1{margin:0;font-size:1.7rem;overflow-wrap:anywhere}
h2{font-size:1.1rem;margin:0 0 .5rem}
section{background:#fff;border-radius:8px;padding:1rem 1.25rem;margin:1rem 0;
box-shadow:0 1px 3px #0002}
.tiles{display:flex;flex-wrap:wrap;gap:.8rem;margin:1rem 0}
.tiles div{background:#fff;border-radius:8px;padding:.6rem 1.1rem;box-shadow:0 1px 3px #0002;
flex:1 1 7rem;font-size:.85rem}
.tiles b{display:block;font-size:1.4rem;white-space:nowrap;font-weight:600;line-height:1.3}
.badge{color:#fff;border-radius:4px;padding:.1rem .5rem;font-size:.8rem;font-weight:600;
white-space:nowrap;background:#868e96}
.SUCCESS{background:#2b8a3e}.FAILURE{background:#c92a2a}
.warning{background:#fff3bf;border:1px solid #fcc419}
table{border-collapse:collapse;width:100%;font-size:.9rem}
th{text-align:left;color:#868e96;font-weight:500}
td,th{padding:.25rem .8rem .25rem 0;border-bottom:1px solid #f1f3f5;vertical-align:top;
overflow-wrap:break-word}
.narrow{color:#868e96;font-size:.85rem}
.rows{max-height:900px;overflow:auto}
.plot{display:flex}.plot>div:last-child{flex:1;min-width:0}
.names{flex:none;padding-top:5px;font-size:12px}
.names div{line-height:20px;box-sizing:border-box;white-space:nowrap;overflow:hidden;
text-overflow:ellipsis}
iframe{width:100%;height:560px;border:1px solid #dee2e6;border-radius:4px;display:block}
dl{display:grid;grid-template-columns:max-content 1fr;gap:.1rem 1.2rem;margin:0;font-size:.9rem}
dt{color:#868e96}dd{margin:0;overflow-wrap:anywhere}
"""


def html_page(title: str, parts: Iterable[str], script: str, style: str = "") -> str:
    """Return a page.

    Args:
        title: Its title, as text.
        parts: Its content, as HTML.
        script: The script of its plots.
        style: Further rules of its style sheet.
    """
    library = Resources(mode="inline", components=["bokeh"]).render_js()
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{escape(title)}</title>"
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{REPORT_STYLE}{style}</style>\n{library}</head><body><main>{''.join(parts)}</main>"
        f"{script}</body></html>\n"
    )


def html_section(title: str, content: str) -> str:
    """Return a section with a title."""
    return f"<section><h2>{escape(title)}</h2>{content}</section>"


def html_rows(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table with HTML cells."""
    titles = "".join(f"<th>{escape(name)}</th>" for name in head)
    lines = ("".join(f"<td>{cell}</td>" for cell in row) for row in rows)
    return f"<table><tr>{titles}</tr>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>"


def html_tiles(tiles: Iterable[tuple[str, str]]) -> str:
    """Return a row of tiles from pairs of name and figure."""
    boxes = (f"<div><b>{escape(value)}</b>{escape(name)}</div>" for name, value in tiles)
    return f'<div class="tiles">{"".join(boxes)}</div>'


def html_list(lines: Mapping[str, str]) -> str:
    """Return a description list of names and texts."""
    items = (f"<dt>{escape(key)}</dt><dd>{escape(text)}</dd>" for key, text in lines.items())
    return f"<dl>{''.join(items)}</dl>"

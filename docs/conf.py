"""Settings of Sphinx: ``make docs`` builds the site into ``docs/_build/html``."""

import os
import re
import sys
from pathlib import Path
from typing import Any

os.environ.setdefault("MUJOCO_GL", "disable")
ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tools"))

import api_page  # noqa: E402
import reference_pages  # noqa: E402

from bt_manip import __version__  # noqa: E402

project = "bt-manip"
author = "the authors of bt-manip"
version = release = __version__

extensions = [
    "myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_click", "site_search",
]  # fmt: skip
exclude_patterns = ["_build"]

myst_heading_anchors = 4

autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
toc_object_entries_show_parents = "hide"
python_use_unqualified_type_names = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

highlight_language = "text"  # of blocks without one: commands and their output
nitpicky = True
nitpick_ignore_regex = [  # other projects' names, and internal ones in signatures
    ("py:class", r".*"),
    ("py:exc", r"UnknownPartError|ControllerFault|FileInUseError"),
    ("py:obj", r"typing\.Annotated.*"),
    ("py:meth", r"PluginManager\..*"),
]

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_title = "bt-manip"
html_show_copyright = html_show_sphinx = html_copy_source = html_show_sourcelink = False

PUBLIC = {
    key: f"{package}.{name}"
    for package, names in reversed(api_page.names().items())
    for name in names
    for key in (name, f"{package}.{name}")
}
"""Full names of the public API, by their names with and without package."""


def adapt_docstring(
    app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]
) -> None:
    """Make reStructuredText of what docstrings take from Markdown: `names`, tables, shapes."""
    text = re.sub(r"(?<![`:\w])`([^`\n]+)`(?![`_])", _code, "\n".join(lines))
    text = re.sub(r" +# (\(.+\))$", r" ``\1``", text, flags=re.M)  # shapes of arrays
    lines[:] = re.sub(r"^\|.*\n(?:\|.*(?:\n|$))+", _table, text, flags=re.M).split("\n")


def _code(match: re.Match[str]) -> str:
    """Link a public name; set any other one as code."""
    name = match[1]
    return f":py:obj:`{name} <{PUBLIC[name]}>`" if name in PUBLIC else f"``{name}``"


def _table(match: re.Match[str]) -> str:
    rows: list[list[str]] = []
    for line in match[0].splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if set(line) <= set("|-"):
            continue
        if cells[0] or not rows:
            rows.append(cells)
        else:  # a cell of several lines
            rows[-1] = [f"{a} {b}".strip() for a, b in zip(rows[-1], cells, strict=True)]
    items = [f"   {'-' if i else '* -'} {cell}" for row in rows for i, cell in enumerate(row)]
    body = "\n".join(item.replace("   - ", "     - ", 1) for item in items)
    return f".. list-table::\n   :widths: auto\n\n{body}\n\n"


def escape_help(app: Any, context: Any, lines: list[str]) -> None:
    """Escape the characters of the command line's help that reStructuredText would read."""
    lines[:] = [re.sub(r"(?<![\\*])\*(?!\*)", r"\\*", line) for line in lines]


def adapt_page(app: Any, page: str, source: list[str]) -> None:
    """Let links that lead out of ``docs/`` lead to the pages of the site."""
    if page.partition("/")[0] not in reference_pages.GENERATED:
        source[0] = reference_pages.adapt_links(source[0], f"docs/{page}.md", f"{page}.md")


def setup(app: Any) -> None:
    """Connect the handlers."""
    app.connect("source-read", adapt_page)
    app.connect("autodoc-process-docstring", adapt_docstring, priority=600)  # after napoleon
    app.connect("sphinx-click-process-options", escape_help)
    reference_pages.write_all(ROOT / "docs")

"""Write the pages of the site that follow from the code: reference, packages, changelog.

``docs/conf.py`` runs this before each build. The pages are not committed:

- ``docs/reference/``: public API, behaviours, other parts, hooks, command line, files;
- ``docs/project/``: Markdown from outside ``docs/``, with its links adapted.
"""

import dataclasses
import importlib
import importlib.metadata
import inspect
import os
import re
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
GENERATED = ("reference", "project")
"""Folders of ``docs/`` that hold nothing but generated pages."""

COPIED = {
    "examples/README.md": "project/examples.md",
    "CONTRIBUTING.md": "project/contributing.md",
    "CHANGELOG.md": "project/changelog.md",
    "benchmarks/README.md": "project/benchmarks.md",
    **{
        path.relative_to(ROOT).as_posix(): f"project/{path.parent.name}.md"
        for path in sorted((ROOT / "plugins").glob("*/README.md"))
    },
}
"""Pages outside of ``docs/``, and where the site has them."""

PARTS = {
    "trees": "Trees",
    "objects": "Objects",
    "robots": "Robots",
    "grippers": "Kinds of grippers",
    "controllers": "Controllers",
    "conversions": "Conversions",
    "planners": "Planners",
    "scenes": "Scenes",
    "recorders": "Recorders",
    "export_formats": "Export formats",
    "views": "Views",
    "commands": "Commands",
    "modifiers": "Modifiers",
    "pools": "Pools of workers",
    "faults": "Faults",
    "actions": "Kinds of actions",
    "policies": "Kinds of policies",
    "contracts": "Contracts",
    "backends": "Backends",
    "pose_sources": "Pose sources",
    "model_sources": "Model sources",
    "model_formats": "Model formats",
    "model_caches": "Model caches",
}

COMMAND_LINE = """Command line
============

Every option of every command, from the program itself. ``bt-manip COMMAND --help`` prints the same.

.. click:: bt_manip.cli.app:app
   :prog: bt-manip
   :nested: full
"""

NODES = """# Nodes

The nodes of the [tree language](../tree-language.md), as in BehaviorTree.CPP v4: the result of each
for every status of its child, and its ports. `bt-manip list NAME` prints the same.

"""

PACKAGES = """# Plugin packages

Packages of the repository that extend bt-manip through its hooks, each with its behaviours.

```{toctree}
:maxdepth: 1

"""

HOOKS = """# Hooks

A plugin is a module with functions marked by `bt_manip.hookimpl`: see
[plugins](../plugins/README.md). The pages have an example for each:

| hook | purpose |
|---|---|
"""

FILES = """# Files

What bt-manip reads and writes, with the keys of each file.

| file | written or read by | keys |
|---|---|---|
| tree (`.xml`) | `bt-manip run`, `tree` | [tree language](../tree-language.md), `tree schema` |
| scene (`.toml`) | `--scene`, `bt-manip scene` | [keys](../scene-keys.md) |
| robot (`.toml`) | `--robot`, `robot` in a scene | [keys](../robot-keys.md) |
| report (`.json`, `.jsonl`) | `--report` | [below](#report) |
| trace (`.npz`), of bt-manip-recording | `--trace` | [below](#trace) |
| snapshot | `--snapshot-at`, `--resume` | none: the version that wrote it reads it |

## Report

`--report FILE.json` writes one JSON object. It is rewritten at most once a second while the run
goes on, and at its end; each version replaces the one before, so the file is complete at any time.

`--report FILE.jsonl` writes a line as each cycle ends, for long runs. Each line is an object with a
`type`: `run` (the first line, with what was run), `cycle`, and `end` (the last line: `status`,
`simulated_s`, `wall_s`, `real_time_factor`, `state_digest` and `error`).

A run that is killed leaves its cycles up to then; JSON lacks at most those of the last second. Its
status is `RUNNING`. If the disk is full, what was written stays; the cycles that are missing are
written as soon as there is space; otherwise the run ends with exit code 3 and a message with the
first cycle that is lost. There is no report of bad input.

`bt_manip.record.read_report` reads both, also while the run goes on. It leaves out an unfinished
last line:

```
from bt_manip.record import read_report

report = read_report("report.jsonl")
print(report.status, [cycle.duration_s for cycle in report.cycles])
```

A number that is not finite is `null`.

"""

TRACE = """## Trace

A NumPy archive with one row for each control step (1 kHz); `n` is the number of joints of the arm.
With several robots in the cell, the names are `left/q` and so on.

```
from bt_manip_recording import read_trace

trace = read_trace("trace.npz")
error = trace["q"] - trace["q_ref"]
```

While the run goes on, the file is a growing array in NumPy's NPY format with the same names, which
lacks at most the last 512 steps; after `kill -9` or on a full disk, it stays one. `read_trace` and
`np.load(...)["q"]` read both.

| name | shape | contents |
|---|---|---|
| `t` | (steps,) | simulated time [s] |
"""

TRACED = {
    "q": "measured joint positions [rad]",
    "v": "measured joint velocities [rad/s]",
    "q_ref": "reference positions [rad]",
    "v_ref": "reference velocities [rad/s]",
    "a_ref": "reference accelerations [rad/s2]",
    "tau": "commanded joint torques [N m]",
}


def write_all(docs: Path) -> list[Path]:
    """Write all generated pages.

    Args:
        docs: The folder of pages; those of the repository, or another one for a test.

    Returns:
        The files; those that have not changed keep their time, so that they are not read again.
    """
    os.environ.setdefault("MUJOCO_GL", "disable")  # nothing is drawn here
    sys.path.insert(0, str(ROOT / "tools"))
    from node_reference import node_reference

    from bt_manip.plugins import load_plugins

    parts = load_plugins().parts
    pages = {
        "reference/nodes.md": NODES + node_reference(),
        "reference/behaviours.md": behaviours_page(parts),
        "reference/parts.md": parts_page(parts),
        "reference/hooks.md": hooks_page(),
        "reference/files.md": files_page(),
        "reference/command-line.rst": COMMAND_LINE,
        **api_pages(),
    }
    packages = [Path(page).stem for page in COPIED.values() if "/bt-manip-" in page]
    pages["project/packages.md"] = PACKAGES + "".join(f"{name}\n" for name in packages) + "```\n"
    for source, target in COPIED.items():
        pages[target] = copied_page(source, target, parts)
    written = []
    for name, text in pages.items():
        path = docs / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
        written.append(path)
    for folder in GENERATED:
        for path in {*(docs / folder).rglob("*.*")} - {*written}:
            path.unlink()
    return written


# Public API


def api_pages() -> dict[str, str]:
    """Return a page for each package of the public API, for autodoc, and one that leads to them."""
    from api_page import names, page

    contents = "".join(f"{package}\n" for package in names())
    index = f"{page()}\n```{{toctree}}\n:hidden:\n\n{contents}```\n"
    pages, seen = {"reference/api/index.md": index}, set()
    for package, known in names().items():
        module = importlib.import_module(package)
        title = f"``{package}``"
        parts = [f"{title}\n{'=' * len(title)}\n\n.. currentmodule:: {package}\n"]
        for name, stability in known.items():
            thing = getattr(module, name)
            place = (getattr(thing, "__module__", package), name)
            double = place in seen  # exported by two packages
            seen.add(place)
            parts.append(_autodoc(package, name, thing, stability, double))
        pages[f"reference/api/{package}.rst"] = "\n".join(parts)
    return pages


def _autodoc(package: str, name: str, thing: object, stability: str, double: bool) -> str:
    note = "" if stability == "stable" else "\n   *Experimental.*\n"
    if inspect.isclass(thing):
        own = thing.__module__.startswith("bt_manip")
        lines = [f".. autoclass:: {name}", *(["   :members:"] if own else [])]
    elif inspect.isroutine(thing):
        lines = [f".. autofunction:: {name}"]
    else:
        lines = [f".. autodata:: {name}", "   :no-value:"]
    if double:
        lines.append("   :no-index:")
    return "\n".join(lines) + "\n" + note


# Registered parts


def behaviours_page(parts: Any) -> str:
    """Return the page of the built-in behaviours with their ports."""
    return (
        "# Behaviours\n\nThe leaves that bt-manip brings, with their ports. Behaviours of "
        "plugins are on the pages of [their packages](../project/packages.md); "
        "control nodes and decorators are [nodes of the language](nodes.md). "
        "`bt-manip list behaviours` shows those that are installed.\n\n"
        + _behaviours_of("builtin", parts)
    )


def _behaviours_of(owner: str, parts: Any) -> str:
    from node_reference import node_reference

    known = parts.behaviours
    return node_reference({n: known.get(n) for n in known.names() if known.owner(n) == owner})


def parts_page(parts: Any) -> str:
    """Return the page of all registered parts that are no behaviours."""
    kinds = parts.by_kind()
    text = [
        "# Registered parts\n\nWhat a run can name, beside [behaviours](behaviours.md): built "
        "in, or of the repository's plugin packages. `bt-manip list` shows what is installed.\n"
    ]
    for kind, title in PARTS.items():
        registry = kinds[kind]
        text.append(f"\n## {title}\n\n| name | from | |\n|---|---|---|\n")
        for name in registry.names():
            text.append(f"| `{name}` | {registry.owner(name)} | {_summary(registry.get(name))} |\n")
    return "".join(text)


def _summary(part: Any) -> str:
    if isinstance(part, str):  # a tree, or a model
        return f"`{part.replace(str(ROOT) + '/', '')}`"
    if not callable(part):
        model = str(getattr(part, "model", "") or getattr(part, "make", "")).replace(
            str(ROOT) + "/", ""
        )
        return f"`{model}`" if model else ""
    return _plain(inspect.cleandoc(part.__doc__ or "").partition("\n\n")[0])


def _plain(text: str) -> str:
    """Make a docstring fit into a cell of a Markdown table."""
    return re.sub(r"``(.+?)``", r"`\1`", " ".join(text.split())).replace("|", "\\|")


# Hooks


def hooks_page() -> str:
    """Return the page of all hooks, which leads to the page of each."""
    from bt_manip import hookspecs

    rows, pages = [], {}
    for name, hook in vars(hookspecs).items():
        if hasattr(hook, f"{hookspecs.GROUP}_spec"):
            arguments = ", ".join(inspect.signature(hook).parameters)
            summary = _plain((inspect.getdoc(hook) or "").partition("\n\n")[0])
            page = "observers" if name in hookspecs.OBSERVING else name
            rows.append(f"| [`{name}({arguments})`](../plugins/hooks/{page}.md) | {summary} |\n")
            pages[f"../plugins/hooks/{page}\n"] = None
    return f"{HOOKS}{''.join(rows)}\n```{{toctree}}\n:hidden:\n\n{''.join(pages)}```\n"


# Files


def files_page() -> str:
    """Return the page of the keys of reports and traces."""
    report = importlib.import_module("bt_manip.record.report.run_report")
    runner = importlib.import_module("bt_manip.runner")
    text = [FILES]
    for cls in (
        report.RunReport, report.CycleReport, report.GrippedObject, report.Phase,
        report.CycleLimitUse, report.RobotCycle,
    ):  # fmt: skip
        text.append(f"### {cls.__name__}\n\n{_fields(cls)}\n")
    text.append(TRACE)
    for name in runner.STEP_FIELDS:
        text.append(f"| `{name}` | (steps, n) | {TRACED[name]} |\n")
    return "".join(text)


def _fields(cls: type) -> str:
    """Return a table of the attributes of a dataclass, described by its docstring."""
    about = _described(cls, "Attributes")
    rows = []
    for field in dataclasses.fields(cls):
        kind = field.type if isinstance(field.type, str) else inspect.formatannotation(field.type)
        kind = re.sub(r"[\w.]+\.(\w+)", r"\1", kind).replace("|", "\\|")
        rows.append(f"| `{field.name}` | {kind} | {about.get(field.name, '')} |\n")
    return f"| key | type | |\n|---|---|---|\n{''.join(rows)}"


def _described(thing: Any, section: str) -> dict[str, str]:
    """Read a section such as ``Attributes:`` of a docstring in Google's style."""
    found = re.search(rf"^{section}:\n((?:    .*\n?|\n)*)", inspect.getdoc(thing) or "", re.M)
    items: dict[str, str] = {}
    for item in re.split(r"\n(?=    \S)", found[1]) if found else []:
        names, _, text = item.strip().partition(":")
        for name in names.split(","):
            items[name.strip()] = _plain(text)
    return items


# Pages from elsewhere


def copied_page(source: str, target: str, parts: Any) -> str:
    """Return a page from outside ``docs/`` with its links adapted, and what belongs to it.

    Args:
        source: Path of the page in the repository.
        target: Its path in ``docs/``.
        parts: The registered parts.
    """
    text = adapt_links((ROOT / source).read_text(encoding="utf-8"), source, target)
    folder = (ROOT / source).parent
    if source.startswith("examples/"):
        for path in sorted({*folder.glob("*.py"), *folder.glob("*.xml")}):
            there = os.path.relpath(path, (ROOT / "docs" / target).parent)
            text += f"\n## {path.name}\n\n```{{literalinclude}} {there}\n```\n"
    elif source.startswith("plugins/"):
        owner = folder.name.removeprefix("bt-manip-")
        if any(parts.behaviours.owner(name) == owner for name in parts.behaviours.names()):
            text += "\n" + _behaviours_of(owner, parts)
    return text


def adapt_links(text: str, source: str, target: str) -> str:
    """Return a page with links to the pages of the site; links out of it become plain text.

    Args:
        text: The page.
        source: Its path in the repository.
        target: Its path in ``docs/``.
    """

    def adapt(match: re.Match[str]) -> str:
        image, label, place, heading = match[1], match[2], match[3], match[4] or ""
        path = os.path.normpath(os.path.join(os.path.dirname(source), place))
        if "://" in place or (source == f"docs/{target}" and path.startswith("docs/")):
            return match[0]
        shown = os.path.dirname(path) == "examples" and path.endswith((".py", ".xml"))
        if source.startswith("examples/") and shown:
            return f"[{label}](#{os.path.basename(path).replace('.', '')})"
        page = COPIED.get(path) or COPIED.get(f"{path}/README.md")
        if page is None and path.startswith("docs/"):
            page = path.removeprefix("docs/")
        if page is None:
            return label
        return f"{image}[{label}]({os.path.relpath(page, os.path.dirname(target))}{heading})"

    return re.sub(r"(!?)\[([^\]]+)\]\(([^)#\s]+)(#[^)\s]+)?\)", adapt, text)


if __name__ == "__main__":
    for path in write_all(ROOT / "docs"):
        print(path.relative_to(ROOT))

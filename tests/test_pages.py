"""Everything that the pages show works as printed, and everything that they link or name exists."""

import os
import re
import shlex
import tomllib
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import click
import pytest

import bt_manip.testing.tree_reading  # noqa: F401  inner sessions of pytest must not unload it
from bt_manip.behaviours import Grasp, Hover
from bt_manip.bt import BehaviourRegistry, parse_tree
from bt_manip.bt.nodes.node import CONDITIONS
from tests.support.pages import GENERATED, PAGES, ROOT, File, blocks, required_packages, steps
from tools import reference_pages
from tools.node_reference import node_reference

pytest_plugins = ("pytester",)

TABLES = (
    "docs/stress_tables.md",
    "docs/task_table.md",
    "docs/arm_table.md",
    "docs/object_table.md",
)
"""Pages that tools write."""
COVERED_ELSEWHERE = {
    "docs/plugins/tutorials/": "test_scaffold.py writes, installs and tests these packages",
}
"""Pages whose Python is not run here, and why."""

PRINTS = {
    "docs/authoring-python.md": (r"^SUCCESS $",),
    "docs/cell.md": (r"\('bin', 'cube'\)",),
    "docs/motion.md": (
        r"^tool: 0\.000 mm from its target",
        r"^\d\d %: the line can be followed only for \d\d %",
    ),
    "docs/recordings.md": (r"^example 0\.03 True$", r"^0\.02 s  rest: SUCCESS$", r" tick "),
    "docs/scenes.md": (r"'mass'",),
}
"""Regular expressions for the output of a page."""


def file_name(block: str) -> str:
    """Return the name in the block's first line, if the block is a file such as ``# test_x.py``."""
    found = re.match(r"# (\S+\.py)\n", block)
    return found[1] if found else ""


def pages_with(language: str) -> list[str]:
    return [page for page in PAGES if blocks(page, language)]


RUN = [page for page in pages_with("python") if not page.startswith(tuple(COVERED_ELSEWHERE))]


@pytest.mark.parametrize("page", RUN)
def test_the_python_of_a_page_runs_from_the_first_block_to_the_last(
    page, tmp_path, monkeypatch, capsys
):
    """Blocks of a page share their names; tests without arguments are called."""
    monkeypatch.chdir(tmp_path)
    names: dict = {"__name__": "page", "__file__": str(tmp_path / "page.py")}
    for block in blocks(page, "python"):
        if not file_name(block):
            exec(compile(block, page, "exec"), names)
    for name, value in names.items():
        if name.startswith("test_") and callable(value) and not value.__code__.co_argcount:
            value()
    printed = capsys.readouterr().out
    for pattern in PRINTS.get(page, ()):
        assert re.search(pattern, printed, re.MULTILINE), printed


@pytest.mark.parametrize("page", [p for p in RUN if any(map(file_name, blocks(p, "python")))])
def test_the_test_files_of_a_page_pass(page, situations, pytester):
    situations.reset()
    files = {Path(s.name).name: s.text for s in steps(page) if isinstance(s, File)}
    files |= {file_name(block): block for block in blocks(page, "python") if file_name(block)}
    for name, block in files.items():
        (pytester.path / name).write_text(block)
    result = pytester.runpytest_inprocess("-p", "no:cacheprovider")
    result.assert_outcomes(passed=sum(block.count("def test_") for block in files.values()))


@pytest.mark.parametrize("page", pages_with("toml"))
def test_the_toml_of_a_page_can_be_read(page):
    for block in blocks(page, "toml"):
        tomllib.loads(block)


@pytest.mark.parametrize("page", pages_with("xml"))
def test_the_xml_of_a_page_is_well_formed(page):
    for block in blocks(page, "xml"):
        ElementTree.fromstring(f"<page>{block}</page>")


def commands(page: str) -> list[str]:
    """Return the ``bt-manip`` command lines of a page, of blocks and of inline code."""
    fenced = re.findall(r"^```(?:sh)?\n(.*?)^```", PAGES[page], re.DOTALL | re.MULTILINE)
    text = "\n".join(fenced).replace("\\\n", " ")
    lines = re.findall(r"^(?:\.venv/bin/)?bt-manip (.*)$", text, re.MULTILINE)
    inline = re.findall(r"`bt-manip ([^`]*)`", PAGES[page])
    found = [re.sub(r"\s#.*", "", line).replace("\n", " ") for line in (*lines, *inline)]
    return [line for line in found if not re.search(r"[\[|]|\.\.\.", line)]  # not a synopsis


@pytest.mark.parametrize("page", [page for page in PAGES if commands(page)])
def test_the_commands_of_a_page_exist_with_their_options(page):
    from bt_manip.cli.app import app

    for line in commands(page):
        command, words = app, shlex.split(line)
        names = app.context_settings["help_option_names"]  # kept by each command for all
        context = click.Context(app, help_option_names=names)
        options = {name for p in app.params for name in (*p.opts, *p.secondary_opts)}
        while words and isinstance(command, click.Group):
            if words[0].startswith("-"):
                break
            name = words.pop(0)
            found = command.get_command(context, name)
            assert found is not None, f"bt-manip {line}: no command '{name}'"
            command = found
            own = click.Context(command, help_option_names=names)
            known = command.get_params(own)  # those of views, too
            options |= {name for p in known for name in (*p.opts, *p.secondary_opts)}
        given = {word.partition("=")[0] for word in words if word.startswith("--")}
        assert given <= options | {"--help"}, f"bt-manip {line}"


@pytest.mark.parametrize("page", [page for page in PAGES if "pip install" in PAGES[page]])
def test_a_page_installs_what_exists_with_what_it_requires(page):
    """No index has the packages of plugins/: those that one requires are named with it."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    for line in re.findall(r"pip (?:install|wheel) [^\n`]*", PAGES[page]):
        for extra in re.findall(r"\bbt-manip\[([\w,]+)\]", line):
            assert {*extra.split(",")} <= {*project["optional-dependencies"]}, line
        named = set(re.findall(r"\./plugins/([\w-]+)", line))
        assert {need for name in named for need in required_packages(name)} <= named, line


def test_readme_start_and_site_install_in_the_same_three_ways():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    pages = ("README.md", "docs/start.md", "docs/index.md")
    ways = {block for page in pages for block in blocks(page, "sh") if "pip install" in block}
    assert [re.findall(r"^# (\d)", way, re.MULTILINE) for way in ways] == [["1", "2", "3"]]
    for page in pages:
        assert re.search(rf"\bversion {re.escape(project['version'])}\b", PAGES[page], re.I)
        assert project["license"] in PAGES[page] and "source" in PAGES[page]


@pytest.mark.parametrize("page", [page for page in PAGES if page not in TABLES])
def test_a_page_begins_with_those_whom_it_is_for(page):
    assert re.match(r"# [^\n]+\n\nFor ", PAGES[page])


@pytest.mark.parametrize("page", PAGES)
def test_the_links_of_a_page_lead_to_files_and_headings(page):
    for link, _, heading in re.findall(r"\]\(([^)#\s]*)(#([^)\s]+))?\)", PAGES[page]):
        if "://" in link or (page == "docs/index.md" and f"docs/{link}".startswith(GENERATED)):
            continue
        target = (ROOT / page).parent / link if link else ROOT / page
        assert target.exists(), link
        if heading:
            titles = re.findall(r"^#+ (.*)", target.read_text(encoding="utf-8"), re.MULTILINE)
            assert heading in [title.lower().replace(" ", "-") for title in titles], heading


def test_the_index_of_the_site_leads_to_every_page(tmp_path):
    """Generated pages included, of which some lead to others; its links exist."""
    written = reference_pages.write_all(tmp_path)
    pages = {path.relative_to(tmp_path).as_posix(): path.read_text() for path in written}
    pages |= {name[5:]: text for name, text in PAGES.items() if name.startswith("docs/")}
    found = set()
    for name, text in pages.items():
        for toctree in re.findall(r"^```{toctree}\n(?::[^\n]*\n)*\n(.*?)^```", text, re.S | re.M):
            found |= {os.path.normpath(Path(name).parent / line) for line in toctree.split()}
    assert found == {name.rpartition(".")[0] for name in pages} - {"index"}
    assert set(re.findall(r"\]\(([^)]*\.(?:md|rst))\)", pages["index.md"])) <= set(pages)


def test_the_page_about_testing_names_every_fixture():
    source = (ROOT / "bt_manip" / "testing" / "plugin.py").read_text()
    fixtures = re.findall(r"@pytest\.fixture[^\n]*\ndef ([a-z]\w+)", source)
    assert len(fixtures) >= 8
    assert [name for name in fixtures if f"`{name}`" not in PAGES["docs/testing.md"]] == []


@pytest.mark.parametrize("page", ["CONTRIBUTING.md", "docs/architecture.md", "README.md"])
def test_the_files_that_a_page_names_exist(page):
    named = re.findall(r"`((?:[\w.-]+/)+[\w.-]*|[\w-]+/[\w-]+\.\w+)`", PAGES[page])
    roots = (ROOT, ROOT / "bt_manip", ROOT / "docs")
    saved = {step.name for step in steps(page) if isinstance(step, File)}
    named = [name for name in named if "NAME" not in name and name not in saved]  # a placeholder
    missing = [name for name in named if not any((root / name).exists() for root in roots)]
    assert missing == []


def test_the_table_of_each_node_covers_every_status_and_the_halt():
    reference = node_reference()
    for name in BehaviourRegistry().names():
        table = reference.partition(f"\n### {name}\n")[2].partition("\n###")[0]
        words = ["halt", "FAILURE" if name == "AlwaysFailure" else "SUCCESS"]
        if BehaviourRegistry().get(name).kind in ("Control", "Decorator", "SubTree"):
            words += ["FAILURE", "RUNNING", "SKIPPED"]
        if name.startswith("KeepRunning"):
            words.remove("SUCCESS")
        assert all(word in table for word in words), name


def test_the_page_about_the_language_has_every_script_and_a_tree_that_can_be_read():
    page = PAGES["docs/tree-language.md"]
    for name, attribute in CONDITIONS.items():
        assert f"| `{attribute}` | `{name}` |" in page
    registry = BehaviourRegistry([Hover, Grasp])
    tree = blocks("docs/tree-language.md", "xml")[0]
    assert parse_tree(tree, registry, strict=False).tree_id == "Main"


def test_the_readme_leads_to_every_page():
    linked = set(re.findall(r"\]\(([\w./-]+\.md)(?:#[\w-]+)?\)", PAGES["README.md"]))
    pages = {page for page in PAGES if page.startswith("docs/") and page.count("/") == 1}
    assert pages | {"CONTRIBUTING.md"} <= linked


@pytest.fixture(autouse=True)
def restore_working_directory():
    before = Path.cwd()
    yield
    os.chdir(before)

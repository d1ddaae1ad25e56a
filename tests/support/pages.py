"""The pages of the documentation: their blocks, and the files and commands in them, in order."""

import re
import tomllib
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]

GENERATED = ("docs/_build/", "docs/project/", "docs/reference/")
"""Folders that `make docs` writes."""

PAGES = {
    path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
    for path in (
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        *sorted((ROOT / "docs").rglob("*.md")),
        ROOT / "examples" / "README.md",
        ROOT / "benchmarks" / "README.md",
        *sorted((ROOT / "plugins").glob("*/README.md")),
    )
    if not path.relative_to(ROOT).as_posix().startswith(GENERATED)
}  # texts by path

FENCED = re.compile(r"^```(\w*)\n(.*?)^```", re.DOTALL | re.MULTILINE)
SAVED = re.compile(r"\b[Ss]aved? (?:this |it )?as `([^`\s]+)`")
"""The name of the file whose block follows."""

TYPED = ("bt-manip", "make", "pip", "pytest", "python", "sh", "source", "ssh")
"""What lines of a block begin with if they are commands, and not the output of one."""


class File(NamedTuple):
    """A file that a page tells to save."""

    name: str
    text: str


def blocks(page: str, language: str) -> list[str]:
    """Return the fenced blocks of a language."""
    return [text for name, text in FENCED.findall(PAGES[page]) if name == language]


def steps(page: str) -> list[File | str]:
    """Return the files and the commands of a page in the order of the text, each command once."""
    found: list[File | str] = []
    text = PAGES[page]
    end = 0
    for block in FENCED.finditer(text):
        before, _, paragraph = text[end : block.start()].rstrip().rpartition("\n\n")
        end = block.end()
        found += _inline(before)
        name = SAVED.findall(paragraph)
        if name:
            found.append(File(name[-1], block[2]))
        found += _inline(paragraph)  # also those that run the file saved
        if block[1] in ("", "sh") and not name:
            lines = block[2].replace("\\\n", " ").splitlines()
            found += [_without_comment(line) for line in lines if line.split(" ")[0] in TYPED]
    return list(dict.fromkeys([*found, *_inline(text[end:])]))


def _inline(prose: str) -> list[str]:
    commands = re.findall(r"`((?:bt-manip|pip|pytest) [^`]*)`", prose)
    return [_without_comment(" ".join(line.split())) for line in commands if not SYNOPSIS(line)]


def _without_comment(line: str) -> str:
    return re.sub(r"\s+#.*", "", line)


SYNOPSIS = re.compile(r"\[[A-Z]|\||\.\.\.|\b[A-Z]{3,}\b(?![\w\"'=])").search
"""Finds what makes a line a pattern, to be filled in: words in capitals, alternatives."""


def required_packages(package: str) -> list[str]:
    """Return the packages of plugins/ that one of them requires."""
    path = ROOT / "plugins" / package / "pyproject.toml"
    lines = tomllib.loads(path.read_text())["project"]["dependencies"]
    names = [re.split(r"[^\w-]", line)[0] for line in lines]
    return [name for name in names if (path.parents[1] / name).is_dir()]

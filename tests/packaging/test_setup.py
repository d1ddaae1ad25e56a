"""What stands around the package keeps its word."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from bt_manip.__main__ import main

REPOSITORY = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
CONSTRAINTS = (REPOSITORY / "constraints.txt").read_text()


def constrained() -> dict[str, str]:
    """Give the exact versions by normalised name."""
    lines = [line for line in CONSTRAINTS.splitlines() if not line.startswith("#")]
    pairs = [line.split("==") for line in lines if line]
    return {re.sub(r"[-_.]+", "-", name).lower(): version for name, version in pairs}


@pytest.mark.parametrize(
    "requirement",
    [
        *PROJECT["dependencies"],
        *PROJECT["optional-dependencies"]["dev"],
        *PROJECT["optional-dependencies"]["docs"],
    ],
)
def test_the_exact_version_of_each_dependency_is_in_its_range(requirement):
    wanted = Requirement(requirement)
    version = constrained()[re.sub(r"[-_.]+", "-", wanted.name).lower()]
    assert wanted.specifier.contains(version)


def test_constraints_name_no_host():
    assert not re.search(r"://|--|@", CONSTRAINTS)


def fake_python(folder: Path, version: str) -> Path:
    """Write something that says it is a Python."""
    path = folder / "python"
    path.write_text(f'#!/bin/sh\n[ "$1" = --version ] && echo "Python {version}" || exit 1\n')
    path.chmod(0o755)
    return path


def test_setup_says_which_python_it_needs(tmp_path):
    done = subprocess.run(
        ["sh", "tools/setup.sh"], cwd=REPOSITORY, capture_output=True, text=True,
        env={"PATH": "/usr/bin:/bin", "HOME": str(tmp_path),
             "PYTHON": str(fake_python(tmp_path, "3.13.1"))},
    )  # fmt: skip
    assert done.returncode == 1
    assert "3.11 or 3.12" in done.stderr
    assert "3.13.1" in done.stderr
    assert "make setup PYTHON=" in done.stderr


PYTHON = """#!/bin/sh
case "$*" in
    --version) echo "Python 3.12.1" ;;
    "-m venv --clear .venv") mkdir -p .venv/bin && cp "$0" .venv/bin/python ;;
    "-m pip install"*) echo "Collecting noise"; exit "${PIP:-0}" ;;
esac
"""


@pytest.mark.parametrize("fails", [False, True])
def test_setup_prints_its_steps_and_keeps_the_output_of_pip_in_a_log(tmp_path, fails):
    (tmp_path / "tools").mkdir()
    script = tmp_path / "tools" / "setup.sh"
    script.write_text((REPOSITORY / "tools" / "setup.sh").read_text())
    python = tmp_path / "python"
    python.write_text(PYTHON)
    python.chmod(0o755)
    done = subprocess.run(
        ["sh", script], capture_output=True, text=True,
        env={"PATH": "/usr/bin:/bin", "HOME": str(tmp_path), "PYTHON": str(python),
             "PIP": str(int(fails))},
    )  # fmt: skip
    assert "Making .venv with Python 3.12.1" in done.stdout
    assert "Collecting" not in done.stdout
    assert "Collecting noise" in (tmp_path / ".venv" / "setup.log").read_text()
    assert (tmp_path / ".venv" / ".ready").exists() is not fails
    if fails:
        assert done.returncode == 1
        assert "pip's output is in .venv/setup.log" in done.stderr
    else:
        assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("version", [(3, 10, 2), (3, 13, 0)])
def test_a_start_on_another_python_says_so(version, monkeypatch, capsys):
    monkeypatch.setattr(sys, "version_info", version)
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    error = capsys.readouterr().err
    assert "3.11 or 3.12" in error and ".".join(map(str, version)) in error


def makefile_targets() -> set[str]:
    return set(re.findall(r"^([a-z-]+):", (REPOSITORY / "Makefile").read_text(), re.MULTILINE))


@pytest.mark.parametrize("document", ["README.md", "CONTRIBUTING.md", "docs/architecture.md"])
def test_documents_name_only_commands_that_there_are(document):
    path = REPOSITORY / document
    if not path.exists():
        return
    text = path.read_text()
    assert set(re.findall(r"(?:^|`)make ([a-z-]+)", text, re.MULTILINE)) <= makefile_targets()


def test_the_readme_begins_with_what_a_user_types():
    first_screen = "\n".join((REPOSITORY / "README.md").read_text().splitlines()[:60])
    for command in ("make run", "make test"):
        assert command in first_screen


def test_ci_runs_the_tests_the_linter_the_type_checker_and_the_packages():
    text = (REPOSITORY / ".ci" / "run").read_text()
    order = [
        text.rindex(f"\nmake {target}\n") for target in ("test", "lint", "types", "test-packages")
    ]
    assert order == sorted(order)
    assert subprocess.run(["bash", "-n", ".ci/run"], cwd=REPOSITORY).returncode == 0


def test_the_readmes_plugin_is_picked_and_placed(tmp_path, monkeypatch):
    """Save the README's plugin where its text says, and run what the text says."""
    text = (REPOSITORY / "README.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    (code,) = (block for block in blocks if "register_objects" in block)
    assert 10 <= len([line for line in code.splitlines() if line]) <= 14
    ((file, folder),) = re.findall(r"Save it as `(.*?)` in a folder `(.*?)`", text)
    (tmp_path / folder).mkdir()
    (tmp_path / folder / file).write_text(code)
    (command,) = re.findall(r"`(bt-manip run pick_place --set .*?)`", text)
    done = subprocess.run(
        [Path(sys.prefix) / "bin" / "bt-manip", *command.split()[1:]],
        cwd=tmp_path, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "1 object placed" in done.stdout

"""The page about plugins installs a single file."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"

SINGLE_FILE = """
from bt_manip import hookimpl

@hookimpl
def register_scenes(register):
    pass
"""


def run(*command: object, cwd: Path, **variables: str) -> str:
    """Run something and give what it printed."""
    done = subprocess.run(
        [sys.executable, *map(str, command)], cwd=cwd, capture_output=True, text=True,
        env={**os.environ, **variables}, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_pyproject_of_the_page_installs_a_single_file(tmp_path):
    page = (DOCS / "plugins" / "README.md").read_text()
    (text,) = re.findall(r"```toml\n(\[project\]\n.*?)```", page, re.DOTALL)
    (module,) = tomllib.loads(text)["tool"]["setuptools"]["py-modules"]
    source, target = tmp_path / "source", tmp_path / "target"
    source.mkdir()
    (source / "pyproject.toml").write_text(text)
    (source / f"{module}.py").write_text(SINGLE_FILE)
    (source / f"test_{module}.py").touch()
    run(
        "-m", "pip", "--disable-pip-version-check", "install", "-q", "--no-index", "--no-deps",
        "--no-build-isolation", "--target", target, source, cwd=tmp_path,
    )  # fmt: skip
    listed = run("-m", "bt_manip", "plugins", cwd=tmp_path, PYTHONPATH=str(target))
    assert f"{module} 0.1: ok" in listed

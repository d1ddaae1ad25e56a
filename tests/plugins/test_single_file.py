"""The page about plugins installs a single file."""

import re
import tomllib
from pathlib import Path

from tests.support.program import run_python

DOCS = Path(__file__).resolve().parents[2] / "docs"

SINGLE_FILE = """
from bt_manip import hookimpl

@hookimpl
def register_scenes(register):
    pass
"""


def test_the_pyproject_of_the_page_installs_a_single_file(tmp_path):
    page = (DOCS / "plugins" / "README.md").read_text()
    (text,) = re.findall(r"```toml\n(\[project\]\n.*?)```", page, re.DOTALL)
    (module,) = tomllib.loads(text)["tool"]["setuptools"]["py-modules"]
    source, target = tmp_path / "source", tmp_path / "target"
    source.mkdir()
    (source / "pyproject.toml").write_text(text)
    (source / f"{module}.py").write_text(SINGLE_FILE)
    (source / f"test_{module}.py").touch()
    run_python(
        "-m", "pip", "--disable-pip-version-check", "install", "-q", "--no-index", "--no-deps",
        "--no-build-isolation", "--target", target, source, cwd=tmp_path,
    )  # fmt: skip
    listed = run_python("-m", "bt_manip", "plugins", cwd=tmp_path, PYTHONPATH=str(target))
    assert f"{module} 0.1: ok" in listed

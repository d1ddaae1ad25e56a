"""The hook that the package declares; its plugin is the example of the README."""

import re
from pathlib import Path

import pytest

from bt_manip.plugins import load_plugins

README = Path(__file__).resolve().parents[1] / "README.md"


@pytest.fixture
def parts(tmp_path, monkeypatch):
    """Load the example."""
    (code,) = re.findall(r"```python\n(.*?register_policies.*?)```", README.read_text(), re.DOTALL)
    (tmp_path / "of_register_policies.py").write_text(code)
    monkeypatch.setenv("BT_MANIP_PLUGINS_DIR", str(tmp_path))
    return load_plugins(warn=pytest.fail).parts


def test_register_policies_lets_leaves_run_policies_of_a_kind(parts):
    kind = parts.of("policies").get("act")
    assert (kind.make, kind.load_time) == ("my_policies.act:ActPolicy", 20.0)


def test_what_is_no_kind_of_policies_is_refused(tmp_path, monkeypatch):
    code = "from bt_manip import hookimpl\n@hookimpl\ndef register_policies(register):\n"
    (tmp_path / "wrong.py").write_text(code + "    register('act', 3)\n")
    warned = []
    monkeypatch.setenv("BT_MANIP_PLUGINS_DIR", str(tmp_path))
    load_plugins(warn=warned.append)
    assert "a kind of policies is a PolicyKind, got 3" in "".join(warned)

"""What the page about testing shows does what it says."""

import re
from pathlib import Path

import bt_manip.testing.contract_list
import bt_manip.testing.tree_reading  # noqa: F401  what the inner sessions import goes with them

pytest_plugins = ("pytester",)

PAGE = Path(__file__).parents[2] / "docs" / "testing.md"


def test_the_files_on_the_page_are_tests_that_pass(situations, pytester):
    situations.reset()
    blocks = re.findall(r"```python\n# (\S+\.py)\n(.*?)```", PAGE.read_text(), re.DOTALL)
    for name, code in blocks:
        (pytester.path / name).write_text(code)
    result = pytester.runpytest_inprocess("-p", "no:cacheprovider")
    result.assert_outcomes(passed=sum(code.count("def test_") for _, code in blocks))


def test_the_other_examples_on_the_page_use_what_there_is():
    blocks = re.findall(r"```python\n(?!# )(.*?)```", PAGE.read_text(), re.DOTALL)
    assert len(blocks) == 2
    for code in blocks:
        names: dict[str, object] = {}
        exec(code, names)
        assert [name for name in names if name.startswith("test_")]


def test_the_page_names_every_fixture():
    from bt_manip.testing import plugin

    source = Path(plugin.__file__).read_text()
    fixtures = re.findall(r"@pytest\.fixture.*?\ndef (\w+)", source, re.DOTALL)
    assert len(fixtures) >= 8
    for name in fixtures:
        assert f"`{name}`" in PAGE.read_text(), name


def test_the_page_names_every_contract():
    text = PAGE.read_text()
    for kind in ("behaviour", "object", "robot", "controller"):
        assert f"| {kind} |" in text

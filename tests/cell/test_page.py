"""The page about the cell says what is so: its code runs, from the first line to the last."""

import re
from pathlib import Path

from bt_manip.plugins import load_plugins

PAGE = Path(__file__).resolve().parents[2] / "docs" / "cell.md"


def test_the_code_of_the_page_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert len(blocks) >= 7
    names: dict = {}
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)
    assert ("bin", "cube") in names["cell"].contacts.pairs()


def test_every_registered_object_is_on_the_page_with_its_category():
    parts = load_plugins(entry_points=()).parts
    rows = re.findall(r"^\| (.*) \| `(\w+)` \|$", PAGE.read_text(), re.MULTILINE)
    table = {name: kind for names, kind in rows for name in re.findall(r"`(\w+)`", names)}
    for name in parts.objects.names():
        category = parts.objects.get(name).category
        if category != "sensor":
            assert table.pop(name, None) == category, name
    assert not table

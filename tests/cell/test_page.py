"""The page about the cell lists every registered object."""

import re
from pathlib import Path

from bt_manip.plugins import load_plugins

PAGE = Path(__file__).resolve().parents[2] / "docs" / "cell.md"


def test_every_registered_object_is_on_the_page_with_its_category():
    parts = load_plugins(entry_points=()).parts
    rows = re.findall(r"^\| (.*) \| `(\w+)` \|$", PAGE.read_text(), re.MULTILINE)
    table = {name: kind for names, kind in rows for name in re.findall(r"`(\w+)`", names)}
    for name in parts.objects.names():
        category = parts.objects.get(name).category
        if category != "sensor":
            assert table.pop(name, None) == category, name
    assert not table

"""The page about testing names every fixture."""

import re
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "testing.md"


def test_the_page_names_every_fixture():
    from bt_manip.testing import plugin

    source = Path(plugin.__file__).read_text()
    fixtures = re.findall(r"@pytest\.fixture[^\n]*\ndef ([a-z]\w+)", source, re.DOTALL)
    assert len(fixtures) >= 8
    for name in fixtures:
        assert f"`{name}`" in PAGE.read_text(), name

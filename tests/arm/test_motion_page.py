"""The complete examples of the page about motion run."""

import re
from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs" / "motion.md"


def test_complete_examples_run(capsys):
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    whole = [block for block in blocks if block.startswith("import")]
    assert whole
    for block in whole:
        names: dict = {}
        exec(compile(block, str(PAGE), "exec"), names)
    said = capsys.readouterr().out
    assert "tool: 0.000 mm from its target" in said
    assert re.search(r"^\d\d %: the line can be followed only for \d\d %", said, re.M)

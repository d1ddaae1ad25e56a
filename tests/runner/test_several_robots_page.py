"""The page about several robots says what is so: its code runs, from the first line to the last."""

import re
from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs" / "several-robots.md"


def test_the_code_of_the_page_runs():
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert len(blocks) == 2
    names: dict = {}
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)
    assert names["left"].arm.moving and names["right"].arm.moving

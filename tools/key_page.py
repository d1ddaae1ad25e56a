"""Write docs/robot-keys.md: the keys of a robot's description, as its dataclasses declare them.

``python tools/key_page.py`` writes the page; a test fails where it is out of date.
"""

from itertools import groupby
from pathlib import Path

from bt_manip.grippers.suction.parameters import SuctionParameters
from bt_manip.grippers.two_finger.parameters import TwoFingerParameters
from bt_manip.robots import RobotDescription
from bt_manip.toml_fields import Row, rows

PAGE = Path(__file__).resolve().parent.parent / "docs" / "robot-keys.md"

HEAD = """# Keys of a robot's description

A TOML file describes an arm with its gripper; [`bt-manip robot new`](howto/describe-your-robot.md)
writes one. Unknown keys and invalid values are refused with the file, the line and the nearest key.
In Python, `bt_manip.robots.RobotDescription` has the same fields, with each pose as one of them.

Of `quat_wxyz` and `rpy` [rad], one gives the rotation of a pose.
"""

KINDS = (
    ("two_finger", TwoFingerParameters, "two fingers or a jaw: the default kind"),
    ("suction", SuctionParameters, "a suction cup, whose lip is the tool frame"),
)


def page() -> str:
    """Give the text of the page."""
    parts = [HEAD]
    whole = sorted(rows(RobotDescription), key=lambda row: row.table)
    for table, found in groupby(whole, key=lambda row: row.table):
        keys = [row for row in found if row.name != "..."]
        parts.append(f"\n## {f'`[{table}]`' if table else 'The file'}\n\n{_table(keys)}")
    for kind, cls, what in KINDS:
        parts.append(f'\n## `[gripper]` with `kind = "{kind}"`\n\nOf {what}.\n\n')
        parts.append(_table(rows(cls, "gripper")))
    return "".join(parts)


def _table(found: list[Row]) -> str:
    lines = ["| key | type | unit | default | bounds | |\n|---|---|---|---|---|---|\n"]
    for row in found:
        inner = row.table.removeprefix("gripper").lstrip(".") if "." in row.table else ""
        name = ", ".join(f"`{f'{inner}.' if inner else ''}{n}`" for n in row.name.split(", "))
        cells = (name.replace(" or ", "` or `"), row.type, row.unit, row.default, row.bounds)
        lines.append(f"| {' | '.join(cells)} | {row.meaning} |\n")
    return "".join(lines)


if __name__ == "__main__":
    PAGE.write_text(page())

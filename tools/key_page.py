"""Write the pages of keys, docs/robot-keys.md and docs/scene-keys.md, from the dataclasses.

``python tools/key_page.py`` writes them; a test fails where one is out of date.
"""

from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

from bt_manip.grippers.two_finger.parameters import TwoFingerParameters
from bt_manip.robots import RobotDescription
from bt_manip.scenes import Scene
from bt_manip.toml import entries_of
from bt_manip_hands.suction.parameters import SuctionParameters

DOCS = Path(__file__).resolve().parent.parent / "docs"

ROBOT_HEAD = """# Keys of a robot's description

For those who describe a robot: a TOML file describes an arm with its gripper;
[`bt-manip robot new`](howto/describe-your-robot.md) writes one. Unknown keys and invalid values are
refused with the file, the line and the nearest key. In Python, `bt_manip.robots.RobotDescription`
has the same fields, with each pose as one of them.

Of `quat_wxyz` and `rpy` [rad], one gives the rotation of a pose.
"""

SCENE_HEAD = """# Keys of a scene file

For authors of scenes: a TOML file describes a [scene](scenes.md). Unknown keys and invalid values
are refused with the file, the line and the nearest key. In Python, `bt_manip.scenes.Scene` has the
same fields, with each pose as one of them, and cameras among the `objects`.

Of `quat_wxyz` and `rpy` [rad], one gives the rotation of a pose; in `[[cameras]]`, `looking_at`
does, too. Paths are from the folder of the file. `[randomization]` has
[tables of its own](scenes.md#what-varies).
"""

KINDS = (
    ("two_finger", TwoFingerParameters, "two fingers or a jaw: the default kind"),
    (
        "suction",
        SuctionParameters,
        "a suction cup ([bt-manip-hands](../plugins/bt-manip-hands)), whose lip is the tool frame",
    ),
)


class Row(NamedTuple):
    """A key in a table; all cells are text."""

    table: str
    name: str
    type: str
    unit: str
    default: str
    bounds: str
    meaning: str


def robot_page() -> str:
    """Return the page of a robot's keys."""
    parts = [_page(ROBOT_HEAD, RobotDescription)]
    for kind, cls, what in KINDS:
        parts.append(f'\n## `[gripper]` with `kind = "{kind}"`\n\nOf {what}.\n\n')
        parts.append(_table(rows(cls, "gripper")))
    return "".join(parts)


def scene_page() -> str:
    """Return the page of a scene's keys."""
    return _page(SCENE_HEAD, Scene)


PAGES = {DOCS / "robot-keys.md": robot_page, DOCS / "scene-keys.md": scene_page}


def _page(head: str, cls: type) -> str:
    parts = [head]
    found = sorted(rows(cls), key=_whole_table)
    for table, keys in groupby(found, key=_whole_table):
        parts.append(f"\n## {f'`[{table}]`' if table else 'The file'}\n\n{_table(list(keys))}")
    return "".join(parts)


def rows(cls: type, table: str = "") -> list[Row]:
    """Return the keys of a dataclass and its parts.

    The name of its table is empty for the file itself; arrays of tables are in brackets.
    """
    found, parts = [], []
    for entry in entries_of(cls):
        place = ".".join(filter(None, (table, entry.table)))
        inner = getattr(entry.values, "cls", None)
        tables = getattr(entry.values, "tables", {} if inner is None else {entry.name: inner})
        for name, part in tables.items():
            parts += rows(part, ".".join(filter(None, (place, name))))
        if not tables:
            names = getattr(entry.values, "names", entry.name)
            default = "required" if entry.needed else _default_text(entry.default)
            cells = (place, names, entry.form, entry.unit, default, entry.bounds, entry.meaning)
            found.append(Row(*cells))
    return found + parts


def _default_text(default: Any) -> str:
    if isinstance(default, float):
        return f"{default:g}"
    return default if isinstance(default, str) else ""


def _whole_table(row: Row) -> str:
    """Return the table that lists a key; that of a part lists it with the part's name."""
    return row.table.split(".")[0]


def _table(found: list[Row]) -> str:
    lines = ["| key | type | unit | default | bounds | |\n|---|---|---|---|---|---|\n"]
    for row in found:
        inner = "".join(f"{part}." for part in row.table.split(".")[1:])
        name = ", ".join(f"`{inner}{n}`" for n in row.name.split(", ")).replace(" or ", "` or `")
        name = "other keys" if row.name == "..." else name
        cells = (name, row.type, row.unit, row.default, row.bounds)
        lines.append(f"| {' | '.join(cells)} | {row.meaning} |\n")
    return "".join(lines)


if __name__ == "__main__":
    for path, text in PAGES.items():
        path.write_text(text())

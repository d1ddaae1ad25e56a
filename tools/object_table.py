"""Write the page docs/object_table.md: objects of others, and how often the Panda picks them.

``python tools/object_table.py FOLDER`` reads the object models of `SOURCES` below a folder with
copies of public repositories, ``OWNER/NAME``, and runs 5 cycles of pick_place with each. Rows of
objects that are not there are kept as they are. It takes about 20 s for each object.
"""

import argparse
import os
import re
from pathlib import Path

os.environ.setdefault("MUJOCO_GL", "disable")

from arm_table import shortened_reason

from bt_manip import load_plugins
from bt_manip.exceptions import BtManipError
from bt_manip.registry import Parts
from bt_manip.runner import RunObserver, prepare, request_of

PAGE = Path(__file__).resolve().parent.parent / "docs" / "object_table.md"
CYCLES = 5
SEED = 1
HEAD = f"""# Objects of others

Object models as their authors wrote them, in place of the cube of `pick_place`: cycles that
succeeded of {CYCLES} with the Panda, and the first reason of a failure. Made by
`python tools/object_table.py FOLDER`.

The floor of the basket is 205 mm by 129 mm: the hammer (334 mm) is longer than it, the scissors
(205 mm) and the block (150 mm) than its width.
"""
_MODELS = "pybullet-object-models/pybullet_object_models"
SOURCES = {
    "YCB": f"eleramp/{_MODELS}/ycb_objects/*/model.urdf",
    "primitives": f"ac-93/{_MODELS}/primitive_objects/*/*.urdf",
    "random": f"ac-93/{_MODELS}/random_objects/00[0-7]/*.urdf",
}
"""Paths of the models by the name of their set."""


class Watch(RunObserver):
    """Counts cycles that succeed, and keeps the reason of the first that does not."""

    def __init__(self) -> None:
        self.cycles = self.picked = 0
        self.reason = ""

    def cycle_ended(self, status: str, reason: str) -> None:
        """Count the cycle."""
        self.cycles += 1
        self.picked += status == "SUCCESS"
        if status != "SUCCESS":
            self.reason = self.reason or reason


def picks(model: Path, parts: Parts, folder: Path) -> tuple[str, str]:
    """Return the cycles in which an object was picked, and why not in all, as cells."""
    watch = Watch()
    try:
        settings = {"cube": str(model)}
        request = request_of("pick_place", parts, cycles=CYCLES, seed=SEED, settings=settings)
        prepare(request, parts).execute([watch])
    except BtManipError as error:
        reason = str(error).partition(f"{model}: ")[2] or str(error)
        return "refused", plain(reason, folder)
    return f"{watch.picked} of {CYCLES}", plain(watch.reason, folder)


def plain(reason: str, folder: Path) -> str:
    """Return a reason without the node that gives it: ``attempt/Drop::21: ...``."""
    return shortened_reason(re.sub(r"^[\w/]+::\d+: ", "", reason), folder)


def total(lines: list[str]) -> str:
    """Return how many objects of the table were picked, as a sentence."""
    cells = [line.split(" | ")[2] for line in lines]
    whole = sum(cell == f"{CYCLES} of {CYCLES}" for cell in cells)
    some = sum(cell[:1] in "123456789" for cell in cells)
    return f"Of {len(cells)} objects, {whole} were picked in all cycles, {some} in at least one."


def main() -> None:
    """Write the table after each object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", default="", metavar="TEXT", help="paths that contain this text")
    given = parser.parse_args()
    folder, parts = given.folder.resolve(), load_plugins().parts
    lines = {}
    for line in PAGE.read_text().splitlines() if PAGE.exists() else ():
        if (
            line.startswith("| ")
            and line.count(" | ") == 3
            and not line.startswith(("| object", "| ---"))
        ):
            lines[tuple(line.split(" | ")[:2])] = line
    for kind, pattern in SOURCES.items():
        for path in sorted(folder.glob(pattern)):
            if given.only in str(path):
                key = (f"| {path.parent.name}", f"{pattern.partition('/')[0]}, {kind}")
                lines[key] = " | ".join((*key, *picks(path, parts, folder))) + " |"
                rows = "\n".join(lines.values())
                table = f"| object | source | picks | why not |\n| --- | --- | --- | --- |\n{rows}"
                PAGE.write_text(f"{HEAD}\n{table}\n\n{total(list(lines.values()))}\n")
                print(lines[key], flush=True)


if __name__ == "__main__":
    main()

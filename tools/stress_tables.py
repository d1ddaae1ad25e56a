"""Stress trees with one seed, and write the whole tables to a page, one section for each tree.

``python tools/stress_tables.py`` tests all trees of the project and its packages, which takes
hours; ``python tools/stress_tables.py open_drawer press_button`` only these, and keeps the other
sections. ``--workers N`` sets the number of processes. Trees with seen poses (``*_seen``) are left
out unless they are named, which need MUJOCO_GL=egl, and so is that of a policy, which needs one.
"""

import argparse
import os
import re
from functools import partial
from pathlib import Path

os.environ.setdefault("MUJOCO_GL", "disable")

from bt_manip.evaluation import run_episodes
from bt_manip.plugins import load_plugins
from bt_manip_stress import StressTable, StressTester, plan_episodes

PAGE = Path(__file__).resolve().parent.parent / "docs" / "stress_tables.md"
HEADER = """# Stress tables

Made by `make stress-tables`, a tree at a time; [faults and stress tests](stress.md) explains the
letters, and why some faults are not recovered from.
"""
SEEN, POLICY = "_seen", "_policy"


def table_of(tree: str, workers: int) -> str:
    """Return the section of a tree."""
    poses = "seen" if tree.endswith(SEEN) else "physics"
    tester = partial(StressTester, tree, poses=poses)
    episodes = plan_episodes(tester(), 1)
    done = {result.episode: result for result in run_episodes(tester, episodes, workers)}
    table = StressTable([done[episode] for episode in episodes])
    print(f"{tree}: {table.summary()}", flush=True)
    return table.markdown(f"bt-manip stress {tree}")


def read_sections() -> dict[str, str]:
    """Return the sections of the present page by tree."""
    text = PAGE.read_text() if PAGE.exists() else ""
    parts = re.split(r"^## (\w+)\n\n", text, flags=re.MULTILINE)
    return dict(zip(parts[1::2], (part.strip() + "\n" for part in parts[2::2]), strict=True))


def write_page(sections: dict[str, str]) -> None:
    """Write the sections of all trees below their totals."""
    totals, body = "", ""
    for tree, section in sorted(sections.items()):
        total = re.search(r"^\d+ faults.*?\.", section, re.MULTILINE)
        totals += f"- [`{tree}`](#{tree}): {total[0] if total else ''}\n"
        body += f"\n## {tree}\n\n{section}"
    PAGE.write_text(f"{HEADER}\n{totals}{body}")


def main() -> None:
    """Write the page after each tree."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("trees", nargs="*")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    known = load_plugins().parts.trees.names()
    chosen = given.trees or [name for name in known if not name.endswith((SEEN, POLICY))]
    sections = read_sections()
    for tree in chosen:
        sections[tree] = table_of(tree, given.workers)
        write_page(sections)


if __name__ == "__main__":
    main()

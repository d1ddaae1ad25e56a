"""Run episodes of the tasks with several robots, and write the table to a page.

``python tools/task_table.py panda fr3 my_arm.toml`` runs 20 episodes of each task with these
robots; ``--tasks open_drawer --episodes 5`` only some. Cells that are not run again are kept. Where
`bt-manip list tasks --episodes 3` has a reason against a task, the cell says no.
"""

import argparse
import os
from functools import partial
from pathlib import Path

os.environ.setdefault("MUJOCO_GL", "disable")

from bt_manip.evaluation import EpisodeId, EpisodeWorker, Evaluation, run_episodes, why_not
from bt_manip.exceptions import one_line
from bt_manip.plugins import load_plugins

TASKS = (
    "pick_place", "pick_place_cluttered", "stack_blocks", "sort_blocks", "mug_on_shelf",
    "cans_into_box", "press_button", "peg_in_hole", "open_drawer", "hand_over",
)  # fmt: skip
PAGE = Path(__file__).resolve().parent.parent / "docs" / "task_table.md"
HEADER = """# Tasks by robots

Episodes that succeeded, made by `python tools/task_table.py ROBOT ...`; `no`: `bt-manip list tasks
--episodes 3` finds a reason first. Robots in files were written by `bt-manip robot new`.
"""
REASONS = "## Why not all"
TRIALS = 3
"""Episodes, with other numbers and another seed, that look for a reason first."""

Cells = dict[tuple[str, str], tuple[str, str]]


def run_cell(task: str, robot: str, episodes: int, seed: int, workers: int) -> tuple[str, str]:
    """Return how many episodes of a task succeeded with a robot, and why not all did."""
    reason = why_not(task, robot, load_plugins().parts, episodes=TRIALS)
    if reason:
        return "no", f"before the run: {reason}"
    evaluation = Evaluation(task, {"robot": robot, "seed": seed})
    ids = [EpisodeId(0, i) for i in range(episodes)]
    results = list(run_episodes(partial(EpisodeWorker, evaluation), ids, workers))
    done = sum(result.success for result in results)
    failed = [f"{result.node}: {result.reason}" for result in results if not result.success]
    return f"{done} of {episodes}", one_line(failed[0]) if failed else ""


def read_page() -> Cells:
    """Return the cells of the present page, by task and robot."""
    lines = PAGE.read_text().splitlines() if PAGE.exists() else []
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if line[:2] == "| "]
    if not rows:
        return {}
    robots = rows[0][1:]
    reasons = {(row[0], row[1]): row[2] for row in rows if len(row) == 3 and row[1] in robots}
    return {
        (row[0], robot): (cell, reasons.get((row[0], robot), ""))
        for row in rows[1:]
        if row[0] in TASKS and len(row) == len(rows[0])
        for robot, cell in zip(robots, row[1:], strict=True)
        if cell
    }


def write_page(cells: Cells) -> None:
    """Write the table, and why episodes failed."""
    robots = list(dict.fromkeys(robot for _, robot in cells))
    tasks = [task for task in TASKS if any(task == one for one, _ in cells)]
    table = [["task", *robots], ["---"] * (len(robots) + 1)]
    table += [[f"{t}", *(cells.get((t, r), ("", ""))[0] for r in robots)] for t in tasks]
    reasons = [["task", "robot", "reason"], ["---"] * 3]
    failed = [(t, r) for t in tasks for r in robots if cells.get((t, r), ("", ""))[1]]
    reasons += [[t, r, cells[t, r][1]] for t, r in failed]
    parts = ["\n".join(f"| {' | '.join(row)} |" for row in rows) for rows in (table, reasons)]
    PAGE.write_text(f"{HEADER}\n{parts[0]}\n\n{REASONS}\n\n{parts[1]}\n")


def main() -> None:
    """Write the page after each cell."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robots", nargs="+")
    parser.add_argument("--tasks", nargs="+", default=TASKS, choices=TASKS)
    parser.add_argument("--episodes", type=int, default=20)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    for task in given.tasks:
        for robot in given.robots:
            found = run_cell(task, robot, given.episodes, given.seed, given.workers)
            name = Path(robot).stem
            print(f"{task} {name}: {': '.join(filter(None, found))}", flush=True)
            write_page(read_page() | {(task, name): (found[0], found[1].replace("|", "/"))})


if __name__ == "__main__":
    main()

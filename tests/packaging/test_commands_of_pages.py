"""The commands of the pages that a newcomer follows, from the wheels, in a new folder.

They run in the order of the page, on the files that it tells to save. Those that run until Ctrl-C
get it after 30 s of simulated time, or where only the page is left.
"""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.pages import PAGES, ROOT, File, steps
from tools import test_packages as tool

SIMULATED = 30.0
"""Simulated time after which a command that runs until Ctrl-C gets it [s]."""

FOLLOWED = [
    page
    for page in PAGES
    if page in ("README.md", "docs/start.md")
    or page.startswith(("docs/howto/", "docs/plugins/README.md", "docs/plugins/tutorials/"))
]

NOT_RUN = {
    r"make |source ": "in a clone: test_setup.py and test_first_minutes.py",
    r"pip (install|wheel) .*\./plugins|pip (wheel|install dist)": "the wheels are installed",
    r"pip install bt-manip": "no index has it",
    r".*--window": "needs a display",
    r"ssh ": "needs another computer",
    r"bt-manip (run|export|evaluate|stress|robot new)$": "the name of a command",
}
"""Regular expressions of commands that are not run, and why."""

STANDS_FOR = {"my_task": "pick_place"}
"""What to fill in for names of the reader's."""

QUICK = {
    "README.md": ("bt-manip run pick_place --set cube=brick --plugins-dir my_plugins",),
    "docs/start.md": (
        "bt-manip run pick_place --seed 1",
        "bt-manip tree show pick_place",
        "bt-manip tree check tidy.xml",
        "bt-manip run tidy.xml",
    ),
}
"""Commands that are run with all other tests: they take 10 s. ``make soak`` runs all."""


def prepare(page: str, folder: Path) -> None:
    """Put into the folder what a page presupposes."""
    gear = ROOT / "templates" / "robot" / "bt_manip_gear" / "gear.xml"
    match page:
        case "docs/plugins/README.md":
            (block,) = (s.text for s in steps("README.md") if s[0] == "my_plugins/brick.py")
            save(File("brick.py", block), folder)
            save(File("my_plugins/brick.py", block), folder)
        case "docs/howto/an-arm-of-your-own.md":
            shutil.copy(gear, folder / "model.xml")
        case "docs/howto/describe-your-robot.md":
            arm = Path(os.environ["MENAGERIE_ROOT"]) / "universal_robots_ur5e"
            shutil.copytree(arm, folder, dirs_exist_ok=True)
            (folder / "ur5e.xml").rename(folder / "my_arm.xml")
        case "docs/plugins/tutorials/robot.md":
            shutil.copy(gear, folder)
        case "docs/howto/groot2.md":
            shutil.copytree(ROOT / "examples", folder / "examples")
        case "docs/howto/testing-in-ci.md":
            shutil.copytree(ROOT / "scenes", folder / "scenes")
            (folder / "trees").mkdir()
            shutil.copy(ROOT / "examples" / "3_first_tree.xml", folder / "trees")


def save(file: File, folder: Path) -> None:
    path = folder / file.name
    path.parent.mkdir(exist_ok=True)
    path.write_text(file.text)


@pytest.fixture(scope="module")
def install(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """Return a function that makes an environment of wheels and returns its interpreter."""

    def make(plugins: bool) -> Path:
        work = tmp_path_factory.mktemp("installed")
        python = tool.make_environment(work / "env")
        files = sorted(ROOT.glob("plugins/*/pyproject.toml")) if plugins else ()
        folders = [ROOT, *(file.parent for file in files)]
        tool.install(python, *(tool.build_wheel(folder, work / "wheels") for folder in folders))
        pip = f"{sys.executable} -m pip --python {python}"
        for name, command in {"pip": pip, "pytest": f"{python} -m pytest"}.items():
            script = python.parent / name
            script.write_text(f'#!/bin/sh\nexec {command} "$@"\n')
            script.chmod(0o755)
        return python

    return make


@pytest.fixture(scope="module")
def core(install: Callable[..., Path]) -> Path:
    return install(plugins=False)


@pytest.fixture(scope="module")
def everything(install: Callable[..., Path]) -> Path:
    return install(plugins=True)


def start(line: str, folder: Path, python: Path) -> subprocess.Popen[str]:
    """Start a command line in a folder, as in an activated environment."""
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "DISPLAY")}
    environment["PATH"] = f"{python.parent}:{environment['PATH']}"
    environment |= {"PIP_NO_INDEX": "1", "PIP_NO_BUILD_ISOLATION": "0"}  # that is: without it
    return subprocess.Popen(
        ["bash", "-c", line], cwd=folder, env=environment, text=True, start_new_session=True,
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip


def run(line: str, folder: Path, python: Path) -> str:
    """Run a command line that ends by itself; return its output."""
    process = start(line, folder, python)
    output, _ = process.communicate(timeout=600)
    assert process.returncode == 0, f"{line}\n{output}"
    assert "Traceback" not in output, f"{line}\n{output}"
    return output


def run_until_interrupted(line: str, folder: Path, python: Path) -> None:
    """Run a command line as fast as possible, and interrupt it; no cycle may fail.

    With ``--watch``, the height of the tree is edited halfway.
    """
    report = folder / "until_interrupted.jsonl"
    report.unlink(missing_ok=True)
    runs = line.startswith("bt-manip run")
    process = start(f"{line} --report {report} --real-time 0" if runs else line, folder, python)
    edited = "--watch" not in line
    try:
        deadline = time.monotonic() + (300 if runs else SIMULATED)
        while time.monotonic() < deadline and process.poll() is None:
            time.sleep(0.1)
            simulated = sum(cycle["duration_s"] for cycle in cycles(report)) if runs else 0
            if simulated > SIMULATED / 2 and not edited:
                tree = folder / line.split()[2]
                tree.write_text(tree.read_text().replace('height="0.15"', 'height="0.1"'))
                edited = True
            if simulated > SIMULATED or has_ended(report):
                break
        interrupted = process.poll() is None
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGINT)
        output, _ = process.communicate(timeout=60)
    assert interrupted, f"{line} ended by itself\n{output}"
    assert simulated > SIMULATED or has_ended(report) or not runs, f"{line} hangs\n{output}"
    assert process.returncode in (0, 130), f"{line}\n{output}"
    assert "Traceback" not in output, f"{line}\n{output}"
    failed = [cycle["reason"] for cycle in cycles(report) if cycle["status"] == "FAILURE"]
    assert failed == []


def rows(report: Path, kind: str) -> list[dict]:
    """Return the rows of a kind that a report has by now."""
    lines = report.read_text().splitlines(keepends=True) if report.exists() else []
    found = [json.loads(line) for line in lines if line.endswith("\n")]
    return [row for row in found if row["type"] == kind]


def cycles(report: Path) -> list[dict]:
    return rows(report, "cycle")


def has_ended(report: Path) -> bool:
    """Return whether the run is over, and only its page is served."""
    return bool(rows(report, "end"))


def follow(page: str, folder: Path, python: Path, only: tuple[str, ...] = ()) -> None:
    """Do what a page says, or what is in `only`."""
    prepare(page, folder)
    for step in steps(page):
        if isinstance(step, File):
            save(step, folder)
        elif only and step not in only:
            continue
        elif not any(re.match(pattern, step) for pattern in NOT_RUN):
            line = " ".join(STANDS_FOR.get(word, word) for word in step.split(" "))
            if re.search(r"--cycles 0|--view|^bt-manip view", line):
                run_until_interrupted(line, folder, python)
            else:
                run(line, folder, python)
            if page.startswith("docs/plugins/tutorials/") and line.startswith("bt-manip new"):
                for command in steps("docs/plugins/README.md")[1:3]:  # which they refer to
                    run(command, folder, python)
    if page.startswith("docs/plugins/"):
        run("pip uninstall -y bt-manip-gear bt-manip-brick", folder, python)


@pytest.mark.parametrize("page", QUICK)
def test_the_first_commands_of_a_page_work_with_the_wheel_alone(page, core, tmp_path):
    assert {*QUICK[page]} <= {*steps(page)}
    follow(page, tmp_path, core, QUICK[page])


def test_trees_and_models_travel_in_the_wheel(core):
    (wheel,) = core.parents[2].glob("wheels/*.whl")
    packed = set(zipfile.ZipFile(wheel).namelist())
    bundled = [*ROOT.glob("trees/**/*.xml"), *ROOT.glob("models/**/*.xml")]
    bundled += ROOT.glob("scenes/*.toml")
    assert {f"bt_manip/bundled/{path.relative_to(ROOT).as_posix()}" for path in bundled} <= packed
    assert not [name for name in packed if "__pycache__" in name]
    assert "bt_manip/py.typed" in packed
    assert any(name.endswith("licenses/LICENSE") for name in packed)
    tops = {name.partition("/")[0] for name in packed}
    assert tops == {"bt_manip", next(top for top in tops if top.endswith(".dist-info"))}


def report_of(line: str, folder: Path, python: Path) -> dict:
    """Run a command line that writes a report and no errors or other files; return the report."""
    assert run(f"{line} --report report.json 2>&1 >/dev/null", folder, python) == ""
    assert [path.name for path in folder.iterdir()] == ["report.json"]
    return json.loads((folder / "report.json").read_text())


def test_pick_place_runs_from_the_wheel_in_an_empty_folder(core, tmp_path):
    place = "python -c 'import bt_manip; print(bt_manip.__file__)'"
    environment = str(core.parents[1])
    assert run(place, tmp_path, core).startswith(environment)
    assert environment in run("bt-manip list trees", tmp_path, core)
    (cycle,) = report_of("bt-manip run pick_place", tmp_path, core)["cycles"]
    assert cycle["placed"] is True


@pytest.mark.soak
def test_two_robots_pick_from_the_wheel_too(core, tmp_path):
    (cycle,) = report_of("bt-manip run two_arms --seed 1", tmp_path, core)["cycles"]
    picked = {name: len(robot["picked"]) for name, robot in cycle["robots"].items()}
    assert picked == {"left": 2, "right": 2}
    assert cycle["placed"] is True and cycle["unexpected_contacts"] == []


@pytest.mark.soak
def test_the_same_seed_is_the_same_run_from_the_wheel_and_from_the_sources(core, tmp_path):
    line = "bt-manip run pick_place --seed 3 --quiet"
    wheel, source = (report_of(line, tmp_path, python) for python in (core, Path(sys.executable)))
    assert wheel["state_digest"] == source["state_digest"]


@pytest.mark.soak
@pytest.mark.parametrize("page", FOLLOWED)
def test_the_commands_of_a_page_work_in_order(page, everything, tmp_path, menagerie, monkeypatch):
    monkeypatch.setenv("MENAGERIE_ROOT", str(menagerie))
    follow(page, tmp_path, everything)


def test_each_reason_not_to_run_a_command_is_of_one():
    commands = [step for page in FOLLOWED for step in steps(page) if isinstance(step, str)]
    unused = [p for p in NOT_RUN if not any(re.match(p, command) for command in commands)]
    assert unused == []

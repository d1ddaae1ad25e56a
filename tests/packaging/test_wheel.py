"""The wheel has everything: it runs where nothing else of the project is."""

import json
import os
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """Build the wheel."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder)]
    done = subprocess.run(
        [*command, str(REPOSITORY)], capture_output=True, text=True, stdin=subprocess.DEVNULL
    )
    assert done.returncode == 0, done.stdout + done.stderr
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def elsewhere(wheel, tmp_path_factory) -> Path:
    """Install the wheel into an environment that shares only what others have made."""
    folder = tmp_path_factory.mktemp("elsewhere") / "env"
    venv.create(folder, with_pip=False)
    python = folder / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--python", str(python)]
    subprocess.run([*pip, "install", "-q", "--no-index", "--no-deps", str(wheel)], check=True)
    # Packages of others come from the environment of this test, after the wheel's own.
    (site,) = folder.glob("lib/python*/site-packages")
    others = sysconfig.get_path("purelib")
    (site / "others.pth").write_text(f"import site; site.addsitedir({others!r})\n")
    return folder


def run(environment: Path, cwd: Path, *command: str) -> subprocess.CompletedProcess[str]:
    variables = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "MUJOCO_GL")}
    return subprocess.run(
        [str(environment / "bin" / command[0]), *command[1:]],
        cwd=cwd, env=variables, capture_output=True, text=True, stdin=subprocess.DEVNULL,
    )  # fmt: skip


def test_trees_and_models_travel_in_the_wheel(wheel):
    packed = set(zipfile.ZipFile(wheel).namelist())
    for folder in ("trees", "models"):
        for path in (REPOSITORY / folder).rglob("*.xml"):
            assert f"bt_manip/bundled/{path.relative_to(REPOSITORY).as_posix()}" in packed
    for path in (REPOSITORY / "scenes").glob("*.toml"):
        assert f"bt_manip/bundled/scenes/{path.name}" in packed
    for path in (REPOSITORY / "templates").rglob("pyproject.toml"):
        assert f"bt_manip/bundled/{path.relative_to(REPOSITORY).as_posix()}" in packed
    assert not [name for name in packed if "__pycache__" in name]
    assert "bt_manip/py.typed" in packed
    assert any(name.endswith("licenses/LICENSE") for name in packed)
    tops = {name.partition("/")[0] for name in packed}
    assert tops == {"bt_manip", next(top for top in tops if top.endswith(".dist-info"))}


def test_pick_place_runs_from_the_wheel_in_an_empty_folder(elsewhere, tmp_path):
    place = "import bt_manip; print(bt_manip.__file__)"
    assert run(elsewhere, tmp_path, "python", "-c", place).stdout.startswith(str(elsewhere))
    trees = run(elsewhere, tmp_path, "bt-manip", "list", "trees")
    assert f"{elsewhere}" in trees.stdout, trees.stderr
    done = run(elsewhere, tmp_path, "bt-manip", "run", "pick_place", "--report", "report.json")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    (cycle,) = json.loads((tmp_path / "report.json").read_text())["cycles"]
    assert cycle["placed"] is True
    assert [path.name for path in tmp_path.iterdir()] == ["report.json"]


@pytest.mark.soak
def test_two_robots_pick_from_the_wheel_too(elsewhere, tmp_path):
    command = ("bt-manip", "run", "two_arms", "--seed", "1", "--report", "report.json")
    done = run(elsewhere, tmp_path, *command)
    assert (done.returncode, done.stderr) == (0, "")
    (cycle,) = json.loads((tmp_path / "report.json").read_text())["cycles"]
    assert {name: len(robot["picked"]) for name, robot in cycle["robots"].items()} == {
        "left": 2,
        "right": 2,
    }
    assert cycle["placed"] is True and cycle["unexpected_contacts"] == []


@pytest.mark.soak
def test_the_same_seed_is_the_same_run_in_two_processes(elsewhere, tmp_path):
    """One process runs the wheel, the other the sources."""
    command = ("bt-manip", "run", "pick_place", "--seed", "3", "--quiet", "--report")
    assert run(elsewhere, tmp_path, *command, "wheel.json").returncode == 0
    assert run(Path(sys.prefix), tmp_path, *command, "source.json").returncode == 0
    wheel, source = (json.loads((tmp_path / f"{n}.json").read_text()) for n in ("wheel", "source"))
    assert wheel["state_digest"] == source["state_digest"]

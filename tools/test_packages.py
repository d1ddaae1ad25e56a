"""Test each package of plugins/ where it finds what its users have, and nothing of this checkout.

Every package gets a fresh environment: the third-party packages of the environment that this runs
in, the wheel of bt-manip, the package's own wheel, and those of the packages of plugins/ that it
requires, for its tests (extra `test`) too. Its tests run from a copy outside of the repository,
with `tests/support`, which all tests share.

    .venv/bin/python tools/test_packages.py [FOLDER...]
"""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import tomllib
import venv
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
OURS = ("bt_manip", "_bt_manip", "__editable__")
"""What the names of installed files of this project begin with."""

MODELS = {
    "MENAGERIE_ROOT": "menagerie",
    "MENAGERIE_MORE_ROOT": "menagerie_more",
    "BTCPP_ROOT": "btcpp",
    "NAV2_ROOT": "nav2",
    "MOVEIT_PRO_ROOT": "moveit_pro",
}
"""Environment variables of folders beside the checkout."""

PYTEST = ("-m", "pytest", "-q", "-p", "no:cacheprovider", "--import-mode=importlib")
PYTEST += ("-n", "2", "--dist", "loadfile")
PYTEST += ("-m", "not soak", "-o", "markers=soak")  # what takes minutes has its own time


def main(arguments: list[str]) -> int:
    """Test the packages; give 1 if any fails."""
    folders = [Path(a) for a in arguments] or sorted(
        file.parent for file in (REPOSITORY / "plugins").glob("*/pyproject.toml")
    )
    failed = []
    with tempfile.TemporaryDirectory() as temporary:
        work = Path(temporary)
        ours = build_wheel(REPOSITORY, work / "bt-manip")
        for folder in folders:
            print(f"--- {folder.name}", flush=True)
            python = make_environment(work / folder.name / "env", ours)
            for each in (folder, *required(folder)):
                install(python, build_wheel(each, work / folder.name / each.name))
            if not test(python, folder, work / folder.name / "tested"):
                failed.append(folder.name)
    if failed:
        print(f"failed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


def required(folder: Path) -> list[Path]:
    """Give the folders of the packages of plugins/ that a package and its tests require."""
    project = tomllib.loads((folder / "pyproject.toml").read_text())["project"]
    extras = project.get("optional-dependencies", {})
    lines = [*project["dependencies"], *extras.get("test", [])]
    folders = (folder.resolve().parent / re.split(r"[^\w-]", line)[0] for line in lines)
    return [one for one in folders if one.is_dir()]


def build_wheel(source: Path, into: Path) -> Path:
    """Build a wheel with the tools of this environment."""
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(into)]
    done = subprocess.run(
        [*build, str(source)], capture_output=True, text=True, stdin=subprocess.DEVNULL
    )
    if done.returncode != 0:
        sys.exit(f"{source} does not build:\n{done.stdout}{done.stderr}")
    (wheel,) = into.glob("*.whl")
    return wheel


def make_environment(folder: Path, wheel: Path) -> Path:
    """Make an environment with third-party packages and one wheel; give its interpreter."""
    venv.create(folder, with_pip=False, symlinks=True)
    (site,) = folder.glob("lib/python*/site-packages")
    for entry in Path(sysconfig.get_path("purelib")).iterdir():
        # By links, one each: a search path to that folder would bring this checkout along.
        if not entry.name.startswith(OURS) and not (site / entry.name).exists():
            (site / entry.name).symlink_to(entry)
    python = folder / "bin" / "python"
    install(python, wheel)
    return python


def install(python: Path, wheel: Path) -> None:
    """Install a wheel, alone and without looking anywhere."""
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--python", str(python)]
    subprocess.run([*pip, "install", "-q", "--no-index", "--no-deps", str(wheel)], check=True)


def test(python: Path, package: Path, copy: Path) -> bool:
    """Run a package's tests, and see that nothing is wrong with it as a plugin."""
    copy.mkdir(parents=True)
    for file in ("pyproject.toml", "README.md"):  # whose examples tests may run
        shutil.copy(package / file, copy)
    ignore = shutil.ignore_patterns("__*")
    shutil.copytree(package / "tests", copy / "tests", ignore=ignore)
    shutil.copytree(REPOSITORY / "tests" / "support", copy / "tests" / "support", ignore=ignore)
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    for variable, name in MODELS.items():
        if (place := REPOSITORY.parent / "shared" / name).is_dir():
            environment.setdefault(variable, str(place))

    environment.setdefault("BT_MANIP_ARTEFACTS", str(REPOSITORY / ".ci" / "artefacts"))

    def run(*command: str) -> bool:
        return subprocess.run([str(python), *command], cwd=copy, env=environment).returncode == 0

    where = "import bt_manip, sys; sys.exit(not bt_manip.__file__.startswith(sys.prefix))"
    return (
        run("-I", "-c", where)
        and run("-I", "-m", "bt_manip", "plugins", "--check")
        and run(*PYTEST, "tests")
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""Test each package of plugins/ where it finds what its users have, and nothing of this checkout.

Every package gets a fresh environment: the third-party packages of the environment that this runs
in, the wheel of bt-manip, the package's own wheel, and those of the packages of plugins/ that it
requires, for its tests (extra `test`) too. Its tests run from a copy outside of the repository,
with `tests/support`, which all tests share. Three packages are tested at a time; one alone, in two
processes.

    .venv/bin/python tools/test_packages.py [PACKAGE...]

for example `view`, `bt-manip-view` or `plugins/bt-manip-view`; without any, all of them.
"""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import time
import tomllib
import venv
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from hatchling.builders.wheel import WheelBuilder

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

TESTS = """
import sys
import pytest
failed = pytest.main(sys.argv[1:])
import bt_manip.__main__
assert bt_manip.__file__.startswith(sys.prefix), bt_manip.__file__
sys.argv[1:] = ["plugins", "--check"]
sys.exit(failed or bt_manip.__main__.main())
"""
"""Runs tests, and checks the plugins in the same process, which has imported them."""

PYTEST = ("-q", "-p", "no:cacheprovider", "--import-mode=importlib")
PYTEST += ("-p", "tests.support.garbage")  # it runs seldom
PYTEST += ("-m", "not soak", "-o", "markers=soak")  # what takes minutes has its own time
TWO_PROCESSES = ("-n", "2", "--dist", "loadfile")


def main(arguments: list[str]) -> int:
    """Test the packages; give 1 if any fails."""
    files = sorted((REPOSITORY / "plugins").glob("*/pyproject.toml"))
    known = {file.parent.name: file.parent for file in files}
    names = [f"bt-manip-{Path(one).name.removeprefix('bt-manip-')}" for one in arguments]
    if unknown := [name for name in names if name not in known]:
        print(f"no package {unknown[0]!r}; there are {', '.join(known)}", file=sys.stderr)
        return 2
    folders = [known[name] for name in names or known]
    folders.sort(key=_size_of_tests, reverse=True)  # the long ones first
    options = TWO_PROCESSES if len(folders) == 1 else ()
    failed = []
    with tempfile.TemporaryDirectory() as temporary, ThreadPoolExecutor(3) as pool:
        work = Path(temporary)
        sources = {folder: [one.resolve() for one in required(folder)] for folder in folders}
        wheels = {
            source: build_wheel(source, work / "wheels")
            for source in dict.fromkeys(source for some in sources.values() for source in some)
        }
        everything = make_environment(work / "everything")
        install(everything, *wheels.values())

        def tested(folder: Path) -> tuple[bool, str]:
            python = make_environment(work / folder.name / "env")
            for source in sources[folder]:
                link(wheels[source], _site(everything), _site(python))
            return test(python, folder, work / folder.name / "tested", *options)

        for folder, (passed, output) in zip(folders, pool.map(tested, folders), strict=True):
            print(f"--- {folder.name}\n{output}", flush=True)
            if not passed:
                failed.append(folder.name)
    if failed:
        print(f"failed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


def _size_of_tests(folder: Path) -> int:
    return sum(file.stat().st_size for file in (folder / "tests").rglob("*.py"))


def required(folder: Path) -> list[Path]:
    """Give a package's folder, that of bt-manip, and those of what it and its tests require."""
    project = tomllib.loads((folder / "pyproject.toml").read_text())["project"]
    extras = project.get("optional-dependencies", {})
    lines = [*project["dependencies"], *extras.get("test", [])]
    folders = (folder.resolve().parent / re.split(r"[^\w-]", line)[0] for line in lines)
    return [REPOSITORY, folder, *(one for one in folders if one.is_dir())]


def build_wheel(source: Path, into: Path) -> Path:
    """Build a wheel with the tools of this environment."""
    (wheel,) = WheelBuilder(str(source)).build(directory=str(into), versions=["standard"])
    return Path(wheel)


def make_environment(folder: Path) -> Path:
    """Make an environment with the third-party packages of this one; give its interpreter."""
    venv.create(folder, with_pip=False, symlinks=True)
    python = folder / "bin" / "python"
    site = _site(python)
    for entry in Path(sysconfig.get_path("purelib")).iterdir():
        # By links, one each: a search path to that folder would bring this checkout along.
        if not entry.name.startswith(OURS) and not (site / entry.name).exists():
            (site / entry.name).symlink_to(entry)
    (folder / "bin" / "ruff").symlink_to(Path(sysconfig.get_path("scripts")) / "ruff")  # no script
    return python


def _site(python: Path) -> Path:
    (site,) = python.parents[1].glob("lib/python*/site-packages")
    return site


def install(python: Path, *wheels: Path) -> None:
    """Install wheels, alone and without looking anywhere."""
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--python", str(python)]
    subprocess.run([*pip, "install", "-q", "--no-index", "--no-deps", *wheels], check=True)


def link(wheel: Path, source: Path, into: Path) -> None:
    """Bring what a wheel has installed in one environment to another."""
    with zipfile.ZipFile(wheel) as file:
        for name in {one.partition("/")[0] for one in file.namelist()}:
            (into / name).symlink_to(source / name)


def test(python: Path, package: Path, copy: Path, *options: str) -> tuple[bool, str]:
    """Run a package's tests, and see that nothing is wrong with it as a plugin.

    Returns:
        Whether all is well, and what the commands have printed.
    """
    start = time.monotonic()
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
    printed = copy / "printed.txt"

    with printed.open("w") as file:
        passed = not subprocess.run(
            [str(python), "-c", TESTS, *PYTEST, *options, "tests"],
            cwd=copy,
            env=environment,
            stdout=file,
            stderr=subprocess.STDOUT,
        ).returncode
    return passed, f"{printed.read_text()}{time.monotonic() - start:.0f} s"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

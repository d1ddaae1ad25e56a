"""What stands around the package keeps its word."""

import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from bt_manip.__main__ import main

REPOSITORY = Path(__file__).resolve().parents[2]
PYPROJECT = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())
PROJECT = PYPROJECT["project"]
CONSTRAINTS = (REPOSITORY / "constraints.txt").read_text()


def constrained() -> dict[str, str]:
    """Give the exact versions by normalised name."""
    lines = [line for line in CONSTRAINTS.splitlines() if not line.startswith("#")]
    pairs = [line.partition(";")[0].strip().split("==") for line in lines if line]
    return {re.sub(r"[-_.]+", "-", name).lower(): version for name, version in pairs}


@pytest.mark.parametrize(
    "requirement",
    [
        *PROJECT["dependencies"],
        *PROJECT["optional-dependencies"]["dev"],
        *PROJECT["optional-dependencies"]["docs"],
    ],
)
def test_the_exact_version_of_each_dependency_is_in_its_range(requirement):
    wanted = Requirement(requirement)
    version = constrained()[re.sub(r"[-_.]+", "-", wanted.name).lower()]
    assert wanted.specifier.contains(version)


def test_constraints_name_no_host():
    assert not re.search(r"://|--|@", CONSTRAINTS)


@pytest.mark.parametrize("version", [pytest.param("3.13", marks=pytest.mark.soak), "3.14"])
def test_each_package_has_a_wheel_for_a_newer_python(version, tmp_path):
    uv = Path(sys.executable).with_name("uv")
    if not uv.exists():
        pytest.skip("make setup installed without uv")
    pinned = tmp_path / "pinned.txt"
    pinned.write_text(re.sub(r"(?m)^labmaze==.*$", "", CONSTRAINTS))
    done = subprocess.run(
        [uv, "pip", "compile", pinned, "--no-deps", "--quiet", "--no-python-downloads",
         "--only-binary", ":all:", "--python-version", version,
         "--python-platform", "x86_64-manylinux_2_28"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode == 2:
        pytest.skip(f"no index of packages: {done.stderr.strip().splitlines()[0]}")
    assert done.returncode == 0, done.stderr


def test_no_dependency_but_those_of_mazes_is_left_out_of_a_newer_python():
    (left_out,) = PYPROJECT["tool"]["uv"]["override-dependencies"]
    assert left_out == "labmaze; python_version < '3.13'"
    for template in (REPOSITORY / "templates").glob("*/pyproject.toml"):
        settings = tomllib.loads(template.read_text())
        assert settings["tool"]["uv"]["override-dependencies"] == [left_out], template


def fake_python(folder: Path, version: str) -> Path:
    path = folder / "python"
    path.write_text(f'#!/bin/sh\n[ "$1" = --version ] && echo "Python {version}" || exit 1\n')
    path.chmod(0o755)
    return path


PYTHON = """#!/bin/sh
case "$*" in
    --version) echo "Python ${VERSION:-3.12.1}" ;;
    "-m venv --clear .venv") mkdir -p .venv/bin && cp "$0" .venv/bin/python ;;
    "-m pip config list") printf '%s\\n' "$SETTINGS" ;;
    "-m pip install"*" uv")
        [ "$UV" = none ] && exit 1
        cp "$0" .venv/bin/uv ;;
    "-m pip install"*) echo "pip install $*"; exit "${PIP:-0}" ;;
    "pip install"*)
        echo "uv $*"
        env | grep -E '^(UV_|SSL_)'
        [ "$UV" = hangs ] && kill -TERM "$PPID" && exec tail -f /dev/null
        [ "$UV" != fails ] ;;
esac
"""


@pytest.fixture
def setup(tmp_path):
    """Run the script in a folder without packages; ``python``, pip and uv tell the log."""
    (tmp_path / "home").mkdir()
    shutil.copytree(REPOSITORY / "tools", tmp_path / "tools")
    python = tmp_path / "python"
    python.write_text(PYTHON)
    python.chmod(0o755)

    def run(*extras: str, **variables: str) -> tuple[subprocess.CompletedProcess, str]:
        standard = {
            "PATH": "/usr/bin:/bin", "HOME": str(tmp_path / "home"), "PYTHON": str(python),
            "UV": "works", "SETTINGS": "",
        }  # fmt: skip
        done = subprocess.run(
            ["sh", "tools/setup.sh", *extras], cwd=tmp_path, env=standard | variables,
            capture_output=True, text=True, timeout=60,
        )  # fmt: skip
        log = tmp_path / ".venv" / "setup.log"
        assert (tmp_path / ".venv" / ".ready").exists() is (done.returncode == 0)
        return done, log.read_text() if log.exists() else ""

    return run


def test_setup_says_which_python_it_needs(setup, tmp_path):
    error = setup(PYTHON=str(fake_python(tmp_path, "3.15.1")))[0].stderr
    assert all(words in error for words in ("3.11 to 3.14", "3.15.1", "make setup PYTHON="))


def test_setup_prints_its_steps_and_installs_the_exact_versions_with_uv(setup):
    done, log = setup()
    assert (done.returncode, done.stderr) == (0, "")
    assert [line.split()[0] for line in done.stdout.splitlines()] == [
        "Making", "Installing", "Ready:"
    ]  # fmt: skip
    assert "Making .venv with Python 3.12.1" in done.stdout
    calls = [line for line in log.splitlines() if line.startswith("uv pip install")]
    assert len(calls) == 2 and all("-c constraints.txt" in call for call in calls)
    assert "pip install -m" not in log


@pytest.mark.parametrize("variables", [{"UV": "none"}, {"INSTALLER": "pip"}, {"UV": "fails"}])
def test_setup_installs_with_pip_where_uv_cannot_or_where_it_is_told_to(setup, variables):
    done, log = setup(**variables)
    assert (done.returncode, done.stderr) == (0, "")
    assert ("uv cannot install" in done.stdout) is ("fails" in variables.values())
    calls = [line for line in log.splitlines() if line.startswith("pip install -m")]
    assert len(calls) == 2 and all("-c constraints.txt" in call for call in calls)


def test_pip_leaves_labmaze_out_of_a_newer_python(setup, tmp_path):
    (tmp_path / "constraints.txt").write_text("click==8\nlabmaze==1.0.6\n")
    done, log = setup(INSTALLER="pip", VERSION="3.13.1")
    assert (done.returncode, done.stderr) == (0, "")
    calls = [line for line in log.splitlines() if line.startswith("pip install -m")]
    assert len(calls) == 2 and all("--no-deps" in call for call in calls)
    assert "-r .venv/pinned.txt" in calls[0]
    assert (tmp_path / ".venv" / "pinned.txt").read_text() == "click==8\n"


def test_setup_adds_an_extra(setup):
    log = setup("docs", INSTALLER="pip", VERSION="3.13.1")[1]
    assert "--no-build-isolation -e .[docs]" in log
    assert "dev" not in log


@pytest.mark.parametrize("uv", ["none", "fails"])
def test_setup_names_the_log_where_pip_fails(setup, uv):
    done, log = setup(UV=uv, PIP="1")
    assert done.returncode == 1
    assert "pip's output is in .venv/setup.log" in done.stderr
    assert "pip install -m" in log


SETTINGS = r"""
:env:.cert='/etc/ours.pem'
:env:.no-index='1'
global.extra-index-url='\nhttps://one.test/simple\nhttps://two.test/simple'
global.index-url='https://global.test/simple'
install.index-url='https://install.test/simple'
global.find-links='/wheels'
"""


def test_uv_looks_for_packages_where_pip_is_told_to(setup):
    log = setup(SETTINGS=SETTINGS, UV_FIND_LINKS="/mine")[1]
    assert "--no-index" in log
    for line in (
        "SSL_CERT_FILE=/etc/ours.pem",
        "UV_INDEX=https://one.test/simple https://two.test/simple",
        "UV_DEFAULT_INDEX=https://install.test/simple",
        "UV_FIND_LINKS=/mine",
    ):
        assert line in log.splitlines()


def test_ctrl_c_ends_the_setup_and_the_installer(setup):
    done, log = setup(UV="hangs")
    assert done.returncode == 130
    assert "uv pip install" in log


def test_setup_lets_uv_fetch_a_python_where_none_suits_and_says_so(setup, tmp_path):
    """A ``uv`` of the user is taken, and its Python found."""
    commands = tmp_path / "commands"
    commands.mkdir()
    for name in ("python3.12", "python3.11", "python3", "python"):
        fake_python(commands, "3.15.1").rename(commands / name)
    uv = commands / "uv"
    uv.write_text(
        '#!/bin/sh\n[ "$1 $2 $5" = "python install 3.12" ] && mkdir -p "$4/cpython-3.12/bin" && '
        f'cp {tmp_path}/python "$4/cpython-3.12/bin/python3"\n'
    )
    uv.chmod(0o755)
    done, _ = setup(PYTHON="", PATH=f"{commands}:/usr/bin:/bin")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("No Python 3.11 to 3.14 found: uv fetches Python 3.12")
    uv.write_text("#!/bin/sh\nexit 1\n")
    shutil.rmtree(tmp_path / "home" / ".local")
    shutil.rmtree(tmp_path / ".venv")
    done, _ = setup(PYTHON="", PATH=f"{commands}:/usr/bin:/bin")
    assert done.returncode == 1
    assert "bt-manip needs Python 3.11 to 3.14" in done.stderr


@pytest.mark.parametrize("version", [(3, 10, 2), (3, 15, 0)])
def test_a_start_on_another_python_says_so(version, monkeypatch, capsys):
    monkeypatch.setattr(sys, "version_info", version)
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    error = capsys.readouterr().err
    assert "3.11 to 3.14" in error and ".".join(map(str, version)) in error


@pytest.mark.parametrize("document", ["README.md", "CONTRIBUTING.md", "docs/architecture.md"])
def test_documents_name_only_commands_that_there_are(document):
    named = re.findall(r"(?:^|`)make ([a-z-]+)", (REPOSITORY / document).read_text(), re.MULTILINE)
    makefile = (REPOSITORY / "Makefile").read_text()
    assert {*named} <= {*re.findall(r"^([a-z-]+):", makefile, re.MULTILINE)}

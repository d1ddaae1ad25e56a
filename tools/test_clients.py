"""Test bt-manip with the learning libraries that its users have, in an environment of their own.

    .venv/bin/python tools/test_clients.py [PYTEST OPTION...]

`.venv-clients` is made where it is missing, or other packages are listed. Where the packages cannot
be had, nothing is tested, and the reason is printed.
"""

import hashlib
import subprocess
import sys
import venv
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
FOLDER = REPOSITORY / ".venv-clients"
REQUIREMENTS = REPOSITORY / "tests" / "clients" / "requirements.txt"
CONSTRAINTS = REPOSITORY / "constraints.txt"
ROBOMIMIC = "robomimic==0.3.0"
LEROBOT = (
    "LeRobot is not tested: 0.4.4, the last one for Python 3.11, needs torch < 2.11 and av < 16. "
    "With LEROBOT_PYTHON, the Python of an environment that has it, 'make test' tests the export."
)

PIP = ("-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-c", str(CONSTRAINTS))


def main(options: list[str]) -> int:
    """Test; return pytest's exit code, or 0 where the packages cannot be had."""
    reason = install()
    if reason:
        print(f"skipped: the clients cannot be installed: {reason}")
        return 0
    print(LEROBOT)
    command = [python(), "-m", "pytest", "tests/clients", "-q", "-p", "no:cacheprovider", *options]
    return subprocess.run(command, cwd=REPOSITORY).returncode


def python() -> str:
    """Return the interpreter of the environment."""
    return str(FOLDER / "bin" / "python")


def install() -> str:
    """Make the environment, unless it has these packages; return why not, empty if it could."""
    wanted = hashlib.sha256(REQUIREMENTS.read_bytes() + CONSTRAINTS.read_bytes()).hexdigest()
    ready = FOLDER / ".ready"
    if ready.is_file() and ready.read_text() == wanted:
        return ""
    venv.create(FOLDER, clear=True, with_pip=True)
    ours = ["-e", f"{REPOSITORY}[learn]", "-e", f"{REPOSITORY}/plugins/bt-manip-impedance"]
    for words in (
        ["hatchling"],
        ["-r", str(REQUIREMENTS)],
        ["--no-deps", ROBOMIMIC],
        ["--no-build-isolation", *ours],
    ):
        done = subprocess.run(
            [python(), *PIP, *words], cwd=REPOSITORY, capture_output=True, text=True
        )
        if done.returncode:
            errors = [line for line in done.stderr.splitlines() if line.startswith("ERROR")]
            return (errors or done.stderr.splitlines() or ["pip failed"])[-1]
    ready.write_text(wanted)
    return ""


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

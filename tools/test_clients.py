"""Test bt-manip with the learning libraries that its users have, in environments of their own.

    .venv/bin/python tools/test_clients.py [PYTEST OPTION...]

`.venv-clients` and, for LeRobot, `.venv-lerobot` are made where they are missing, or other packages
are listed. Where the packages cannot be had, nothing is tested, and the reason is printed.
"""

import hashlib
import os
import subprocess
import sys
import venv
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
CLIENTS = REPOSITORY / ".venv-clients"
LEROBOT = REPOSITORY / ".venv-lerobot"
CONSTRAINTS = REPOSITORY / "constraints.txt"
REQUIREMENTS = REPOSITORY / "tests" / "clients"
OURS = ("-e", f"{REPOSITORY}[learn]", "-e", f"{REPOSITORY}/plugins/bt-manip-impedance")
TESTS = ("tests/clients", "tests/demonstrations/test_export_lerobot.py")

# The operators of torchvision's wheel are built for another build of torch, which refuses to
# declare them; its part in Python, which LeRobot uses, works without.
WITHOUT_OPERATORS = """\
import sys, types
sys.modules["torchvision._meta_registrations"] = types.ModuleType("_meta_registrations")
"""


def main(options: list[str]) -> int:
    """Test; return pytest's exit code, or 0 where the packages cannot be had."""
    reason = install_clients()
    if reason:
        print(f"skipped: the clients cannot be installed: {reason}")
        return 0
    environment = dict(os.environ)
    reason = install_lerobot()
    if reason:
        print(f"LeRobot is not tested: it cannot be installed: {reason}")
    else:
        environment.setdefault("LEROBOT_PYTHON", python(LEROBOT))
    command = [python(CLIENTS), "-m", "pytest", *TESTS, "-q", "-p", "no:cacheprovider", *options]
    return subprocess.run(command, cwd=REPOSITORY, env=environment).returncode


def python(folder: Path) -> str:
    """Return the interpreter of an environment."""
    return str(folder / "bin" / "python")


def install_clients() -> str:
    """Make the environment of bt-manip's users; return why not, empty if it could."""
    constrained = ("-c", str(CONSTRAINTS))
    requirements = REQUIREMENTS / "requirements.txt"
    return install(
        CLIENTS,
        [requirements, CONSTRAINTS],
        [*constrained, "hatchling"],
        [*constrained, "-r", str(requirements)],
        ["--no-deps", "robomimic==0.3.0"],
        [*constrained, "--no-build-isolation", *OURS],
    )


def install_lerobot() -> str:
    """Make the environment of LeRobot; return why not, empty if it could."""
    requirements = REQUIREMENTS / "requirements-lerobot.txt"
    reason = install(
        LEROBOT, [requirements], ["-r", str(requirements)], ["--no-deps", "lerobot==0.4.4"]
    )
    for packages in LEROBOT.glob("lib/python*/site-packages"):
        (packages / "sitecustomize.py").write_text(WITHOUT_OPERATORS)
    return reason


def install(folder: Path, files: list[Path], *commands: list[str]) -> str:
    """Make an environment by calls of pip, unless it was made from these files.

    Returns:
        Why not, empty if it could.
    """
    wanted = hashlib.sha256(b"".join(one.read_bytes() for one in files)).hexdigest()
    ready = folder / ".ready"
    if ready.is_file() and ready.read_text() == wanted:
        return ""
    venv.create(folder, clear=True, with_pip=True)
    for words in commands:
        done = subprocess.run(
            [python(folder), "-m", "pip", "install", "-q", "--disable-pip-version-check", *words],
            cwd=REPOSITORY,
            capture_output=True,
            text=True,
        )
        if done.returncode:
            errors = [line for line in done.stderr.splitlines() if line.startswith("ERROR")]
            return (errors or done.stderr.splitlines() or ["pip failed"])[-1]
    ready.write_text(wanted)
    return ""


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

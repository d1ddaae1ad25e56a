"""Test bt-manip with the learning libraries that its users have, in an environment of their own.

    .venv/bin/python tools/test_clients.py [PYTEST OPTION...]

`.venv-clients` is made where it is missing, or other packages are listed. Where the packages cannot
be had, nothing is tested, and the reason is printed.
"""

import subprocess
import sys

from own_environment import REPOSITORY, OwnEnvironment

REQUIREMENTS = REPOSITORY / "tests" / "clients" / "requirements.txt"
CONSTRAINTS = REPOSITORY / "constraints.txt"
ROBOMIMIC = "robomimic==0.3.0"
LEROBOT = (
    "LeRobot is not tested: 0.4.4, the last one for Python 3.11, needs torch < 2.11 and av < 16. "
    "With LEROBOT_PYTHON, the Python of an environment that has it, 'make test' tests the export."
)
OURS = ("-e", f"{REPOSITORY}[learn]", "-e", f"{REPOSITORY}/plugins/bt-manip-impedance")
STEPS = (
    ("hatchling",),
    ("-r", str(REQUIREMENTS)),
    ("--no-deps", ROBOMIMIC),
    ("--no-build-isolation", *OURS),
)


def main(options: list[str]) -> int:
    """Test; return pytest's exit code, or 0 where the packages cannot be had."""
    environment = OwnEnvironment(".venv-clients", REQUIREMENTS, CONSTRAINTS)
    reason = environment.install(*(("-c", str(CONSTRAINTS), *step) for step in STEPS))
    if reason:
        print(f"skipped: the clients cannot be installed: {reason}")
        return 0
    print(LEROBOT)
    pytest = ["-m", "pytest", "tests/clients", "-q", "-p", "no:cacheprovider"]
    return subprocess.run([environment.python, *pytest, *options], cwd=REPOSITORY).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

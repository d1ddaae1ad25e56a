"""Rehearse with Franka's own client and franka-sim, a server of its protocol, on loopback.

    .venv/bin/python tools/rehearsal.py [PYTEST OPTION...]

franka-sim gets an environment of its own, `.venv-rehearsal`, which is made where it is missing, or
other packages are listed. Where the packages or the models cannot be had, nothing is rehearsed, and
the reason is printed. ``CUBES=20`` picks and places 20 cubes instead of 3. ``-m soak -s`` measures
gaps in the communication, for ``MINUTES=10`` instead of one each.
"""

import importlib.util
import os
import subprocess
import sys

from own_environment import REPOSITORY, OwnEnvironment

REQUIREMENTS = REPOSITORY / "tests" / "rehearsal" / "requirements.txt"
TESTS = ("tests/rehearsal", "plugins/bt-manip-franka/tests", "tests/robots/test_fr3_limits.py")


def main(options: list[str]) -> int:
    """Rehearse; return pytest's exit code, or 0 where something is missing."""
    environment = OwnEnvironment(".venv-rehearsal", REQUIREMENTS)
    if importlib.util.find_spec("pylibfranka") is None:
        reason = "pylibfranka is not installed: it has wheels for Linux, Python 3.11 and 3.12"
    else:
        reason = environment.install(("--only-binary", ":all:", "-r", str(REQUIREMENTS)))
    if reason:
        print(f"skipped: the rehearsal needs an environment with franka-sim: {reason}")
        return 0
    # Tests that need models are skipped where these are missing, and say so.
    command = [sys.executable, "-m", "pytest", *TESTS, "-q", "-p", "no:cacheprovider", *options]
    variables = os.environ | {"FRANKA_SIM_PYTHON": environment.python}
    return subprocess.run(command, cwd=REPOSITORY, env=variables).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""Test bt-manip with the learning libraries that its users have, in environments of their own.

    .venv/bin/python tools/test_clients.py [PYTEST OPTION...]

`.venv-clients` and, for LeRobot, `.venv-lerobot` are made where they are missing, or other packages
are listed. Where the packages cannot be had, nothing is tested, and the reason is printed.
"""

import os
import subprocess
import sys
from pathlib import Path

from own_environment import REPOSITORY, OwnEnvironment

CONSTRAINTS = REPOSITORY / "constraints.txt"
LISTS = REPOSITORY / "tests" / "clients"
ROBOMIMIC, LEROBOT = "robomimic==0.3.0", "lerobot==0.4.4"
PACKAGES = ("bt-manip-impedance", "bt-manip-learn")
OURS = ("-e", f"{REPOSITORY}[learn]", *(f"-e{REPOSITORY}/plugins/{name}" for name in PACKAGES))
TESTS = (
    "tests/clients",
    "plugins/bt-manip-learn/tests/demonstrations/test_export_lerobot.py",
    "plugins/bt-manip-learn/tests/test_ray_pool.py",
)

# The operators of torchvision's wheel are built for another build of torch, which refuses to
# declare them; its part in Python, which LeRobot uses, works without.
WITHOUT_OPERATORS = """\
import sys, types
sys.modules["torchvision._meta_registrations"] = types.ModuleType("_meta_registrations")
"""


def main(options: list[str]) -> int:
    """Test; return pytest's exit code, or 0 where the packages cannot be had."""
    listed = LISTS / "requirements.txt"
    clients = OwnEnvironment(".venv-clients", listed, CONSTRAINTS)
    steps = (
        ("hatchling",),
        ("-r", str(listed)),
        ("--no-deps", ROBOMIMIC),
        ("--no-build-isolation", *OURS),
    )
    reason = clients.install(*(("-c", str(CONSTRAINTS), *step) for step in steps))
    if reason:
        print(f"skipped: the clients cannot be installed: {reason}")
        return 0
    variables = dict(os.environ)
    lerobot = OwnEnvironment(".venv-lerobot", LISTS / "requirements-lerobot.txt")
    reason = install_lerobot(lerobot)
    if reason:
        print(f"LeRobot is not tested: it cannot be installed: {reason}")
    else:
        variables.setdefault("LEROBOT_PYTHON", lerobot.python)
    pytest = ["-m", "pytest", *TESTS, "-q", "-p", "no:cacheprovider"]
    command = [clients.python, *pytest, *options]
    return subprocess.run(command, cwd=REPOSITORY, env=variables).returncode


def install_lerobot(environment: OwnEnvironment) -> str:
    """Make the environment of LeRobot; return why not, empty if it could."""
    listed = LISTS / "requirements-lerobot.txt"
    reason = environment.install(("-r", str(listed)), ("--no-deps", LEROBOT))
    for packages in Path(environment.python).parents[1].glob("lib/python*/site-packages"):
        (packages / "sitecustomize.py").write_text(WITHOUT_OPERATORS)
    return reason


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

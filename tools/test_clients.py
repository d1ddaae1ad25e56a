"""Test bt-manip with the learning libraries that its users have, in environments of their own.

    .venv/bin/python tools/test_clients.py [PYTEST OPTION...]

`.venv-clients`, `.venv-lerobot` and `.venv-rllib` are made where they are missing, or with other
packages. What cannot be installed is not tested, and the reason is printed.
"""

import os
import subprocess
import sys
from pathlib import Path

from own_environment import REPOSITORY, OwnEnvironment

CONSTRAINTS = REPOSITORY / "constraints.txt"
LISTS = REPOSITORY / "tests" / "clients"
ROBOMIMIC, LEROBOT = "robomimic==0.3.0", "lerobot==0.4.4"
CLEANRL = "cleanrl==1.2.0"  # one script a method; it pins what the Python of its time had
RLLIB = "tests/clients/test_rllib.py"
RLLIB_GYMNASIUM = "gymnasium==1.2.2"
PACKAGES = ("bt-manip-impedance", "bt-manip-learn")
OURS = ("-e", f"{REPOSITORY}[learn]", *(f"-e{REPOSITORY}/plugins/{name}" for name in PACKAGES))
TESTS = (
    "tests/clients",
    "plugins/bt-manip-learn/tests/demonstrations/test_export_lerobot.py",
    "plugins/bt-manip-learn/tests/envs/test_lerobot.py",
    "plugins/bt-manip-learn/tests/test_ray_pool.py",
)
TWO = ("-n", "2", "--dist", "loadfile")

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
        ("--no-deps", "--ignore-requires-python", CLEANRL),
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
    pytest = ["-m", "pytest", "-q", "-p", "no:cacheprovider"]
    command = [clients.python, *pytest, *TWO, *TESTS, f"--ignore={RLLIB}", *options]
    code = subprocess.run(command, cwd=REPOSITORY, env=variables).returncode
    rllib = OwnEnvironment(".venv-rllib", LISTS / "requirements-rllib.txt", CONSTRAINTS)
    reason = install_rllib(rllib)
    if reason:
        print(f"RLlib is not tested: it cannot be installed: {reason}")
        return code
    command = [rllib.python, *pytest, RLLIB, *options]
    return code or subprocess.run(command, cwd=REPOSITORY, env=variables).returncode


def install_rllib(environment: OwnEnvironment) -> str:
    """Make the environment of RLlib, with its Gymnasium; return why not, empty if it could."""
    steps = (
        ("hatchling",),
        ("-r", str(LISTS / "requirements-rllib.txt")),
        ("--no-build-isolation", *OURS),
    )
    return environment.install(
        *(("-c", str(CONSTRAINTS), *step) for step in steps), ("--no-deps", RLLIB_GYMNASIUM)
    )


def install_lerobot(environment: OwnEnvironment) -> str:
    """Make the environment of LeRobot; return why not, empty if it could."""
    listed = LISTS / "requirements-lerobot.txt"
    ours = ("--no-deps", "--no-build-isolation", *OURS)
    reason = environment.install(("-r", str(listed)), ("--no-deps", LEROBOT), ours)
    for packages in Path(environment.python).parents[1].glob("lib/python*/site-packages"):
        (packages / "sitecustomize.py").write_text(WITHOUT_OPERATORS)
    return reason


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

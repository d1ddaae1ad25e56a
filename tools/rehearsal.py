"""Rehearse with the clients of arms' makers against simulators of their protocols, on loopback.

    .venv/bin/python tools/rehearsal.py [PYTEST OPTION...]

| arm | client | simulator |
|---|---|---|
| Franka Research 3 | `pylibfranka`, its maker's | `franka-sim` |
| WidowX AI | `trossen-arm`, its maker's | `trossen-arm-sim` |

The simulators get environments of their own, `.venv-rehearsal` and `.venv-rehearsal-trossen`, which
are made where they are missing, or other packages are listed. Where the packages or the models of
an arm cannot be had, it is not rehearsed, and the reason is printed. ``ARMS="trossen"`` names the
arms, by default all of them. ``CUBES=20`` picks and places 20 cubes instead of 1.
Robots and arms run in real time: a test that fails is run once more, and must pass then.
``-m soak -s`` measures gaps in the communication, for ``MINUTES=10`` instead of one each.
"""

import importlib.util
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import pytest
from own_environment import REPOSITORY, OwnEnvironment


class Rehearsed(NamedTuple):
    """An arm whose maker's client speaks to a simulator.

    Attributes:
        client: Module of its maker's client, in the environment of bt-manip.
        simulator: Module of the simulator.
        folder: Environment of the simulator.
        requirements: File of `tests/rehearsal` that lists what is in it.
        variable: Environment variable that names its Python for the tests.
        tests: Tests of this arm.
    """

    client: str
    simulator: str
    folder: str
    requirements: str
    variable: str
    tests: tuple[str, ...]


ARMS = {
    "franka": Rehearsed(
        "pylibfranka", "franka_sim", ".venv-rehearsal", "requirements.txt", "FRANKA_SIM_PYTHON",
        ("plugins/bt-manip-franka/tests", "tests/robots/test_fr3_limits.py"),
    ),
    "trossen": Rehearsed(
        "trossen_arm", "trossen_arm_sim", ".venv-rehearsal-trossen", "requirements-trossen.txt",
        "TROSSEN_SIM_PYTHON", ("plugins/bt-manip-trossen/tests",),
    ),
}  # fmt: skip


def main(options: list[str]) -> int:
    """Rehearse; return pytest's exit code, or 0 where everything is missing."""
    variables, tests = dict(os.environ), []
    chosen = os.environ.get("ARMS", " ".join(ARMS)).split()
    for name, arm in ARMS.items():
        if name not in chosen:
            continue
        requirements = REPOSITORY / "tests" / "rehearsal" / arm.requirements
        environment = OwnEnvironment(arm.folder, requirements)
        if importlib.util.find_spec(arm.client) is None:
            reason = f"{arm.client} is not installed"
        else:
            reason = environment.install(("--only-binary", ":all:", "-r", str(requirements)))
        if reason:
            print(f"skipped: the rehearsal with {arm.simulator}: {reason}")
            continue
        variables[arm.variable] = environment.python
        tests += arm.tests
        for assets in Path(environment.python).parents[1].glob("lib/*/site-packages/*/assets"):
            if assets.parent.name == "trossen_arm_sim":
                variables.setdefault("TROSSEN_ARM_ASSETS", str(assets))
    if not tests:
        return 0
    # Tests that need models are skipped where these are missing, and say so.
    command = [sys.executable, "-m", "pytest", "tests/rehearsal", *tests, "-q"]
    with tempfile.TemporaryDirectory() as cache:
        command += ["-o", f"cache_dir={cache}", *options]
        result = subprocess.run(command, cwd=REPOSITORY, env=variables).returncode
        if result == pytest.ExitCode.TESTS_FAILED:
            print("once more: a busy machine can make motions late", flush=True)
            command.append("--last-failed")
            result = subprocess.run(command, cwd=REPOSITORY, env=variables).returncode
    return result


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

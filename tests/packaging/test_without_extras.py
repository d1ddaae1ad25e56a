"""The main commands need no package of an extra."""

import json
from importlib.metadata import PackageNotFoundError, packages_distributions, requires

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.support.program import run_python

COMMAND = """
import json, sys
sys.modules.update(dict.fromkeys(json.loads(sys.argv.pop(1))))  # their import raises
from bt_manip.__main__ import main
sys.exit(main())
"""


def required_packages() -> set[str]:
    """Return the distributions that ``pip install bt-manip`` brings."""
    found: set[str] = set()
    left = [("bt-manip", "")]
    while left:
        name, extra = left.pop()
        try:
            lines = requires(name) or []
        except PackageNotFoundError:  # of another platform
            continue
        found.add(name)
        for requirement in map(Requirement, lines):
            if requirement.marker is None or requirement.marker.evaluate({"extra": extra}):
                other = canonicalize_name(requirement.name)
                wanted = [(other, one) for one in requirement.extras] or [(other, "")]
                left += [one for one in wanted if one[0] not in found]
    return found


@pytest.fixture(scope="module")
def extras() -> list[str]:
    """Give the modules that ``pip install bt-manip`` does not bring."""
    required = required_packages()
    return [
        module
        for module, owners in packages_distributions().items()
        if required.isdisjoint(map(canonicalize_name, owners)) and not module.startswith("bt_manip")
    ]


@pytest.mark.parametrize(
    "arguments",
    [
        ("list", "tasks", "pick_place", "--robot", "panda"),
        ("evaluate", "pick_place", "--episodes", "1", "--workers", "1"),  # which runs it
    ],
    ids=" ".join,
)
def test_it_works_without_the_packages_of_extras(arguments, extras, tmp_path):
    assert {"PIL", "viser", "mcap"} <= {*extras}
    run_python("-c", COMMAND, json.dumps(extras), *arguments, cwd=tmp_path)

"""Real robots: the whole way to a fake arm in a process of its own."""

import sys
from pathlib import Path

import numpy as np
import pytest

from bt_manip import build_station, load_plugins
from bt_manip.behaviours import Recover, WaitUntilUndisturbed
from bt_manip.bt import NodeStatus, Tree
from bt_manip.exceptions import BtManipError
from bt_manip.plugins import Choice
from bt_manip.runner import RunLoop
from bt_manip.testing import DEVICE_CONTRACT

HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def parts():
    sys.path.append(str(HERE))
    yield load_plugins(
        entry_points=(), choice=Choice(folders=(HERE,)), warn=lambda text: None
    ).parts
    sys.path.remove(str(HERE))


@pytest.fixture(scope="module")
def station(parts, tmp_path_factory):
    file = tmp_path_factory.mktemp("fake") / "rows.npy"
    station = build_station(parts, backend=f"fake=2,{file}", controller="joint_impedance")
    yield station
    station.real.close()


@pytest.mark.parametrize("check", DEVICE_CONTRACT, ids=lambda check: check.__name__)
def test_the_fake_arm_keeps_the_contract(station, check):
    check(station)

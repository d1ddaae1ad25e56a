"""The arm and its gripper fulfil the contracts of devices."""

import pytest
from bt_manip import build_station
from bt_manip.robots import DeviceError
from bt_manip_contracts import DEVICE_CONTRACT, GRIPPER_CONTRACT

from bt_manip_gear import gear as devices


@pytest.fixture(scope="module")
def station():
    """Give a station with the arm."""
    backend = "gear=localhost"
    station = build_station(backend=backend, controller="position", speed=1.0)
    yield station
    station.hardware.close()


@pytest.mark.parametrize("check", DEVICE_CONTRACT, ids=lambda check: check.__name__)
def test_the_arm_keeps_the_contract(station, check):
    check(station)


@pytest.mark.parametrize("check", GRIPPER_CONTRACT, ids=lambda check: check.__name__)
def test_the_gripper_keeps_the_contract(check):
    check(devices.GearGripper(), devices.OPEN_WIDTH)


def test_an_address_has_options():
    address = devices.Address.parse("arm.local?collision_force=40")
    assert address == devices.Address("arm.local", 40.0)
    with pytest.raises(DeviceError, match="did you mean 'collision_force'"):
        devices.Address.parse("arm.local?collision=40")

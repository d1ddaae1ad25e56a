"""The contract of backends, kept by a Franka."""

import pinocchio as pin
import pytest
from cell_operator import SPEED
from simulation import ARM

from bt_manip import build_station
from bt_manip.scenes import Scene, SceneRobot
from bt_manip_contracts import DEVICE_CONTRACT, recovers_from_a_problem


@pytest.fixture(scope="module")
def patient(start_robot):
    return start_robot(ARM, "--patient")


@pytest.fixture(scope="module")
def station(patient):
    scene = Scene((SceneRobot(pin.SE3.Identity()),))
    backend = f"franka={patient.host}"
    station = build_station(
        scene=scene, robot="fr3", backend=backend, controller="joint_impedance", speed=SPEED
    )
    yield station
    station.hardware.close()


@pytest.mark.parametrize("check", DEVICE_CONTRACT, ids=lambda check: check.__name__)
def test_the_arm_keeps_the_contract(station, check):
    check(station)


def test_the_arm_recovers_from_a_reflex(station, patient):
    recovers_from_a_problem(station, lambda: patient.ask("reflex", joint=4))

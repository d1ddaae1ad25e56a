"""Contracts: what each part of a plugin must keep, as tests of one line.

Each name is imported on first use, because every pytest session loads
`bt_manip_contracts.pytest_plugin` where the package is installed.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip_contracts.behaviour_contract import Example as Example
    from bt_manip_contracts.device_contract import DEVICE_CONTRACT as DEVICE_CONTRACT
    from bt_manip_contracts.device_contract import GRIPPER_CONTRACT as GRIPPER_CONTRACT
    from bt_manip_contracts.device_contract import holds_an_object as holds_an_object
    from bt_manip_contracts.device_contract import (
        recovers_from_a_problem as recovers_from_a_problem,
    )
    from bt_manip_contracts.model_comparison import verify as verify
    from bt_manip_contracts.pytest_plugin import contracts_of as contracts_of
    from bt_manip_contracts.robot_contract import ROBOT_CONTRACT as ROBOT_CONTRACT
    from bt_manip_contracts.robot_contract import RobotCase as RobotCase

__getattr__ = lazy_exports(__name__)

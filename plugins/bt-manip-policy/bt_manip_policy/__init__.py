"""Learned policies as leaves of trees.

Names are imported on first use, as the process that runs policies needs no simulation.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bt_manip_policy.is_above import IsAbove as IsAbove
    from bt_manip_policy.onnx_policy import OnnxPolicy as OnnxPolicy
    from bt_manip_policy.policy_kind import PolicyKind as PolicyKind
    from bt_manip_policy.policy_process import LoadedPolicy as LoadedPolicy
    from bt_manip_policy.policy_process import PolicyError as PolicyError
    from bt_manip_policy.policy_process import PolicyProcess as PolicyProcess
    from bt_manip_policy.run_policy import RunPolicy as RunPolicy

_MODULES = {
    "IsAbove": "is_above",
    "LoadedPolicy": "policy_process",
    "OnnxPolicy": "onnx_policy",
    "PolicyError": "policy_process",
    "PolicyKind": "policy_kind",
    "PolicyProcess": "policy_process",
    "RunPolicy": "run_policy",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module '{__name__}' has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)

"""Learned policies as leaves of trees.

Names are imported on first use, as the process that runs policies needs no simulation.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip_policy.is_above import IsAbove as IsAbove
    from bt_manip_policy.onnx_policy import OnnxPolicy as OnnxPolicy
    from bt_manip_policy.policy_kind import PolicyKind as PolicyKind
    from bt_manip_policy.policy_process import LoadedPolicy as LoadedPolicy
    from bt_manip_policy.policy_process import PolicyError as PolicyError
    from bt_manip_policy.policy_process import PolicyProcess as PolicyProcess
    from bt_manip_policy.run_policy import RunPolicy as RunPolicy

__getattr__ = lazy_exports(__name__)

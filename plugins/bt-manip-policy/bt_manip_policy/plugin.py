"""The hook that this package declares, and the parts that it registers."""

from pathlib import Path

from bt_manip import hookimpl
from bt_manip_policy.hooks import register_policies as register_policies

TREES = Path(__file__).parent / "trees"


@hookimpl
def register_behaviours(register):
    """Register the policy as a leaf, and a condition for its end."""
    from bt_manip_policy.is_above import IsAbove
    from bt_manip_policy.run_policy import RunPolicy

    register(RunPolicy)
    register(IsAbove)


@hookimpl(specname="register_policies")
def register_own_policies(register):
    """Register policies in ONNX files."""
    from bt_manip_policy.policy_kind import ONNX

    register("onnx", ONNX)


@hookimpl
def register_trees(register):
    """Register the pick-and-place task with a policy."""
    register("pick_place_policy", TREES / "pick_place_policy.xml")

"""Kinds of policies, registered by plugins."""

from dataclasses import dataclass


@dataclass(frozen=True)
class PolicyKind:
    """Factory and limits of policies of a kind, which run in their own process.

    Attributes:
        make: ``"module:name"`` of a class or function of one argument, the file of a policy; it
            returns an object with the attributes of `bt_manip_policy.OnnxPolicy`.
        memory: Limit of the data of the process [bytes].
        load_time: Timeout for loading a policy and its first action, in wall time [s].
        time: Timeout of later actions in wall time [s], long enough for a machine under load.
    """

    make: str
    memory: int = 768 << 20  # onnxruntime itself needs 110 MB
    load_time: float = 1.5
    time: float = 5.0


ONNX = PolicyKind("bt_manip_policy.onnx_policy:OnnxPolicy")
"""Policies in ONNX files; onnxruntime is imported in their process only."""

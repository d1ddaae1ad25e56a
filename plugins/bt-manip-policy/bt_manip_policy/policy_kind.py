"""Kinds of policies, as plugins register them."""

from dataclasses import dataclass


@dataclass(frozen=True)
class PolicyKind:
    """How policies of a kind are made in their process, and what they may take there.

    Attributes:
        make: ``"module:name"`` of a class or function with one argument, the file of a policy; it
            returns an object with the attributes of `bt_manip_policy.OnnxPolicy`.
        memory: Limit of the data of the process [bytes].
        load_time: Longest wall time in which a policy is loaded, and acts for the first time [s].
        time: Longest wall time of an action later [s]: a loaded machine must not decide what
            happens.
    """

    make: str
    memory: int = 768 << 20  # onnxruntime itself takes 110 MB of it
    load_time: float = 1.5
    time: float = 5.0


ONNX = PolicyKind("bt_manip_policy.onnx_policy:OnnxPolicy")
"""Policies in ONNX files; only their process imports onnxruntime."""

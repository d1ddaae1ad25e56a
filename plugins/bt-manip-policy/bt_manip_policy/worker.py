"""The process that runs policies: it answers requests until its pipe ends.

It does not import the simulation. Requests are pickled; replies are a line of JSON and the bytes of
an array, so that reading them runs no code of a policy.
"""

import json
import resource
import signal
from multiprocessing.connection import Connection
from pkgutil import resolve_name
from typing import Any

import numpy as np

from bt_manip.exceptions import BtManipError, one_line

MAX_REPLY = 1 << 20
"""Maximum size of a reply [bytes]."""

LONGEST_ABOUT = 1 << 16
"""Maximum length of the description of a policy [characters]."""

LONGEST_TEXT = 400
"""Maximum length of a library's message [characters]."""


def main(descriptor: int, memory: int) -> None:
    """Answer requests until the parent closes the pipe or ends.

    Args:
        descriptor: File descriptor of the pipe, open in both directions.
        memory: Limit of the process's own data [bytes]; macOS does not enforce it.
    """
    resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # no core file if a policy crashes
    policies: dict[Any, Any] = {}
    with Connection(descriptor) as pipe:
        while True:
            try:
                limit, key, observations = pipe.recv()
            except EOFError:
                return
            try:
                if observations is None:
                    make = resolve_name(key[0])
                    pipe.send_bytes(b"{}")  # the time of imports is not limited here
                # The signal also ends the process in compiled code, and without a parent.
                signal.setitimer(signal.ITIMER_REAL, limit)
                if observations is None:
                    policies[key] = policy = make(key[1])
                    reply = _about(policy)
                else:
                    reply = _act(policies[key], observations)
            except Exception as error:
                reply = problem_reply(error, memory)
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            pipe.send_bytes(reply)


def _about(policy: Any) -> bytes:
    about = {
        "action": policy.action, "rate": policy.rate, "inputs": policy.inputs,
        "states": getattr(policy, "states", {}), "history": getattr(policy, "history", 1),
        "execute": getattr(policy, "execute", 0), "ensemble": getattr(policy, "ensemble", None),
    }  # fmt: skip
    text = json.dumps(about)
    if len(text) > LONGEST_ABOUT:
        raise BtManipError(f"has inputs whose names and shapes take {len(text)} characters")
    return text.encode()


def _act(policy: Any, observations: dict[str, np.ndarray]) -> bytes:
    """Return the actions of a policy, and its next states, as float64."""
    result = policy.act(observations)
    actions, states = result if isinstance(result, tuple) else (result, {})
    arrays = [
        np.ascontiguousarray(values, dtype=np.float64) for values in (actions, *states.values())
    ]
    if (size := sum(values.size for values in arrays)) > MAX_REPLY // 16:
        raise BtManipError(f"returned {size} numbers")
    head = {"shape": arrays[0].shape, "states": list(states)}
    return b"\n".join([json.dumps(head).encode(), b"".join(values.tobytes() for values in arrays)])


def problem_reply(error: Exception, memory: int) -> bytes:
    """Return an exception as a reply; messages of bt-manip are complete."""
    text = one_line(error)
    if isinstance(error, MemoryError) or "alloc" in text:  # bad_alloc, "failed to allocate memory"
        text = f"needs more than {memory >> 20} MB of memory"
    elif not isinstance(error, BtManipError):
        text = f"failed: {type(error).__name__}: {text}"
    return json.dumps({"problem": text[:LONGEST_TEXT]}).encode()

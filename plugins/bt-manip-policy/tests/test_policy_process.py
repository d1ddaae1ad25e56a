"""Policies run in a process that is bounded and ends with this one."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import onnx_files as onnx
import pytest

from bt_manip_policy import LoadedPolicy, PolicyError, PolicyProcess
from bt_manip_policy.policy_kind import ONNX

OBSERVED = {"robot_joint_positions": np.ones(7, dtype=np.float32)}

POLICY = """
import os, time

class Policy:
    action, rate, inputs = "joint_targets", 20.0, {"robot_joint_positions": (None,)}

    def __init__(self, *lines):
        self.count, self.lines = 0, lines

    def act(self, observations):
        self.count += 1
        print("printed")
        exec("\\n".join(self.lines))
        return observations["robot_joint_positions"] + self.count
"""


@pytest.fixture
def process():
    process = PolicyProcess()
    yield process
    process.close()


@pytest.fixture
def load(process, tmp_path):
    """Load a policy in a file of this content."""

    def load(content, **limits):
        path = tmp_path / "policy.onnx"
        path.write_bytes(content)
        return LoadedPolicy(process, str(path), replace(ONNX, **limits), str(path))

    return load


@pytest.fixture
def in_python(process, tmp_path, monkeypatch):
    """Load a policy that is a class of Python, and executes these lines at each action."""
    (tmp_path / "some_policy.py").write_text(POLICY)
    monkeypatch.syspath_prepend(tmp_path)
    return lambda *lines: LoadedPolicy(process, "mine", "some_policy:Policy", *lines)


def is_alive(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().split()[2] not in "ZX"
    except FileNotFoundError:
        return False


def until_dead(process: int, longest: float) -> bool:
    end = time.monotonic() + longest
    while is_alive(process) and time.monotonic() < end:
        os.sched_yield()
    return not is_alive(process)


def test_files_that_want_gigabytes_or_never_end_are_failures(load):
    small = onnx.product(14_000)
    assert len(small) < 500
    with pytest.raises(PolicyError, match="needs more than 768 MB of memory"):
        load(small).act(OBSERVED, 8)
    start = time.monotonic()
    with pytest.raises(PolicyError, match="takes longer than 0.5 s"):
        load(onnx.product(3000, 1000), load_time=0.5).act(OBSERVED, 8)
    assert time.monotonic() - start < 5.0
    with pytest.raises(PolicyError, match="takes longer than 0.2 s"):
        load(onnx.endless(), time=0.2).act(OBSERVED, 8)


def test_a_policy_may_be_a_class_of_python(in_python, capfd):
    policy = in_python()
    assert (policy.action, policy.rate) == ("joint_targets", 20.0)
    assert policy.act(OBSERVED, 7).actions.tolist() == [[2.0] * 7]
    assert policy.act(OBSERVED, 7).actions.tolist() == [[3.0] * 7]
    assert capfd.readouterr() == ("", "")
    batch = in_python("observations['robot_joint_positions'].resize((1, 2, 7))")
    assert batch.act(OBSERVED, 7).actions.tolist() == [[2.0] * 7, [1.0] * 7]  # without the batch's


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("os.abort()", r"ended its process \(SIGABRT\)"),
        ("os._exit(0)", r"ended its process \(exit code 0\)"),
        ("raise KeyboardInterrupt", r"ended its process \(.*\)"),
        ("1 / 0", "failed: ZeroDivisionError: division by zero"),
        ("self.kept = bytearray(1 << 30)", "needs more than 768 MB of memory"),
        ("self.count = float('inf')", "not finite"),
        ("observations['robot_joint_positions'] = 'none'", "failed: "),
        ("observations['robot_joint_positions'].resize(1 << 20)", "returned 1048576 numbers"),
        ("observations['robot_joint_positions'].resize(3)", "returned values of shape 3"),
        ("observations['robot_joint_positions'].resize((2, 1, 7))", "returned values of shape 2"),
    ],
)
def test_whatever_happens_is_a_failure_with_a_reason(in_python, line, reason):
    policy = in_python(line)
    with pytest.raises(PolicyError, match=f"policy 'mine' .*{reason}"):
        policy.act(OBSERVED, 7)
    other = in_python()
    assert other.act(OBSERVED, 7).actions.shape == (1, 7)


def test_a_policy_that_cannot_be_made_is_a_failure(in_python, process):
    for name in ("no_module:Policy", "some_policy:Nothing", "some_policy:os"):
        with pytest.raises(PolicyError, match="policy 'mine' failed: "):
            LoadedPolicy(process, "mine", name)


def test_a_killed_process_is_a_failure_and_the_next_action_has_a_new_one(load, process):
    policy = load(onnx.linear(np.ones(7), {"robot_joint_positions": (7,)}))
    os.kill(process.pid, signal.SIGKILL)
    with pytest.raises(PolicyError, match=r"ended its process \(SIGKILL\)"):
        policy.act(OBSERVED, 7)
    assert policy.act(OBSERVED, 7).actions.tolist() == [[1.0] * 7]


def test_a_stopped_process_is_a_failure(load, process):
    content = onnx.linear(np.ones(7), {"robot_joint_positions": (7,)})
    policy = load(content, time=-0.9)  # and one second for the reply
    os.kill(process.pid, signal.SIGSTOP)
    with pytest.raises(PolicyError, match="does not answer"):
        policy.act(OBSERVED, 7)


def test_an_interrupt_kills_the_process(in_python, process):
    policy = in_python("time.sleep(10)")
    number = process.pid

    def interrupt(*arguments):
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        with pytest.raises(KeyboardInterrupt):
            policy.act(OBSERVED, 7)
    finally:
        signal.signal(signal.SIGALRM, before)
    assert not is_alive(number)


PARENT = """
import sys
import numpy as np
from bt_manip_policy import LoadedPolicy, PolicyKind, PolicyProcess
sys.path.insert(0, sys.argv[1])
kind = PolicyKind("some_policy:Policy", time=1.0)
process = PolicyProcess()
policy = LoadedPolicy(process, "", kind, sys.argv[2])
print(process.pid, flush=True)
while True:
    policy.act({"robot_joint_positions": np.ones(7)}, 7)
"""


@pytest.mark.parametrize("line", ["pass", "while True: pass"])
def test_the_process_ends_when_its_parent_is_killed(in_python, tmp_path, line):
    """At once where it waits; by its limit of time where it computes."""
    command = [sys.executable, "-c", PARENT, str(tmp_path), line]
    parent = subprocess.Popen(command, stdout=subprocess.PIPE)
    number = int(parent.stdout.readline())
    assert is_alive(number)
    parent.kill()
    parent.wait()
    assert until_dead(number, 10.0)

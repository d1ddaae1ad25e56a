"""Policies run in a process that is bounded and ends with this one."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bt_manip_policy import LoadedPolicy, PolicyError, PolicyKind, PolicyProcess
from bt_manip_policy.policy_kind import ONNX

from . import onnx_files as onnx

OBSERVED = {"robot_joint_positions": np.ones(7, dtype=np.float32)}

POLICY = """
import os, time

class Policy:
    action, rate, inputs = "joint_targets", 20.0, {"robot_joint_positions": (None,)}

    def __init__(self, line):
        self.count, self.line = 0, line

    def act(self, observations):
        self.count += 1
        print("printed")
        exec(self.line)
        return observations["robot_joint_positions"] + self.count
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Let processes import a class of policies that execute their path at each action."""
    folder = tmp_path_factory.mktemp("policies")
    (folder / "some_policy.py").write_text(POLICY)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        yield folder


@pytest.fixture(scope="module")
def process(folder):
    """A process, which starts again after tests that end it."""
    process = PolicyProcess()
    yield process
    process.close()


@pytest.fixture
def load(process, tmp_path):
    """Load a policy in a file of this content."""

    def load(content, **limits):
        path = tmp_path / "policy.onnx"
        path.write_bytes(content)
        return LoadedPolicy(process, replace(ONNX, **limits), str(path))

    return load


@pytest.fixture
def in_python(process):
    return lambda line="pass": LoadedPolicy(process, PolicyKind("some_policy:Policy"), line)


def is_alive(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().split()[2] not in "ZX"
    except FileNotFoundError:
        return False


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
    assert policy.act(OBSERVED, 7)[0].tolist() == [[2.0] * 7]
    assert policy.act(OBSERVED, 7)[0].tolist() == [[3.0] * 7]
    assert capfd.readouterr() == ("", "")
    batch = in_python("observations['robot_joint_positions'].resize((1, 2, 7))")
    assert batch.act(OBSERVED, 7)[0].tolist() == [[2.0] * 7, [1.0] * 7]  # without the batch's


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("os.abort()", r"ended its process \(SIGABRT\)"),
        ("os._exit(0)", r"ended its process \(exit code 0\)"),
        ("raise KeyboardInterrupt", r"ended its process \(.*\)"),
        ("1 / 0", "failed: ZeroDivisionError: division by zero"),
        ("self.kept = bytearray(1 << 30)", "needs more than 768 MB of memory"),
        ("observations['robot_joint_positions'] = 'none'", "failed: "),
        ("raise ValueError(999 * 'x ')", "failed: ValueError: (x ){190}$"),  # 400 characters
        ("observations['robot_joint_positions'].resize(65537)", "returned 65537 numbers"),
        ("observations['robot_joint_positions'].resize(65536)", "returned values of shape 65536"),
        ("observations['robot_joint_positions'].resize(3)", "returned values of shape 3"),
        ("observations['robot_joint_positions'].resize((2, 1, 7))", "returned values of shape 2"),
    ],
)
def test_whatever_happens_is_a_failure_with_a_reason(in_python, line, reason):
    policy = in_python(line)
    with pytest.raises(PolicyError, match=f"policy '.*' .*{reason}"):
        policy.act(OBSERVED, 7)
    other = in_python()
    assert other.act(OBSERVED, 7)[0].shape == (1, 7)


def test_a_policy_that_cannot_be_made_is_a_failure(in_python, process):
    for name in ("no_module:Policy", "some_policy:Nothing", "some_policy:os"):
        with pytest.raises(PolicyError, match="policy 'mine' failed: "):
            LoadedPolicy(process, PolicyKind(name), "mine")


def test_a_stopped_process_is_a_failure(load, process):
    content = onnx.linear(np.ones(7), {"robot_joint_positions": (7,)})
    policy = load(content, time=-0.9)  # and one second for the reply
    os.kill(process.pid, signal.SIGSTOP)
    with pytest.raises(PolicyError, match="does not answer"):
        policy.act(OBSERVED, 7)


def test_an_interrupt_kills_the_process(in_python, process):
    policy = in_python("time.sleep(10)")
    number = process.pid

    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
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
processes = [PolicyProcess(), PolicyProcess()]
policies = [LoadedPolicy(*pair) for pair in zip(processes, [kind] * 2, sys.argv[2:])]
print(*(one.pid for one in processes), flush=True)
for policy in policies:
    policy.act({"robot_joint_positions": np.ones(7)}, 7)
"""


def test_processes_end_when_their_parent_is_killed(folder):
    """At once where one waits; by its limit of time where one computes."""
    command = [sys.executable, "-c", PARENT, str(folder), "pass", "while True: pass"]
    parent = subprocess.Popen(command, stdout=subprocess.PIPE)
    numbers = [int(word) for word in parent.stdout.readline().split()]
    assert len(numbers) == 2 and all(map(is_alive, numbers))
    parent.kill()
    parent.wait()
    end = time.monotonic() + 10.0
    while any(map(is_alive, numbers)):
        assert time.monotonic() < end
        time.sleep(0.01)

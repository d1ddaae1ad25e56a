"""Reading policies from files, and their actions."""

import numpy as np
import pytest

from bt_manip_policy import LoadedPolicy, OnnxPolicy, PolicyError, PolicyProcess
from bt_manip_policy.policy_kind import ONNX

from . import onnx_files as onnx

Q = {"robot_joint_positions": (3,)}
OBSERVED = {"robot_joint_positions": np.array([1.0, 2.0, 3.0], dtype=np.float32)}


@pytest.fixture
def written(tmp_path):
    """Return the path of a file with this content."""

    def write(content):
        path = tmp_path / "policy.onnx"
        path.write_bytes(content)
        return path

    return write


@pytest.fixture(scope="module")
def load():
    """Return a function that loads a file in a process."""
    process = PolicyProcess()
    yield lambda path: LoadedPolicy(process, ONNX, str(path))
    process.close()


@pytest.fixture
def read(written, load):
    return lambda content: load(written(content))


def test_actions_are_those_of_the_graph_and_have_the_bits_that_they_have_in_this_process(
    read, written
):
    rng = np.random.default_rng(1)
    offset, weights = rng.normal(size=7), rng.normal(size=(3, 7))
    content = onnx.linear(offset, Q, {"robot_joint_positions": weights})
    here, policy = OnnxPolicy(str(written(content))), read(content)
    for _ in range(10):
        q = rng.normal(size=3).astype(np.float32)
        actions, _ = policy.act({"robot_joint_positions": q}, 7)
        assert actions == pytest.approx((offset + q @ weights)[None], abs=1e-5)
        expected, _ = here.act({"robot_joint_positions": q})
        assert actions.tobytes() == expected.astype(float).tobytes()


@pytest.mark.parametrize("shape", [(1, 3), ("batch", 3)])
def test_observations_get_the_batch_dimension_that_the_file_asks_for(read, shape):
    policy = read(onnx.linear(np.ones((1, 7)), {"robot_joint_positions": shape}))
    policy.check({"robot_joint_positions": (3,)})
    assert policy.act(OBSERVED, 7)[0].shape == (1, 7)


def of_one_node(node, *initializers, **metadata):
    """Encode a policy of a node from joint positions to an action."""
    inputs, outputs = [onnx.value("robot_joint_positions", (7,))], [onnx.value("action", (7,))]
    return onnx.model(onnx.graph([node], inputs, outputs, initializers), **metadata)


DESCRIBED = {"action": "joint_targets", "rate": "20"}
IDENTITY = onnx.node("Identity", ["robot_joint_positions"], ["action"])
SHELL = (1, "robot_joint_positions"), (2, "action"), (4, "RunShell"), (7, "evil")
FOREIGN = of_one_node(onnx.message(*SHELL), **DESCRIBED)
"""A policy whose operator is of another library."""


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"", "does not load"),
        (b"no protobuf at all", "does not load"),
        (bytes(1000), "does not load"),
        (FOREIGN, "does not load"),
        (
            onnx.linear(np.zeros(7), {"x" * 66_000: (3,)}),
            r"names and shapes take 66\d{3} characters",
        ),
        (onnx.counting(output="next_state_m"), "output 'next_state_m', but no input 'state_m'"),
        (of_one_node(IDENTITY), "lack 'bt_manip.action'"),
    ],
)
def test_files_of_something_else_are_rejected(read, content, problem):
    with pytest.raises(PolicyError, match=f"policy.onnx' .*{problem}"):
        read(content)


def test_missing_and_huge_files_are_rejected(load, tmp_path):
    missing, huge = tmp_path / "missing.onnx", tmp_path / "huge.onnx"
    with huge.open("wb") as file:
        file.truncate(2**40)
    for path, problem in ((missing, "No such file"), (tmp_path, "a folder"), (huge, "larger than")):
        with pytest.raises(PolicyError, match=problem):
            load(path)


def test_files_cannot_read_other_files(read, tmp_path, monkeypatch):
    """Weights in a file of their own, wherever it is, are not read."""
    np.ones(7, dtype=np.float32).tofile(tmp_path / "weights")
    monkeypatch.chdir(tmp_path)
    for location in ("weights", str(tmp_path / "weights"), "../weights"):
        entry = onnx.message((1, "location"), (2, location))
        weights = onnx.message((1, 7), (2, onnx.FLOAT), (8, "w"), (14, 1), (13, entry))
        add = onnx.node("Add", ["robot_joint_positions", "w"], ["action"])
        with pytest.raises(PolicyError, match="does not load"):
            read(of_one_node(add, weights, **DESCRIBED))


def test_inputs_and_metadata_are_the_specification(read):
    policy = read(onnx.linear(np.zeros(7), Q, rate="25"))
    assert policy.inputs == Q
    assert (policy.action, policy.rate) == ("cartesian_deltas", 25.0)
    assert (policy.history, policy.execute, policy.ensemble) == (1, 0, None)
    assert read(onnx.linear(np.zeros(7), {"x" * 65_000: (3,)})).inputs == {"x" * 65_000: (3,)}
    described = {"history": "64", "execute": "1000000", "ensemble": "1000"}
    policy = read(onnx.linear(np.zeros(7), {"robot_joint_positions": (64, 3)}, **described))
    assert (policy.history, policy.execute, policy.ensemble) == (64, 1_000_000, 1000.0)


@pytest.mark.parametrize(
    ("key", "values"),
    [("rate", ("0", "nan", "1001", "often")), ("history", ("0", "2.5", "65")),
     ("execute", ("-1", "1000001")), ("ensemble", ("-0.1", "nan", "1001"))],
)  # fmt: skip
def test_metadata_without_a_sense_are_rejected(read, key, values):
    for value in values:
        with pytest.raises(PolicyError, match=f"bt_manip.{key}"):
            read(onnx.linear(np.zeros(7), Q, **{key: value}))

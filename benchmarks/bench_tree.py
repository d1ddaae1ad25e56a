"""What a tick of the tree language costs, beside py_trees on trees of the same shape."""

import time
from collections.abc import Callable
from itertools import count
from pathlib import Path
from statistics import median

import py_trees

from bt_manip.bt import (
    Action,
    AlwaysSuccess,
    BehaviourRegistry,
    Node,
    Sequence,
    Status,
    Tree,
    parse_tree,
    tree_to_xml,
)
from bt_manip.plugins import load_plugins
from bt_manip.runner import known_behaviours

LEAVES = 1000
ROUNDS = 15
TREES = Path(__file__).resolve().parent.parent / "trees"


PICK = """
<RetryUntilSuccessful num_attempts="3"><Fallback>
  <Sequence>
    <Script code="height := 0.1 + 0.05"/><OpenGripper/>
    <Hover object="{c}" height="{height}"/><Reach object="{c}"/><Grasp object="{c}"/>
  </Sequence>
  <ForceFailure><OpenGripper/></ForceFailure>
</Fallback></RetryUntilSuccessful>
"""
"""Ten nodes with loops, scripts and entries."""


def nested_loops() -> str:
    """Make 1,000 nodes: picks in sequences in loops, one in the other ten times."""
    text = PICK * 10
    for _ in range(9):
        text = f'<Repeat num_cycles="2"><Sequence>{PICK * 10}{text}</Sequence></Repeat>'
    return text


class Succeed(Action):
    """Succeed, as a behaviour written in Python does."""

    def update(self) -> Status:
        """Succeed."""
        return Status.SUCCESS


def flat(leaf: Callable[[str], Node]) -> Node:
    """Make a Sequence of a thousand leaves."""
    return Sequence("flat", [leaf(f"leaf {i}") for i in range(LEAVES)])


def deep(leaf: Callable[[str], Node]) -> Node:
    """Make 10 Sequences of 10 Sequences of 10 leaves."""
    number = count()

    def level(depth: int) -> Node:
        if depth == 0:
            return leaf(f"leaf {next(number)}")
        return Sequence(f"sequence {next(number)}", [level(depth - 1) for _ in range(10)])

    return level(3)


def stock_flat() -> py_trees.behaviour.Behaviour:
    """Make the flat shape of stock py_trees behaviours."""
    leaves = [py_trees.behaviours.Success(f"leaf {i}") for i in range(LEAVES)]
    return py_trees.composites.Sequence("flat", True, leaves)


def stock_deep() -> py_trees.behaviour.Behaviour:
    """Make the deep shape of stock py_trees behaviours."""
    number = count()

    def level(depth: int) -> py_trees.behaviour.Behaviour:
        if depth == 0:
            return py_trees.behaviours.Success(f"leaf {next(number)}")
        children = [level(depth - 1) for _ in range(10)]
        return py_trees.composites.Sequence(f"sequence {next(number)}", True, children)

    return level(3)


def rows() -> list[tuple[str, str, str]]:
    """Measure.

    Returns:
        What was measured, the result, and what was asked for.
    """
    found = []
    shapes: list[tuple[str, Callable[..., Node], Callable[[], py_trees.behaviour.Behaviour]]] = [
        ("1000 leaves in one Sequence", flat, stock_flat),
        ("10 x 10 x 10", deep, stock_deep),
    ]
    for title, ours, stock in shapes:
        for kind, leaf in (("AlwaysSuccess", AlwaysSuccess), ("Python actions", Succeed)):
            mine, theirs = _interleaved(Tree(ours(leaf)).tick, stock().tick_once)
            result = f"{mine * 1e6:.0f} us, 1/{theirs / mine:.1f} of {theirs * 1e6:.0f} us"
            found.append((f"tick of {title}, {kind}", result, "at most 1/8 of py_trees'"))
    registry = BehaviourRegistry()
    for title, shape in (("flat", flat), ("deep", deep)):
        text = tree_to_xml(shape(AlwaysSuccess), registry)
        reading = _median(lambda text=text: parse_tree(text, registry))
        found.append((f"reading 1000 leaves, {title}", f"{reading * 1e3:.0f} ms", "at most 100 ms"))
    found += [
        (f"check of 1000 nodes, {title}", f"{_check(text) * 1e3:.0f} ms", "at most 300 ms")
        for title, text in (("picks in a row", PICK * 100), ("nested loops", nested_loops()))
    ]
    found.append(("tick of pick_place", f"{_pick_place() * 1e6:.1f} us", "at most 50 us"))
    return found


def _check(text: str) -> float:
    """Give the time to read and check a tree as ``bt-manip tree check`` does [s]."""
    document = f"""<root BTCPP_format="4"><BehaviorTree ID="Main"><Sequence>
        <SpawnObject object="{{c}}"/>{text}</Sequence></BehaviorTree></root>"""
    behaviours = known_behaviours(load_plugins().parts)
    assert not parse_tree(document, behaviours).warnings
    return _median(lambda: parse_tree(document, behaviours))


def _pick_place() -> float:
    """Give the time of a tick of the tree alone [s], while its deepest leaf is running."""

    class Busy(Action):
        """Run on."""

        def update(self) -> Status:
            return Status.RUNNING

    text = (TREES / "pick_place.xml").read_text(encoding="utf-8")
    registry = BehaviourRegistry()
    for name in _leaf_names(text, registry):
        base = Busy if name == "Grasp" else Succeed
        registry.register(type(name, (base,), {"ports": {}}), name)
    tree = parse_tree(_without_ports(text, registry), registry, strict=False)
    tree.blackboard["attempts"] = 3
    return _median(tree.tick, repeat=200)


def _leaf_names(text: str, registry: BehaviourRegistry) -> list[str]:
    from bt_manip.bt.xml.source import parse_source

    names = {
        element.name
        for tree in parse_source(text).root.children
        if tree.name == "BehaviorTree"
        for element in tree.iterate()
    }
    return sorted(name for name in names - {"BehaviorTree"} if name not in registry)


def _without_ports(text: str, registry: BehaviourRegistry) -> str:
    """Take the ports off the leaves that stand in for the real ones."""
    from bt_manip.bt.xml.source import parse_source
    from bt_manip.bt.xml.writer import write_source

    source = parse_source(text)
    for element in source.root.iterate():
        if element.name in registry.names(built_in=False):
            element.attributes = {}
    return write_source(source)


def _interleaved(one: Callable[[], object], other: Callable[[], object]) -> tuple[float, float]:
    """Give the median times of two functions [s], called in turns."""
    times: tuple[list[float], list[float]] = ([], [])
    for _ in range(ROUNDS):
        for function, measured in ((one, times[0]), (other, times[1])):
            start = time.perf_counter()
            function()
            measured.append(time.perf_counter() - start)
    return median(times[0]), median(times[1])


def _median(function: Callable[[], object], repeat: int = ROUNDS) -> float:
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return median(times)


def main() -> None:
    """Print the table."""
    table = rows()
    widths = [max(len(row[column]) for row in table) for column in range(3)]
    for row in table:
        print(
            "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip()
        )


if __name__ == "__main__":
    main()

"""The dialect of MoveIt Pro's objectives, and its decorators."""

import pytest

from bt_manip.bt import BehaviourRegistry, parse_tree, read_tree
from bt_manip.exceptions import TreeError
from bt_manip_moveit_pro.dialect import MOVEIT_PRO

TEXT = """<root BTCPP_format="4" main_tree_to_execute="Pick All Cubes">
  <BehaviorTree ID="Pick All Cubes" _results="all" _description="picks"
      _favorite="true">
    <Decorator ID="ForEach" vector_in="a;b;c" out="{item}" index="{index}">
      <SubTree ID="Pick One" item="{item}" index="{index}" _collapsed="true"/>
    </Decorator>
  </BehaviorTree>
  <BehaviorTree ID="Pick One" _subtreeOnly="true">
    <Script code="@all := &quot;it's &quot; .. item .. index"/>
  </BehaviorTree>
  <TreeNodesModel><SubTree ID="Pick One"><MetadataFields><Metadata runnable="false"/>
  </MetadataFields></SubTree></TreeNodesModel>
</root>"""


@pytest.fixture
def registry():
    registry = BehaviourRegistry()
    registry.register_dialect(MOVEIT_PRO)
    return registry


@pytest.mark.parametrize("dialect", ["moveit-pro", "auto"])
def test_its_documents_run(registry, dialect, tmp_path):
    (tmp_path / "pick.xml").write_text(TEXT)
    reading = read_tree(tmp_path / "pick.xml", registry, dialect=dialect)
    tree = reading.usable_tree()

    assert [tree.tick().name for _ in range(3)] == ["RUNNING", "RUNNING", "SUCCESS"]
    assert tree.blackboard["all"] == "it's c2"
    assert reading.problems == ()


SPACED = '<root BTCPP_format="4"><BehaviorTree ID="My Tree"><AlwaysSuccess/></BehaviorTree></root>'


@pytest.mark.parametrize(("text", "dialect"), [(TEXT, "btcpp"), (SPACED, "auto")])
def test_the_engine_refuses_spaces_in_a_name_which_alone_are_no_trait_of_theirs(
    registry, text, dialect
):
    with pytest.raises(TreeError, match="the tree name '.*' contains"):
        parse_tree(text, registry, dialect=dialect)


@pytest.mark.parametrize(
    ("node", "child", "statuses"),
    [
        ('RepeatUnlessFailureEachTick num_cycles="3"', '<Script code="n := 1"/>', "RRS"),
        ("RepeatUnlessFailureEachTick", "<AlwaysSuccess/>", "R" * 50),  # never ends
        ('RepeatUnlessFailureEachTick num_cycles="3"', "<AlwaysFailure/>", "F"),
        ('RepeatUnlessFailureWithinTick num_cycles="3"', "<AlwaysFailure/>", "F"),
        ('ForEachUntilSuccess vector_in="4;5"', "<AlwaysFailure/>", "RF"),
        ('ForEachUntilSuccess vector_in=""', "<AlwaysSuccess/>", "F"),
        (
            'ForEachUntilSuccess vector_in="4;5;6" index="{i}"',
            '<ScriptCondition code="i == 1"/>',
            "RS",
        ),
    ],
)
def test_decorators_tick_their_child_once_a_tick_until_they_complete(
    registry, node, child, statuses
):
    body = f"<{node}>{child}</{node.split()[0]}>"
    text = f'<root><BehaviorTree ID="Main">{body}</BehaviorTree></root>'
    tree = parse_tree(text, registry, dialect="auto")
    assert "".join(tree.tick().name[0] for _ in statuses) == statuses

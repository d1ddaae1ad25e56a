"""The dialect of MoveIt Pro's objectives."""

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
def test_its_documents_run(registry, dialect):
    tree = parse_tree(TEXT, registry, dialect=dialect)

    assert [tree.tick().name for _ in range(3)] == ["RUNNING", "RUNNING", "SUCCESS"]
    assert tree.blackboard["all"] == "it's c2"


def test_they_give_no_warnings(registry, tmp_path):
    path = tmp_path / "objective.xml"
    path.write_text(TEXT)
    assert read_tree(path, registry, dialect="auto").problems == ()


def test_the_engine_refuses_them(registry):
    with pytest.raises(TreeError, match="the tree name 'Pick All Cubes' contains"):
        parse_tree(TEXT, registry)


def test_a_space_in_a_tree_name_alone_is_no_trait_of_theirs(registry):
    text = """<root BTCPP_format="4">
      <BehaviorTree ID="My Tree"><AlwaysSuccess/></BehaviorTree>
    </root>"""
    with pytest.raises(TreeError, match="the tree name 'My Tree' contains"):
        parse_tree(text, registry, dialect="auto")

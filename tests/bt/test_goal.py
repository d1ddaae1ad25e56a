"""The goal of a tree in XML and in Python."""

import pytest

from bt_manip.behaviours import IsAt, IsIn
from bt_manip.bt import (
    AlwaysSuccess,
    BehaviourRegistry,
    Condition,
    Status,
    Tree,
    TreeDefinition,
    TreeDocument,
    parse_tree,
    tree_to_xml,
)
from bt_manip.bt.loading import read_tree_text
from bt_manip.exceptions import TreeError

XML = """<root BTCPP_format="4">
  <BehaviorTree ID="Main" _goal="{}">
    <AlwaysSuccess/>
  </BehaviorTree>
</root>
"""
BOTH = "IsIn object={o} container=box &amp;&amp; IsAt pose=0.4;0;1"


@pytest.fixture
def registry():
    return BehaviourRegistry([IsIn, IsAt])


@pytest.mark.parametrize(
    ("goal", "message"),
    [
        ("", "expected conditions joined by '&&'"),
        ("IsOut object=a", "no condition is named 'IsOut'"),
        ("AlwaysSuccess", "no condition is named 'AlwaysSuccess'"),
        ("IsIn object=a contaner=b", "IsIn has no port 'contaner'; did you mean 'container'?"),
        ("IsIn object=a", "IsIn needs the port 'container'"),
        ("IsIn object a", "IsIn: expected one port=value for each port, got 'object'"),
        ("IsIn object='a container=b", "cannot be read: No closing quotation"),
        ("IsAt pose=up", "port 'pose'"),
    ],
)
def test_a_wrong_goal_is_one_error_at_its_place(registry, goal, message):
    with pytest.raises(TreeError) as raised:
        parse_tree(XML.format(goal), registry)
    assert str(raised.value).startswith("<text>:2:34: error: _goal: ")
    assert message in str(raised.value) and len(raised.value.problems) == 1


def test_an_entry_that_nothing_writes_is_a_warning(registry):
    (warning,) = read_tree_text(XML.format("IsIn object={cub} container=box"), registry).warnings
    assert "<text>:2:3: warning: nothing writes the blackboard entry 'cub'" in str(warning)


def test_a_goal_that_only_a_sub_tree_has_is_a_warning(registry):
    main = '<BehaviorTree ID="All"{}><SubTree ID="Main"/></BehaviorTree></root>'
    xml = XML.replace("<root ", '<root main_tree_to_execute="All" ').replace("</root>", main)
    isin = "IsIn object=a container=box"
    (warning,) = read_tree_text(xml.format(isin, ""), registry).warnings
    assert str(warning) == (
        "<text>:2:27: warning: the '_goal' of a sub-tree is ignored; main tree 'All' has none"
    )
    assert read_tree_text(xml.format(isin, f' _goal="{isin}"'), registry).warnings == ()


@pytest.mark.parametrize(
    ("goal", "reads"),
    [
        ("ScriptCondition code='1==1' &amp;&amp; ScriptCondition code=true", False),
        ("ScriptCondition code='1==1' &amp;&amp; IsAt pose=0.4;0;1", True),
    ],
)
def test_a_goal_that_does_not_read_the_cell_is_a_warning(registry, goal, reads):
    reading = read_tree_text(XML.format(goal), registry)

    warnings = [str(warning) for warning in reading.warnings if "reads the cell" in str(warning)]
    assert reading.tree.goal_reads_cell is reads
    assert len(warnings) == (not reads)
    assert all(w.startswith("<text>:2:34: warning: _goal: no condition of") for w in warnings)


def test_a_condition_that_takes_infrastructure_reads_the_cell():
    class Pure(Condition):
        def update(self):
            return Status.SUCCESS

    class Looking(Pure):
        def setup(self, **infrastructure):
            self.cell = infrastructure["cell"]

    assert not Tree(AlwaysSuccess()).goal_reads_cell
    assert not Tree(AlwaysSuccess(), goal=Pure()).goal_reads_cell
    assert Tree(AlwaysSuccess(), goal=[Pure(), Looking()]).goal_reads_cell


def test_a_goal_is_written_as_it_was_read(registry):
    assert tree_to_xml(parse_tree(XML.format(BOTH), registry), registry) == XML.format(BOTH)


def test_a_goal_of_python_is_written_to_xml(registry):
    goal = IsIn(object="{object}", container="the basket")
    tree = Tree(AlwaysSuccess(), goal=goal, tree_id="Main")
    text = "IsIn object={object} container='the basket'"
    assert f'_goal="{text}"' in tree_to_xml(tree, registry)
    assert parse_tree(tree_to_xml(tree, registry), registry).goal[0].given == goal.given
    document = TreeDocument([TreeDefinition("Main", AlwaysSuccess(), goal=[goal])])
    assert tree_to_xml(document, registry) == XML.format(text)


def test_a_task_is_a_sentence_or_the_id_in_words(registry):
    given = XML.replace("_goal", '_task="put it there" _goal').format(BOTH)
    tree = parse_tree(given, registry)
    assert tree.task == "put it there"
    for tree_id, words in (("PickPlace2", "pick place2"), ("pick_place", "pick place")):
        assert Tree(AlwaysSuccess(), tree_id=tree_id).task == words
    written = tree_to_xml(Tree(AlwaysSuccess(), tree_id="Main", task="do it"), registry)
    assert parse_tree(written, registry).task == "do it"


def test_a_task_may_be_the_sentence_of_an_entry():
    tree = Tree(AlwaysSuccess(), tree_id="PickIt", task="{sentence}")
    assert tree.task == "pick it"
    tree.blackboard["sentence"] = "pick the red one"
    assert tree.task == "pick the red one"


def test_a_goal_consists_of_conditions():
    with pytest.raises(TreeError, match="a goal consists of conditions, got AlwaysSuccess"):
        Tree(AlwaysSuccess(), goal=AlwaysSuccess())
    with pytest.raises(TreeError, match="IsIn needs the port 'container'"):
        Tree(AlwaysSuccess(), goal=IsIn(object="{cube}"))

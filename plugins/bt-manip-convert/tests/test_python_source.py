"""A document as Python source, and back."""

import pytest

from bt_manip.behaviours import Hover, IsAt, IsIn
from bt_manip.bt import Action, BehaviourRegistry, Status, Stubs, Tree, read_tree, tree_to_xml
from bt_manip.exceptions import TreeError
from bt_manip_convert import to_python

DOCUMENT = """\
<?xml version="1.0" encoding="UTF-8"?>
<!-- before -->
<root BTCPP_format="4" main_tree_to_execute="Pick a part" _x="1">
  <!-- how it is done -->
  <BehaviorTree ID="Pick a part" _goal="{goal}">
    <!-- first -->
    <Control ID="Sequence" name="top" _collapsed="false">
      <Hover object="{{cube}}" height="0.3" _skipIf="done"/>
      <Action ID="DetectTags" image="{{image}}" poses="{{poses}}"/>
      <SubTree ID="Move to Place" place_name="Above" _collapsed="true"/>
      <SubTree ID="Wait"/>
      <Decorator ID="Repeat" num_cycles="2">
        <Action ID="MoveHand" name="close it" opening="0.7" _skipIf="2 &gt; 5"/>
      </Decorator>
    </Control>
  </BehaviorTree>
  <BehaviorTree ID="Wait" _task="wait a bit" _description="Waits">
    <Sleep msec="10"/>
  </BehaviorTree>
  <TreeNodesModel>
    <SubTree ID="Pick a part">
      <MetadataFields>
        <Metadata subcategory="Application - Basic"/>
      </MetadataFields>
    </SubTree>
  </TreeNodesModel>
</root>
<!-- the end -->
""".format(goal="IsIn object={o} container=b &amp;&amp; IsAt pose=1;0;1")


@pytest.fixture
def registry():
    return BehaviourRegistry([Hover, IsIn, IsAt])


@pytest.fixture
def read(tmp_path, registry):
    def read(text, registry=registry, **options):
        (tmp_path / "tree.xml").write_text(text)
        return read_tree(tmp_path / "tree.xml", registry, **options)

    return read


def test_nothing_is_lost_on_the_way(read, registry):
    stubs = Stubs(True, {"MoveHand": "FAILURE"})
    reading = read(DOCUMENT, stubs=stubs)
    module = {}
    exec(compile(to_python(reading, stubs), "tree.py", "exec"), module)
    assert tree_to_xml(module["document"](), registry) == DOCUMENT


def test_stubs_are_declared_and_give_their_results(read):
    stubs = Stubs(True, {"DetectTags": "FAILURE"})
    source = to_python(read(DOCUMENT, stubs=stubs), stubs)
    assert (
        'DetectTags = declare("DetectTags", "Action", ["image", "poses"], result="FAILURE")'
        in source
    )
    module = {}
    body = '<BehaviorTree ID="Look"><DetectTags image="a"/></BehaviorTree>'
    exec(to_python(read(f"<root>{body}</root>", stubs=stubs), stubs), module)
    tree = Tree(module["look"]())
    tree.tick()
    assert tree.root.status is Status.FAILURE


def test_the_source_is_python_as_people_write_it(read):
    source = to_python(
        read(
            '<root><BehaviorTree ID="PickIt"><Sequence name="pick"><Hover object="{cube}" '
            'height="0.3" _skipIf="done"/></Sequence></BehaviorTree></root>'
        )
    )
    assert "def pick_it() -> Node:" in source
    assert 'Sequence("pick", Hover(object="{cube}", height=0.3, skip_if="done"))' in source


def test_a_class_that_cannot_be_imported_is_named(read):
    class Local(Action):
        """Be local."""

    text = '<root><BehaviorTree ID="A"><Local/></BehaviorTree></root>'
    with pytest.raises(TreeError, match="the class of 'Local' cannot be imported"):
        to_python(read(text, BehaviourRegistry([Local])))


def nested(levels):
    """Write a tree of so many levels, the leaf included."""
    body = "<Inverter>" * (levels - 1) + "<AlwaysSuccess/>" + "</Inverter>" * (levels - 1)
    return f'<root BTCPP_format="4"><BehaviorTree ID="A">{body}</BehaviorTree></root>'


def test_python_source_has_no_more_brackets_than_python_reads(read):
    compile(to_python(read(nested(200))), "tree.py", "exec")
    with pytest.raises(TreeError, match="too deep for Python: 201 brackets .* sub-tree"):
        to_python(read(nested(201)))

"""Documents as Groot 1 and Groot2 save them."""

import pytest

from bt_manip.bt import BehaviourRegistry, Stubs
from bt_manip.bt.loading import read_tree_text

DOCUMENT = """<root BTCPP_format="4" main_tree_to_execute="Main">
<BehaviorTree ID="Main"><Sequence>
  <SubTree ID="Inner" armed="1"/>
  {}
</Sequence></BehaviorTree>
<BehaviorTree ID="Inner"><ScriptCondition code="armed == 1"/></BehaviorTree>
<TreeNodesModel>
  <SubTree ID="Inner">
    <input_port name="__shared_blackboard" default="false"/>
    <input_port name="armed"/>
  </SubTree>
  <Action ID="Open"><input_port name="width"/></Action>
  {}
</TreeNodesModel></root>"""


def read(body="", model="", **options):
    return read_tree_text(DOCUMENT.format(body, model), BehaviourRegistry(), **options)


def test_a_shared_blackboard_in_the_model_of_a_sub_tree_hides_no_error():
    assert read().tree.tick().name == "SUCCESS"
    (error,) = read("<Inverter/>").errors
    assert str(error) == "<text>:4:3: error: Inverter must have exactly 1 child, not 0"


@pytest.mark.parametrize("name", ["InputPort", "Input_Port", "inputport"])
def test_a_misspelt_port_of_a_model_offers_the_right_element(name):
    (warning,) = read(model=f'<Action ID="A"><{name} name="x"/></Action>').problems
    assert str(warning).endswith(f"<{name}> declares nothing; did you mean <input_port>?")


def test_ports_that_a_model_does_not_declare_are_warnings_with_stubs():
    body = '<Open width="1" speed="2"/>'
    (error,) = read(body, stubs=Stubs()).errors
    assert "Open has no port 'speed'" in str(error)
    reading = read(body, stubs=Stubs(unknown=True))
    assert reading.tree is not None
    assert [p.message for p in reading.problems] == ["the model of Open declares no port 'speed'"]


def test_unknown_nodes_with_children_name_the_stub():
    (error,) = read("<Guard><AlwaysSuccess/></Guard>", stubs=Stubs(unknown=True)).errors
    assert "no node is named 'Guard'" in str(error)
    assert "; --stub Guard=RetryUntilSuccessful lets it do the same as another" in str(error)
    (error,) = read("<Try><AlwaysSuccess/><AlwaysSuccess/></Try>").errors
    assert "--stub Try=Fallback" in str(error)

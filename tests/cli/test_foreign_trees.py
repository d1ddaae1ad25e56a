"""Options for trees of others: --models, --stub-unknown, --stub and --with."""

import pytest

TREE = """\
<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <TryTwice number_of_retries="2">
      <FollowPath path="{path}"/>
      <SubTree ID="ClearThings"/>
    </TryTwice>
  </BehaviorTree>
</root>
"""
MODELS = """\
<root><TreeNodesModel>
  <Action ID="FollowPath"><output_port name="path"/></Action>
  <Control ID="TryTwice"><input_port name="number_of_retries"/></Control>
  <SubTree ID="ClearThings"/>
</TreeNodesModel></root>
"""


@pytest.fixture(autouse=True)
def files(write):
    write(TREE)
    write(MODELS, "nodes.xml")


def test_models_declare_nodes_for_check_and_show(bt_manip):
    code, _, err = bt_manip("tree", "check", "tree.xml", "--models", "nodes.xml")
    assert code == 0
    assert "Stubs:" in err and "TryTwice (Control, only declared)" in err
    assert "FollowPath" in bt_manip("tree", "show", "tree.xml", "--models", "nodes.xml").out


def test_a_run_refuses_a_declared_control_until_a_known_one_does_its_work(bt_manip):
    code, _, err = bt_manip("run", "tree.xml", "--models", "nodes.xml")
    assert code == 2 and '--stub "TryTwice=Fallback"' in err
    code, _, err = bt_manip(
        "run", "tree.xml", "--stub-unknown", "--stub", "TryTwice=Fallback", "--stub",
        "FollowPath=FAILURE", "--quiet",
    )  # fmt: skip
    assert code == 0
    assert "FollowPath (fails)" in err and "ClearThings (succeeds)" in err
    assert "no node of the tree is named so" not in err


@pytest.mark.parametrize("text", ["FollowPath", "=SUCCESS", "FollowPath="])
def test_a_stub_without_name_or_result_is_bad_input(bt_manip, text):
    code, _, err = bt_manip("tree", "check", "tree.xml", "--stub", text)
    assert code == 2 and "--stub wants NAME=RESULT" in err


def test_a_stub_that_no_tree_has_a_use_for_is_told(bt_manip):
    _, _, err = bt_manip("tree", "check", "tree.xml", "--stub-unknown", "--stub", "Folow=FAILURE")
    assert "--stub: nothing is named 'Folow'" in err
    code, _, err = bt_manip("run", "pick_place", "--stub", "Folow=FAILURE", "--quiet")
    assert code == 0 and "a stub for 'Folow', but no node of the tree is named so" in err


def test_errors_of_a_library_are_told_once(bt_manip, write, folder):
    (folder / "parts").mkdir()
    nodes = "".join(f"<Sequence{number}/>" for number in range(12))  # with hints
    bad = f'<root><BehaviorTree ID="Bad"><Sequence>{nodes}</Sequence></BehaviorTree></root>'
    write(bad, "parts/bad.xml")
    using = '<root><BehaviorTree ID="Main"><SubTree ID="Bad"/></BehaviorTree></root>'
    for name in ("a.xml", "b.xml"):
        write(using, name)
    code, out, err = bt_manip("tree", "check", "a.xml", "b.xml", "--with", "parts")
    assert code == 2 and out.count("'Sequence3'") == 1 and "2 trees: 12 errors" in err
    code, _, err = bt_manip("tree", "check", "parts/bad.xml", "--with", "parts")
    assert code == 2 and "1 tree: 12 errors" in err


def test_formatting_needs_no_declarations(bt_manip):
    assert bt_manip("tree", "format", "tree.xml", "--check").code == 0

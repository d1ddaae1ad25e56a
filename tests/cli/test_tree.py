"""``bt-manip tree``: check, show, format, convert, model, schema."""

import functools
from pathlib import Path

import pytest
from lxml import etree

GOOD = """\
<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <Sequence name="s">
      <AlwaysSuccess/>
    </Sequence>
  </BehaviorTree>
</root>
"""


@pytest.fixture
def call(bt_manip):
    """Run ``bt-manip tree``."""
    return functools.partial(bt_manip, "tree")


def test_check_prints_all_findings_and_exits_with_2(call, write):
    code, out, err = call(
        "check", write(GOOD.replace("<AlwaysSuccess/>", "<AlwaysSucess/><Script/>"))
    )
    assert (code, err) == (2, "1 tree: 2 errors, 0 warnings\n")
    assert out.splitlines() == [
        "tree.xml:4:7: error: no node is named 'AlwaysSucess'; did you mean 'AlwaysSuccess' "
        "or 'AlwaysFailure'?",
        "tree.xml:4:22: error: Script needs the port 'code' of type std::string (the script)",
    ]


def test_check_of_a_tree_with_warnings_or_what_the_engine_takes_is_fine(call, write):
    code, out, _ = call("check", write(GOOD.replace("<Always", "<AlwaysSuccess _x='1'/><Always")))
    assert code == 0 and "warning: the attribute '_x'" in out
    name = write(GOOD.replace("<AlwaysSuccess/>", "<Repeat><AlwaysSuccess/></Repeat>"))
    assert call("check", name).code == 2
    assert call("check", name, "--engine").code == 0


def test_check_warns_of_a_goal_in_python_that_does_not_read_the_cell(call, write):
    goal = "from bt_manip.bt import *\n\ndef my_tree():\n    return Tree(AlwaysSuccess(), goal={})"
    write(goal.format("ScriptCondition(code='1==1')"), "mine.py")
    code, out, _ = call("check", "mine.py:my_tree")
    assert code == 0 and out.startswith(
        "mine.py:3:1: warning: goal: no condition of the goal reads"
    )
    imported = "from bt_manip.behaviours import ObjectExists\n"
    write(imported + goal.format("ObjectExists(object='basket')"), "mine.py")
    assert call("check", "mine.py:my_tree").out == ""


def test_check_takes_several_trees_and_files_that_hold_only_sub_trees(call, write):
    part = '<root><BehaviorTree ID="A"><AlwaysSuccess/></BehaviorTree>'
    part += '<BehaviorTree ID="B"><AlwaysFailure/></BehaviorTree></root>'
    code, out, err = call("check", write(GOOD), write(part, "part.xml"))
    assert (code, err) == (0, "2 trees: 0 errors, 2 warnings\n")
    version, choice = out.splitlines()
    assert "part.xml:1:1: warning: which tree to run?" in choice
    assert choice.endswith("'run part.xml:TREE' names one; trees that no other uses: A, B")
    assert 'no BTCPP_format="4": read as version 4; --dialect btcpp-3 reads version 3' in version


def test_a_missing_tree_offers_the_nearest(call, folder):
    code, out, err = call("check", "pick_plac", "nothing.xml")
    assert (code, err) == (2, "2 trees: 2 errors, 0 warnings\n")
    first, second = out.splitlines()
    assert first.startswith("pick_plac: error: ") and "did you mean 'pick_place'" in first
    assert second.startswith("nothing.xml: error: no tree file")


PARTS = """<root BTCPP_format="4">
<BehaviorTree ID="Main"><SubTree ID="Part"/></BehaviorTree>
<BehaviorTree ID="Part"><AlwaysSuccess/></BehaviorTree>
<BehaviorTree ID="Other"><AlwaysFailure/></BehaviorTree>
</root>"""


def test_a_tree_of_a_file_is_named_after_a_colon(call, write):
    name = write(PARTS)
    assert call("show", f"{name}:Part").out == "Part\n└─ AlwaysSuccess\n"
    assert "no tree is named 'Prt'; did you mean 'Part'" in call("check", f"{name}:Prt").out
    assert call("show", name).err.endswith("trees that no other uses: Main, Other\n")
    assert "no tree file 'none.xml'" in call("check", "none.xml:Main").out
    assert call("convert", name, "--to", "xml").out.startswith('<root BTCPP_format="4">')


def test_show_draws_as_text_dot_and_svg_or_says_what_is_wrong(call, write):
    name = write(GOOD)
    assert call("show", name).out == 'Main\n└─ → Sequence "s"\n   └─ AlwaysSuccess\n'
    assert call("show", name, "--as", "dot").out.startswith('digraph "Main"')
    call("show", name, "--as", "svg", "-o", "tree.svg")
    assert etree.parse("tree.svg").getroot().tag.endswith("svg")
    code, _, err = call("show", write(GOOD.replace("AlwaysSuccess", "Nope")))
    assert code == 2 and "tree.xml:4:7: error: no node is named 'Nope'" in err


def test_format_writes_in_place_and_then_has_nothing_to_do(call, write, folder):
    name = write(GOOD.replace("\n", "").replace("  ", " "))
    assert call("format", name, "--check").code == 2
    assert call("format", name).code == 0
    assert (folder / name).read_text() == GOOD
    assert call("format", name, "--check").code == 0


def test_format_leaves_documents_without_trees_as_they_are(call, write, folder):
    name = write("<mujoco><worldbody/></mujoco>", "robot.xml")
    assert call("format", name).err == "Error: robot.xml:1:1: no trees: <mujoco>, not <root>\n"
    assert (folder / name).read_text() == "<mujoco><worldbody/></mujoco>"


def test_the_trees_that_come_with_bt_manip_have_the_standard_form(call):
    root = Path(__file__).resolve().parents[2]
    folders = root / "trees", root / "examples", *root.glob("plugins/*/bt_manip_*")
    files = [file for folder in folders for file in folder.rglob("*.xml")]
    trees = [file for file in files if "<BehaviorTree" in file.read_text()]
    assert len(trees) > 20
    assert call("format", "--check", *trees).out == ""


def test_a_python_tree_converts_to_a_document(call, write):
    write(
        "from bt_manip.bt import AlwaysSuccess\n\ndef main():\n    return AlwaysSuccess()\n", "a.py"
    )
    assert '<BehaviorTree ID="MainTree">' in call("convert", "a.py:main").out
    assert call("check", "a.py:main").code == 0
    assert "AlwaysSuccess" in call("show", "a.py:main").out
    err = call("convert", "a.py:main", "--to", "python").err
    assert "'a.py:main' is Python, which is converted to xml only" in err


def test_a_language_that_no_conversion_writes_offers_xml_too(call, write):
    code, _, err = call("convert", write(GOOD), "--to", "yaml")
    assert (code, err) == (2, "Error: unknown conversion 'yaml'; known: python, xml\n")


def test_model_and_schema_know_all_behaviours(call):
    model = etree.fromstring(call("model", "--all").out.encode())
    names = {node.get("ID") for node in model.find("TreeNodesModel")}
    assert {"Sequence", "Hover", "Grasp"} <= names
    schema = etree.XMLSchema(etree.fromstring(call("schema").out.encode()))
    assert schema.validate(etree.fromstring(GOOD))


def test_an_unwritable_file_is_bad_input(call):
    code, _, err = call("schema", "-o", "no/such/folder/x.xsd")
    assert code == 2 and "cannot be written" in err


def test_adding_models_keeps_those_of_the_document(call, write):
    written = call("convert", "pick_place", "--to", "xml", "--model").out
    assert written.count("<TreeNodesModel>") == 1
    assert '<input_port name="attempts" default="3">' in written
    assert '<Action ID="Hover">' in written
    assert call("check", write(written)).code == 0

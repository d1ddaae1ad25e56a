"""``bt-manip tree``: check, show, format, convert, model, schema."""

from pathlib import Path

import pytest
from click.testing import CliRunner
from lxml import etree

from bt_manip import plugins
from bt_manip.cli.tree import tree
from bt_manip.exceptions import BtManipError

GOOD = """\
<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <Sequence name="s">
      <AlwaysSuccess/>
    </Sequence>
  </BehaviorTree>
</root>
"""


@pytest.fixture(scope="module")
def loaded():
    return plugins.load_plugins()


@pytest.fixture
def call(tmp_path, monkeypatch, loaded):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(plugins, "load_plugins", lambda **_: loaded)

    def call(*arguments):
        return CliRunner().invoke(
            tree, arguments, standalone_mode=False, help_option_names=["-h", "--help"]
        )

    return call


@pytest.fixture
def write(tmp_path):
    def write(text, name="tree.xml"):
        (tmp_path / name).write_text(text, encoding="utf-8")
        return name

    return write


def test_check_prints_all_findings_and_exits_with_2(call, write):
    result = call("check", write(GOOD.replace("<AlwaysSuccess/>", "<AlwaysSucess/><Script/>")))

    assert result.return_value == 2
    assert result.stdout.splitlines() == [
        "tree.xml:4:7: error: no node is named 'AlwaysSucess'; did you mean 'AlwaysSuccess' "
        "or 'AlwaysFailure'?",
        "tree.xml:4:22: error: Script needs the port 'code' of type std::string (the script)",
    ]
    assert result.stderr == "1 tree: 2 errors, 0 warnings\n"


def test_check_of_a_tree_with_warnings_or_what_the_engine_takes_is_fine(call, write):
    result = call("check", write(GOOD.replace("<Always", '<Script _x="1" code="a := 1"/><Always')))
    assert result.return_value == 0 and "warning: the attribute '_x'" in result.stdout

    name = write(GOOD.replace("<AlwaysSuccess/>", "<Repeat><AlwaysSuccess/></Repeat>"))
    assert call("check", name).return_value == 2
    assert call("check", name, "--engine").return_value == 0


def test_check_warns_of_a_goal_in_python_that_does_not_read_the_cell(call, write):
    goal = "from bt_manip.bt import *\n\ndef my_tree():\n    return Tree(AlwaysSuccess(), goal={})"
    write(goal.format("ScriptCondition(code='1==1')"), "mine.py")
    result = call("check", "mine.py:my_tree")

    assert result.return_value == 0
    assert result.stdout.startswith("mine.py:3:1: warning: goal: no condition of the goal reads")

    imported = "from bt_manip.behaviours import ObjectExists\n"
    write(imported + goal.format("ObjectExists(object='basket')"), "mine.py")
    assert call("check", "mine.py:my_tree").stdout == ""


def test_check_takes_several_trees_and_files_that_hold_only_sub_trees(call, write):
    part = '<root><BehaviorTree ID="A"><AlwaysSuccess/></BehaviorTree>'
    part += '<BehaviorTree ID="B"><AlwaysFailure/></BehaviorTree></root>'
    result = call("check", write(GOOD), write(part, "part.xml"))

    assert result.return_value == 0 and result.stderr == "2 trees: 0 errors, 2 warnings\n"
    version, choice = result.stdout.splitlines()
    assert "part.xml:1:1: warning: which tree to run?" in choice
    assert choice.endswith("'run part.xml:TREE' names one; trees that no other uses: A, B")
    assert 'no BTCPP_format="4": read as version 4; --dialect btcpp-3 reads version 3' in version


def test_a_missing_tree_offers_the_nearest(call):
    result = call("check", "pick_plac", "nothing.xml")

    assert result.return_value == 2 and result.stderr == "2 trees: 2 errors, 0 warnings\n"
    first, second = result.stdout.splitlines()
    assert first.startswith("pick_plac: error: ") and "did you mean 'pick_place'" in first
    assert second.startswith("nothing.xml: error: no tree file")


PARTS = """<root BTCPP_format="4">
<BehaviorTree ID="Main"><SubTree ID="Part"/></BehaviorTree>
<BehaviorTree ID="Part"><AlwaysSuccess/></BehaviorTree>
<BehaviorTree ID="Other"><AlwaysFailure/></BehaviorTree>
</root>"""


def test_a_tree_of_a_file_is_named_after_a_colon(call, write):
    name = write(PARTS)

    assert call("show", f"{name}:Part").output == "Part\n└─ AlwaysSuccess\n"
    assert "no tree is named 'Prt'; did you mean 'Part'" in call("check", f"{name}:Prt").stdout
    assert str(call("show", name).exception).endswith("trees that no other uses: Main, Other")
    assert "no tree file 'none.xml'" in call("check", "none.xml:Main").stdout
    assert call("convert", name, "--to", "xml").output.startswith('<root BTCPP_format="4">')


def test_show_draws_as_text_dot_and_svg_or_says_what_is_wrong(call, write):
    name = write(GOOD)

    assert call("show", name).output == ('Main\n└─ → Sequence "s"\n   └─ AlwaysSuccess\n')
    assert call("show", name, "--as", "dot").output.startswith('digraph "Main"')
    call("show", name, "--as", "svg", "-o", "tree.svg")
    assert etree.parse("tree.svg").getroot().tag.endswith("svg")
    error = call("show", write(GOOD.replace("AlwaysSuccess", "Nope"))).exception
    assert "tree.xml:4:7: error: no node is named 'Nope'" in str(error)


def test_format_writes_in_place_and_then_has_nothing_to_do(call, write, tmp_path):
    name = write(GOOD.replace("\n", "").replace("  ", " "))

    assert call("format", name, "--check").return_value == 2
    assert call("format", name).return_value == 0
    assert (tmp_path / name).read_text() == GOOD
    assert call("format", name, "--check").return_value == 0


def test_format_leaves_documents_without_trees_as_they_are(call, write, tmp_path):
    name = write("<mujoco><worldbody/></mujoco>", "robot.xml")

    error = call("format", name).exception

    assert str(error) == "robot.xml:1:1: no trees: <mujoco>, not <root>"
    assert (tmp_path / name).read_text() == "<mujoco><worldbody/></mujoco>"


def test_the_trees_that_come_with_bt_manip_have_the_standard_form(call):
    root = Path(__file__).resolve().parents[2]
    folders = root / "trees", root / "examples", *root.glob("plugins/*/bt_manip_*")
    files = [file for folder in folders for file in folder.rglob("*.xml")]
    trees = [file for file in files if "<BehaviorTree" in file.read_text()]

    assert len(trees) > 20
    assert call("format", "--check", *map(str, trees)).output == ""


def test_a_python_tree_converts_to_a_document(call, write):
    write(
        "from bt_manip.bt import AlwaysSuccess\n\ndef main():\n    return AlwaysSuccess()\n",
        "made.py",
    )

    assert '<BehaviorTree ID="MainTree">' in call("convert", "made.py:main").output
    assert call("check", "made.py:main").return_value == 0
    assert "AlwaysSuccess" in call("show", "made.py:main").output
    error = call("convert", "made.py:main", "--to", "python").exception
    assert "'made.py:main' is Python, which is converted to xml only" in str(error)


def test_a_python_tree_that_raises_is_bad_input(call, write):
    write("def broken():\n    raise ValueError('no')\n", "broken.py")

    error = call("convert", "broken.py:broken").exception
    assert isinstance(error, BtManipError) and "raised ValueError" in str(error)


def test_model_and_schema_know_all_behaviours(call, write):
    model = etree.fromstring(call("model", "--all").output.encode())
    names = {node.get("ID") for node in model.find("TreeNodesModel")}
    assert {"Sequence", "Hover", "Grasp"} <= names
    schema = etree.XMLSchema(etree.fromstring(call("schema").output.encode()))
    assert schema.validate(etree.fromstring(GOOD))


def test_an_unwritable_file_is_bad_input(call, write):
    error = call("schema", "-o", "no/such/folder/x.xsd").exception

    assert isinstance(error, BtManipError) and "cannot be written" in str(error)


def test_adding_models_keeps_those_of_the_document(call, tmp_path):
    written = call("convert", "pick_place", "--to", "xml", "--model").output
    assert written.count("<TreeNodesModel>") == 1
    assert '<input_port name="attempts" default="3">' in written
    assert '<Action ID="Hover">' in written
    (tmp_path / "copy.xml").write_text(written)
    assert call("check", str(tmp_path / "copy.xml")).return_value == 0

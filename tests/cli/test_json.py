"""``--json``: what commands print as text, as data; ``--strict`` and checks in a cell."""

import json
import re
from pathlib import Path

import pytest

from tests.support.findings import applied

REPOSITORY = Path(__file__).resolve().parents[2]

TREE = """\
<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <Fallback>
      <AlwaysSuccess/>
      <OpenGripper/>
    </Fallback>
  </BehaviorTree>
</root>
"""

DROP = """\
<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main" _goal="IsIn object={c} container=basket">
    <Sequence>
      <SpawnObject object="{c}"/>
      <Reach object="{c}"/>
      <Grasp object="{c}"/>
      <MoveToConfiguration
          configuration="home"/>
      <Drop container="bakset"/>
    </Sequence>
  </BehaviorTree>
</root>
"""


@pytest.fixture
def found(bt_manip):
    def found(*words):
        code, out, _ = bt_manip(*words, "--json")
        return code, json.loads(out)

    return found


def test_a_warning_has_its_kind_and_place(found, write):
    code, data = found("tree", "check", write(TREE))
    (finding,) = data["findings"]
    assert code == 0 and finding.pop("message").startswith("OpenGripper never runs")
    assert finding == {
        "code": "never-runs", "severity": "warning", "file": "tree.xml", "line": 5, "column": 7,
        "suggestion": {"replace": "<OpenGripper/>", "with": ""},
    }  # fmt: skip


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ('<BehaviorTree ID="Main">', '<BehaviorTree ID="Main" _skpIf="a">'),
        ("<AlwaysSuccess/>", "<AlwaysSucess/>"),
        ("<OpenGripper/>", '<Hover objct="cube"/>'),
        ("<OpenGripper/>", '<SubTree ID="Mian"/>'),
        ("<Fallback>", '<Fallback  name = "a&quot;b" >'),
        ("<OpenGripper/>", "<OpenGripper\n _skipIf='true' />"),
        ("<AlwaysSuccess/>", "<Sequence><CloseGripper/><Reach object='a &lt;'/></Sequence>"),
        ("<AlwaysSuccess/>", '<Sequence><Hover object="a"/><Grasp object="a"/></Sequence>'),
        ("<AlwaysSuccess/>", "<Timeout msec='1'><Sleep msec='500'/></Timeout>"),
        ("<AlwaysSuccess/>", '<Lift name="15" height="15"/>'),
        ("<AlwaysSuccess/>", '<Repeat num_cycles="-1"><AlwaysSuccess/></Repeat>'),
        ("<AlwaysSuccess/>", """<Sequence><Script code="a := 'home'"/><Lift/></Sequence>"""),
    ],
)
def test_an_applied_suggestion_removes_the_finding(found, write, right, wrong):
    text = TREE.replace(right, wrong)
    before = found("tree", "check", write(text))[1]["findings"]
    finding = next(one for one in before if "suggestion" in one)
    after = found("tree", "check", write(applied(text, finding)))[1]["findings"]
    assert finding["message"] not in [one["message"] for one in after]


def test_the_configuration_of_a_robot_that_is_named_later_is_no_finding(found, write):
    text = """<root BTCPP_format="4"><BehaviorTree ID="Main"><Sequence>
      <Script code="who := 'left'"/><MoveToConfiguration robot="{who}" configuration="home"/>
    </Sequence></BehaviorTree></root>"""
    assert found("tree", "check", write(text), "--scene", "two_arms") == (0, {"findings": []})


def test_names_that_the_cell_lacks_are_found_at_their_nodes(bt_manip, found, write):
    assert bt_manip("tree", "check", write(DROP)).code == 0
    code, data = found("tree", "check", write(DROP), "--scene", "table_and_basket")
    (finding,) = data["findings"]
    assert code == 2 and (finding["code"], finding["line"]) == ("not-in-the-cell", 9)
    right = applied(DROP, finding)
    assert found("tree", "check", write(right), "--robot", "panda") == (0, {"findings": []})
    home = right.replace('"home"', '"hom"')
    code, data = found("tree", "check", write(home), "--robot", "panda")
    (finding,) = data["findings"]
    assert (finding["code"], finding["line"]) == ("not-in-the-cell", 7)
    assert applied(home, finding) == right


def test_a_tree_that_places_something_without_a_goal_is_told_with_its_cell(found, write):
    text = re.sub(' _goal="[^"]*"', "", DROP.replace("bakset", "basket"))
    code, data = found("tree", "check", write(text), "--scene", "table_and_basket")
    assert [(one["code"], one["line"]) for one in data["findings"]] == [("no-goal", 9)]
    assert code == 0 and found("tree", "check", "tree.xml")[1]["findings"] == []


def test_strict_refuses_a_run_before_its_first_step(bt_manip, found, write, tmp_path):
    tree = write(TREE)
    for command in (
        ("tree", "check", tree), ("run", tree, "--report", "report.json"),
        ("evaluate", tree, "--episodes", 2),
    ):  # fmt: skip
        code, data = found(*command, "--strict")
        assert (code, [one["severity"] for one in data["findings"]]) == (2, ["error"])
    code, out, err = bt_manip("run", tree, "--strict")
    assert (code, out) == (2, "") and "tree.xml:5:7: error: OpenGripper never runs" in err
    assert [path.name for path in tmp_path.iterdir()] == ["tree.xml"]


def test_a_run_prints_the_report_that_it_writes(found, write):
    code, data = found("run", write(TREE), "--report", "report.json")
    assert code == 0 and data["report"] == json.loads(Path("report.json").read_text())
    assert [one["code"] for one in data["findings"]] == ["never-runs"]


def test_an_evaluation_warns_once_and_prints_its_episodes(bt_manip, found, write, in_this_process):
    command = ("evaluate", write(TREE), "--episodes", 3, "--workers", 2)
    assert bt_manip(*command).err.count("never runs") == 1
    code, data = found(*command)
    (measured,) = data["evaluations"]
    (point,) = measured["points"]
    assert (code, point["episodes"], point["successes"]) == (0, 3, 3)
    assert sorted(one["episode"] for one in measured["episodes"]) == [0, 1, 2]
    assert [one["code"] for one in data["findings"]] == ["never-runs"]


def test_parts_are_listed_as_in_the_text(bt_manip, found):
    lines = bt_manip("list", "planners").out.splitlines()
    parts = found("list", "planners")[1]["parts"]
    assert [one["name"] for one in parts] == [line.split()[0] for line in lines]
    (grasp,) = found("list", "Grasp")[1]["parts"]
    assert {one["name"] for one in grasp["parameters"]} > {"object", "force"}
    code, data = found("list", "nothing-like-it")
    assert code == 2 and data["findings"][0]["code"] == "error"


def test_errors_of_a_scene_have_their_lines(found, write):
    scene = write(
        '[[robots]]\nname = "arm"\n\n[[objects]]\nmodel = "cube"\nnam = "a"\n', "scene.toml"
    )
    code, data = found("scene", "check", scene)
    (finding,) = data["findings"]
    assert code == 2 and finding["file"] == "scene.toml" and finding["line"] == 6
    assert finding["suggestion"] == {"replace": "nam", "with": "name"}


def test_every_code_of_a_finding_is_documented():
    page = (REPOSITORY / "docs" / "checks.md").read_text()
    calls = re.compile(r"(?:_warn|\.warning|\.error|Problem|findings_of)\((?:[^()]|\([^()]*\))*\)")
    codes = set()
    for path in (REPOSITORY / "bt_manip").rglob("*.py"):
        if path.parts[-3:-1] == ("bt", "analysis") or "xml" in path.parts or "cli" in path.parts:
            for call in calls.findall(path.read_text()):
                codes.update(re.findall(r'"([a-z]+(?:-[a-z]+)+)"', call))
    assert len(codes) > 15
    assert [code for code in sorted(codes) if f"| `{code}` |" not in page] == []

"""What browsers get of the tree: nodes, states, breakpoints, errors of an edit."""

import pytest

from bt_manip.behaviours import RemoveObject, SpawnObject
from bt_manip.bt import AlwaysFailure, Fallback, Sequence, Sleep
from bt_manip.runner import RunObserver, RunRequest, TreeSource, prepare


def tree():
    return Sequence(
        "root", Fallback("try", AlwaysFailure("never"), Sleep("rest", msec=20)),
        SpawnObject("spawn", object="{cube}"), RemoveObject("remove", object="{cube}"),
    )  # fmt: skip


def states_of(client):
    """Return the states of the nodes by name."""
    tree = client.find("tree")
    names = {str(node["uid"]): node["name"] for node in tree["nodes"]}
    return {names[uid]: state for uid, state in tree["states"].items()}


def test_the_nodes_have_ports_statuses_messages_and_times_and_the_tree_its_end(
    make_run, page, connect
):
    make_run(tree()).execute([page])
    client = connect("page").see()
    nodes = {node["name"]: node for node in client.find("tree")["nodes"]}
    assert list(nodes) == ["root", "try", "never", "rest", "spawn", "remove"]
    (port,) = (port for port in nodes["spawn"]["ports"] if port["name"] == "object")
    assert port["text"] == "{cube}" and port["key"] == "cube"
    states = states_of(client)
    assert states["never"][:2] == ["FAILURE", "always fails"]
    assert states["spawn"][0] == "SUCCESS" and "cube" in states["spawn"][1]
    _, _, start, end = states["rest"]
    assert end - start == pytest.approx(0.02)
    assert not client.find("tree")["failed"]
    make_run(AlwaysFailure("never")).execute([page])
    assert client.see().find("tree")["failed"]


def test_only_the_states_that_have_changed_are_sent(make_run, page, connect):
    client = connect("page").see()

    class Look(RunObserver):
        def after_tick(self):
            page.refresh(now=True)

    make_run(tree()).execute([page, Look()])
    sent = client.read()
    merged = [change[3] for change in sent if change[0] == "merge" and change[2] == "states"]
    assert len(merged) >= 2 and len(merged[-1]) < 6


def test_breakpoints_are_set_and_removed_in_the_margin_and_kept_for_the_next_run(
    make_run, page, connect
):
    make_run(tree()).execute([page])
    client = connect("page").see()
    margin = client.uid("tree")
    for path in ("spawn", "rest", "no such path", 5, None):
        client.send(margin, "breakpoint", path)
    assert page.controls.breakpoints == {"spawn", "rest"}
    page.refresh(now=True)
    assert client.see().find("tree")["breakpoints"] == ["rest", "spawn"]
    client.send(margin, "breakpoint", "spawn")
    assert page.controls.breakpoints == {"rest"}
    page.show_prepared(make_run(tree()))
    assert connect("page").see().find("tree")["breakpoints"] == ["rest"]


CHECKED = """<root BTCPP_format="4"><BehaviorTree ID="Main"><Sequence>
  <Sleep name="rest" msec="30"/>
  <Sleep name="never" _skipIf="true" msec="1"/>
</Sequence></BehaviorTree></root>"""


def findings_of(client):
    """Return the findings of the nodes by name."""
    tree = client.see().find("tree")
    names = {str(node["uid"]): node["name"] for node in tree["nodes"]}
    return {names[uid]: [tuple(one) for one in found] for uid, found in tree["findings"].items()}


def prepared(path, parts, text=CHECKED, **station):
    path.write_text(text)
    return prepare(RunRequest(TreeSource("task", "xml", path=path)), parts, **station)


def test_warnings_are_shown_at_their_nodes_before_a_run_and_in_it(page, connect, parts, tmp_path):
    run = prepared(tmp_path / "task.xml", parts)
    client = connect("page")
    page.begin_idle(run.station)
    page.show_prepared(run)
    shown = findings_of(client)
    assert client.find("status")["text"] == "0.00 s: ready"
    ((severity, text),) = shown["never"]
    assert severity == "warning" and text.startswith("Sleep never runs") and len(shown) == 1
    run.execute([page])
    assert findings_of(client) == shown
    text = CHECKED.replace("true", "false")
    page.show_prepared(prepared(tmp_path / "task.xml", parts, text, station=run.station))
    assert findings_of(client) == {}


@pytest.mark.parametrize("above", ["", "<!-- its lines are not those of the nodes -->\n"])
def test_an_error_of_an_edit_is_shown_until_it_is_gone_and_at_its_node_unless_lines_moved(
    page, connect, parts, tmp_path, above
):
    path, seen = tmp_path / "task.xml", []
    run, client = prepared(path, parts), connect("page")
    problem = f"{path}:{3 if above else 2}:28: error: port 'msec': 'x' is not an integer"

    class Editor(RunObserver):
        def run_started(self, run):
            self.emit = run.events.emit

        def after_tick(self):
            path.write_text(above + CHECKED.replace('msec="30"', 'msec="x"'))
            self.emit("edit", {"problems": [] if seen else [problem]})
            page.refresh(now=True)
            found = findings_of(client)
            severities = {name: [severity for severity, _ in some] for name, some in found.items()}
            seen.append((severities, client.find("tree")["problems"]))

    run.execute([page, Editor()])
    warned = {"never": ["warning"]}
    assert seen[0] == (warned | ({} if above else {"rest": ["error"]}), [problem])
    assert seen[1] == (warned, [])


def test_a_tree_with_errors_is_shown_by_them(make_run, page, connect):
    page.begin_idle(make_run(Sleep(msec=20)).station)
    page.show_errors("task", ["task.xml:3:7: error: unknown node '<Slep>'"])
    tree = connect("page").see().find("tree")
    assert (tree["nodes"], tree["problems"]) == ([], ["task.xml:3:7: error: unknown node '<Slep>'"])


def test_states_are_kept_until_there_is_a_new_cell(make_run, page, connect):
    run = make_run(tree())
    run.execute([page])
    client = connect("page")
    page.begin_idle(run.station)
    assert states_of(client.see())["never"][0] == "FAILURE"
    page.begin_idle(make_run(tree()).station)
    assert states_of(client.see()) == {} and client.find("tree")["nodes"]
    assert client.find("blackboard")["values"] == {}

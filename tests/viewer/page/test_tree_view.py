"""The tree as HTML: sub-trees are folded, and what runs is followed."""

import pytest

from bt_manip.runner import RunEvent
from bt_manip.viewer.page.tree_view import LINES_ABOVE, SHOWN_NODES, TreeView


def node(uid, name, parent, kind="Action"):
    return {
        "uid": uid, "path": name, "name": name, "kind": kind, "registration": "Node",
        "parent": parent, "ports": [],
    }  # fmt: skip


def tree_of(groups: int, leaves: int = 3) -> list[dict]:
    """Return a root with groups of leaves: group 0 has leaf 0.0, leaf 0.1, ..."""
    nodes = [node(1, "root", 0, "Control")]
    for i in range(groups):
        group = node(len(nodes) + 1, f"group {i}", 1, "Control")
        nodes.append(group)
        for j in range(leaves):
            nodes.append(node(len(nodes) + 1, f"leaf {i}.{j}", group["uid"]))
    return nodes


@pytest.fixture
def view():
    view = TreeView()
    view.handle(RunEvent(0.0, "tree", {"nodes": tree_of(30)}))
    return view


def uid_of(view, name):
    return next(uid for uid, node in view.nodes.items() if node["name"] == name)


def change(view, name, status, old="IDLE", reason=""):
    data = {"uid": uid_of(view, name), "old": old, "status": status, "reason": reason}
    return view.handle(RunEvent(0.0, "status", data))


def run(view, *names):
    """Let nodes run, children before their parents."""
    for name in names:
        change(view, name, "RUNNING")


def shown(view, *names):
    html = view.html()
    return [f">{name}</span>" in html for name in names]


def test_a_small_tree_is_shown_whole():
    view = TreeView()
    view.handle(RunEvent(0.0, "tree", {"nodes": tree_of(2)}))
    assert all(shown(view, "root", "group 0", "leaf 0.2", "group 1", "leaf 1.0"))


def test_a_large_tree_is_open_where_it_runs_and_folds_behind_it(view):
    assert shown(view, "root", "group 0", "leaf 0.0") == [True, False, False]
    run(view, "leaf 0.1", "group 0", "root")
    assert shown(view, "leaf 0.0", "leaf 0.1", "leaf 1.0") == [True, True, False]
    for name in ("leaf 0.1", "group 0"):
        change(view, name, "SUCCESS", "RUNNING")
    run(view, "leaf 1.0", "group 1")
    assert shown(view, "leaf 0.1", "group 0", "leaf 1.0") == [False, True, True]


def test_a_failure_is_open_until_it_is_overcome(view):
    run(view, "leaf 2.0", "group 2", "root")
    change(view, "leaf 2.0", "FAILURE", "RUNNING", reason="<too> far")
    assert "&lt;too&gt; far" in view.html()
    change(view, "group 2", "SUCCESS", "RUNNING")
    assert shown(view, "group 2", "leaf 2.0") == [True, False]


def test_the_choice_of_the_user_survives_updates_and_edits(view):
    run(view, "leaf 0.0", "group 0", "root")
    view.folds |= {"group 0": True, "group 5": False}
    for _ in range(2):
        assert shown(view, "leaf 0.0", "leaf 5.0", "leaf 6.0") == [False, True, False]
        change(view, "leaf 0.1", "RUNNING")
        view.handle(RunEvent(0.0, "tree", {"nodes": tree_of(30)}))
        run(view, "leaf 0.0", "group 0", "root")


def test_without_following_the_open_part_stays(view):
    run(view, "leaf 0.0", "group 0", "root")
    view.html()
    view.follow = False
    change(view, "leaf 0.0", "IDLE", "RUNNING")
    change(view, "group 0", "IDLE", "RUNNING")
    run(view, "leaf 1.0", "group 1")
    assert shown(view, "leaf 0.0", "leaf 1.0") == [True, False]


def test_what_runs_is_near_the_top_below_its_ancestors():
    view = TreeView()
    view.handle(RunEvent(0.0, "tree", {"nodes": tree_of(1, 500)}))
    run(view, "leaf 0.400", "group 0", "root")
    lines = view.html().split("<div")
    line = next(i for i, line in enumerate(lines) if ">leaf 0.400<" in line)
    assert line <= LINES_ABOVE + 5 and len(lines) < SHOWN_NODES + 10
    assert shown(view, "root", "group 0", "leaf 0.0") == [True, True, False]
    assert "⋮ 392 lines" in view.html() and "⋮ 8 lines" in view.html()


def test_the_search_shows_nodes_with_their_ancestors(view):
    view.search = "LEAF 7.1"
    assert shown(view, "root", "group 7", "leaf 7.1", "leaf 7.2", "group 8") == [
        True, True, True, False, False
    ]  # fmt: skip


def test_the_last_status_is_kept_when_a_parent_resets_its_children(view):
    view.folds["group 0"] = False
    run(view, "leaf 0.0", "root")
    change(view, "leaf 0.0", "SUCCESS", "RUNNING")
    assert not change(view, "leaf 0.0", "IDLE", "SUCCESS")
    assert "✓" in view.html()
    view.handle(RunEvent(0.0, "cycle", {"cycle": 1, "status": "RUNNING", "reason": ""}))
    assert "✓" not in view.html()


def test_the_latest_leaf_of_a_status_is_found(view):
    assert view.latest("RUNNING") == ""
    run(view, "leaf 0.0", "leaf 0.1", "group 0", "root")
    change(view, "leaf 0.0", "FAILURE", "RUNNING")
    assert (view.latest("RUNNING"), view.latest("FAILURE")) == ("leaf 0.1", "leaf 0.0")

"""Results that a tree declares are on the page, in each cycle."""

import re

from bt_manip.bt import Script, Sequence, Sleep


def table_of(client):
    (content,) = (
        one["content"]
        for one in client.see().elements.values()
        if one["kind"] == "html" and "<th>results</th>" in one["content"]
    )
    rows = re.findall("<tr>(.*?)</tr>", content)
    return [re.findall("<t[hd]>(.*?)</t[hd]>", row) for row in rows]


def test_each_cycle_has_its_results_the_present_one_first(make_run, page, connect):
    root = Sequence("root", Script(code="left := 2; none := 1"), Sleep(msec=30))
    run = make_run(root, cycles=2)
    run.tree.results = ("left", "right <b>")
    run.execute([page])
    page.refresh(now=True)
    assert table_of(connect("page")) == [
        ["results", "left", "right &lt;b&gt;"],
        ["cycle 2 SUCCESS", "2", "-"],
        ["cycle 1 SUCCESS", "2", "-"],
    ]


def test_a_tree_without_results_has_no_table(make_run, page, connect):
    make_run(Sleep(msec=20)).execute([page])
    tables = [one for one in connect("page").see().elements.values() if one["kind"] == "html"]
    assert not any("results" in one["content"] and one["visible"] for one in tables)

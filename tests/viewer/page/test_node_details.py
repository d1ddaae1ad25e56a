"""The details of a node: its ports with their present values."""

from bt_manip.runner import RunEvent
from bt_manip.viewer.page.node_details import SHOWN_CHARACTERS, details_html, keep_value

NODE = {
    "path": "pick/<lift>", "kind": "Action", "registration": "Lift",
    "ports": [
        {"name": "object", "direction": "input", "text": "{target}", "key": "pick/target"},
        {"name": "height", "direction": "input", "text": "0.1", "key": ""},
    ],
}  # fmt: skip


def write(values, key, value):
    data = {"key": key, "value": value, "type": "string"}
    return keep_value(values, RunEvent(0.0, "blackboard", data))


def test_path_kind_status_and_reason_are_escaped():
    html = details_html(NODE, "FAILURE", "x < y", {})
    assert "pick/&lt;lift&gt;" in html and "Action Lift, failure" in html and "x &lt; y" in html


def test_a_port_has_its_text_and_the_value_behind_its_key():
    values = {}
    assert "pick/target = (not set)" in details_html(NODE, "IDLE", "", values)
    assert write(values, "pick/target", "<cube>")
    html = details_html(NODE, "IDLE", "", values)
    assert "<td>{target}<div>pick/target = &lt;cube&gt;</div></td>" in html
    assert "<td>0.1</td>" in html
    write(values, "pick/target", None)
    assert "(not set)" in details_html(NODE, "IDLE", "", values)


def test_a_long_value_is_cut():
    values = {}
    write(values, "pick/target", "a" * 10_000)
    assert "a" * SHOWN_CHARACTERS + "…" in details_html(NODE, "IDLE", "", values)
    assert len(details_html(NODE, "IDLE", "", values)) < 2_000


def test_other_events_change_nothing():
    values = {"pick/target": "cube"}
    assert not keep_value(values, RunEvent(0.0, "tick", {"tick": 1}))
    assert values == {"pick/target": "cube"}

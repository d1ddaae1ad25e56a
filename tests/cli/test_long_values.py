"""Values in messages are cut, however long what a user wrote is: each line can be read."""

import json

import pytest

from bt_manip.exceptions import did_you_mean

WORD = "x" * 5000
SENTENCE = "x y " * 1250
LONGEST = 300
"""Characters of a line [1]."""


@pytest.fixture
def short(bt_manip, tmp_path, monkeypatch):
    """Run a command that fails; check its lines, and return its exit code."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        code, out, err = bt_manip(*arguments)
        assert "Traceback" not in err
        assert max(map(len, (out + err).splitlines())) < LONGEST
        return code

    return run


@pytest.mark.parametrize("text", [WORD, SENTENCE], ids=["word", "sentence"])
@pytest.mark.parametrize(
    "options",
    [
        "{}",
        "run {}",
        "run quick --{}",
        "run quick --scene {}",
        "run quick --robot {}",
        "run quick --set {}=1",
        "run quick --seed {}",
        "run quick --fault {}",
        "run quick --report {}",
        "run quick --record {}",
        "sweep pick_place --vary {}=1,2",
        "report {}",
        "export {}",
        "tree check {}",
        "scene check {}",
    ],
)
def test_a_long_option_is_cut(short, trees, options, text):
    words = [word.format(text) for word in options.split()]
    assert short(*(f"{trees}:quick" if word == "quick" else word for word in words)) in (1, 2)


@pytest.mark.parametrize(
    ("node", "goal", "code"),
    [
        ("<AlwaysSuccess/>", f"{WORD} object=cube", 2),
        ("<AlwaysSuccess/>", f"IsIn {WORD}=cube", 2),
        ("<AlwaysSuccess/>", f"IsIn object={WORD} container=basket", 2),
        (f'<MoveToConfiguration configuration="{WORD}"/>', "", 2),
        (f'<Hover object="{SENTENCE}"/>', "", 2),
        (f'<Hover object="cube" {WORD}="1"/>', "", 2),
        (f'<Sleep msec="{WORD}"/>', "", 2),
        (f'<Sleep msec="{{{WORD}}}"/>', "", 1),
        (f"<{WORD}/>", "", 2),
        (f'<SubTree ID="{WORD}"/>', "", 2),
        (f'<Script code="a:={WORD}"/>', "", 1),
    ],
)
def test_a_long_value_in_a_tree_is_cut(short, task, tmp_path, node, goal, code):
    task(node, goal and f'_goal="{goal}"')
    assert short("run", "task.xml", "--report", "report.json") == code
    if code == 1:
        (cycle,) = json.loads((tmp_path / "report.json").read_text())["cycles"]
        assert max(len(cycle["reason"]), len(cycle["goal_reason"])) < LONGEST


def test_of_many_choices_some_are_listed():
    text = did_you_mean("nothing", [f"leaf {i}" for i in range(100, 200)])
    assert text.startswith("; known: leaf 100, leaf 101, ") and text.endswith(" more")
    assert did_you_mean("nothing", ["one", "two"]) == "; known: one, two"

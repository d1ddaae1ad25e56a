"""Where trees come from, and the keys that they let one set: good ones, and every bad one."""

import pytest

from bt_manip.exceptions import BtManipError
from bt_manip.runner import RunRequest, TreeSource, find_tree, prepare, prepare_station

DOCUMENT = """<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <Sequence>
      <Script code="seen := note"/>
      <MoveHome speed="{speed}"/>
      <SubTree ID="Inner" pause="{pause}"/>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="Inner"><Sleep msec="{pause}"/></BehaviorTree>
  <TreeNodesModel>
    <SubTree ID="Main">
      <input_port name="speed" default="0.5">Fraction of the limits</input_port>
      <input_port name="note" default="calm"/>
      <input_port name="pause"/>
    </SubTree>
  </TreeNodesModel>
</root>
"""

PYTHON = """
from bt_manip.bt import Sleep

def tree(msec: int, note: str = "calm", loud: bool = False, factor: float = 1.0):
    made = Sleep(note, msec=int(msec * factor))
    made.loud = loud
    return made

def wrong():
    return Sleep(mseconds=1)
"""


@pytest.fixture
def document(tmp_path):
    path = tmp_path / "task.xml"
    path.write_text(DOCUMENT)
    return path


@pytest.fixture
def python(tmp_path):
    path = tmp_path / "task.py"
    path.write_text(PYTHON)
    return path


def prepared(parts, tree, warn=lambda message: None, **settings):
    return prepare(RunRequest(find_tree(str(tree), {}), settings=settings), parts, warn)


def test_keys_have_their_defaults_unless_they_are_set(parts, document):
    board = prepared(parts, document, pause="20").tree.blackboard
    assert (board["speed"], board["note"], board["pause"]) == (0.5, "calm", 20)
    board = prepared(parts, document, pause="20", speed="1", note="wild").tree.blackboard
    assert (board["speed"], board["note"]) == (1.0, "wild")


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({}, "needs --set pause=VALUE"),
        ({"pause": "20", "sped": "1"}, "has no key 'sped'; did you mean 'speed'"),
        ({"pause": "20", "speed": "fast"}, "--set speed: expected a number, got 'fast'"),
        ({"pause": "soon"}, "--set pause: expected a whole number from 0 to 4294967295, got 's"),
        ({"pause": "2.5"}, "--set pause: expected a whole number from .*, got '2.5'"),
    ],
)
def test_a_setting_that_does_not_fit_the_document_is_refused(parts, document, settings, message):
    with pytest.raises(BtManipError, match=message):
        prepared(parts, document, **settings)


def test_what_is_strange_in_a_document_is_a_warning(parts, task):
    path = task('<MoveHome _skipIff="true"/>')
    with pytest.raises(BtManipError, match="has no key 'speed'"):
        prepared(parts, path, speed="1")
    warnings = []
    prepared(parts, path, warnings.append)
    assert len(warnings) == 1 and "task.xml:3:" in warnings[0] and "_skipIff" in warnings[0]


def test_arguments_are_read_as_their_annotations_say(parts, python):
    tree = prepared(parts, f"{python}:tree", msec="20", note="wild", loud="true", factor="0.5").tree
    assert tree.root.name == "wild" and tree.root.loud is True
    assert tree.root.msec == 10


@pytest.mark.parametrize(
    ("function", "settings", "message"),
    [
        ("tree", {}, "needs --set msec=VALUE"),
        ("tree", {"msec": "1", "nota": "x"}, "has no key 'nota'; did you mean 'note'"),
        ("tree", {"msec": "1.5"}, "--set msec: expected a whole number, got '1.5'"),
        ("tree", {"msec": "1", "factor": "x"}, "--set factor: expected a number, got 'x'"),
        ("tree", {"msec": "1", "loud": "x"}, "--set loud: expected true or false, got 'x'"),
        ("treee", {}, "no function or tree 'treee'; did you mean 'tree'"),
        ("wrong", {}, "cannot be made: Sleep has no port 'mseconds'; did you mean 'msec'"),
    ],
)
def test_a_function_that_does_not_fit_is_refused(parts, python, function, settings, message):
    with pytest.raises(BtManipError, match=message):
        prepared(parts, f"{python}:{function}", **settings)


@pytest.mark.parametrize("made", ["Sleep(msec=10)", "Tree(Sleep(msec=10))"])
def test_a_behaviour_or_a_tree_is_run_as_it_is(parts, tmp_path, made):
    path = tmp_path / "task.py"
    path.write_text(f"from bt_manip.bt import Sleep, Tree\nnap = {made}\n")
    assert prepared(parts, f"{path}:nap").tree.root.msec == 10
    with pytest.raises(BtManipError, match="has no key 'msec'"):
        prepared(parts, f"{path}:nap", msec="1")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x = 1\ndef tree(:\n", r"is no Python: task\.py:2"),
        ("import no_such_thing\n", r"ModuleNotFoundError at .*task\.py:1: .*no_such_thing"),
    ],
)
def test_a_file_that_cannot_be_imported_is_refused_with_its_line(parts, tmp_path, text, message):
    path = tmp_path / "task.py"
    path.write_text(text)
    with pytest.raises(BtManipError, match=message):
        prepared(parts, f"{path}:tree")


def test_a_module_that_is_not_there_is_told_as_such(parts):
    with pytest.raises(BtManipError, match="there is no module 'no_such.place'"):
        prepared(parts, "no_such.place:tree")


def test_a_tree_of_an_installed_module_is_found(parts):
    source = TreeSource("x", "python", module="bt_manip.bt", function="AlwaysSuccess")
    assert prepare(RunRequest(source), parts).tree.root.name == "AlwaysSuccess"


def test_a_run_continues_in_the_given_station(parts, tmp_path):
    path, above = tmp_path / "task.py", (0.3, -0.7, 0.1, -2.2, 0.0, 1.6, 0.8)
    path.write_text(
        "from bt_manip.behaviours import MoveToConfiguration\n"
        'move = MoveToConfiguration(configuration="above")\n'
    )
    request = RunRequest(find_tree(f"{path}:move", {}), configurations={"above": above})
    station = prepare_station(request, parts)
    prepare(request, parts, station=station).execute()
    first = station.cell.time
    assert station.arm.q == pytest.approx(above)
    again = prepare(request, parts, station=station)
    again.execute()
    assert again.station is station
    assert first < station.cell.time < first + 0.1  # the arm is there already


def test_a_users_tree_py_does_not_shadow_modules_of_others(parts, tmp_path):
    path = tmp_path / "tree.py"
    path.write_text(PYTHON)
    prepared(parts, f"{path}:tree", msec="1")
    import tree

    assert hasattr(tree, "map_structure")  # dm-tree's

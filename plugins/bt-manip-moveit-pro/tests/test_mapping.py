"""Leaves and sub-trees of others that our behaviours stand for."""

import pytest

from bt_manip.bt import Action, BehaviourRegistry, Input, Status, read_tree
from bt_manip.exceptions import TreeError
from bt_manip_moveit_pro.dialect import MOVEIT_PRO
from bt_manip_moveit_pro.mapping import LeafMapping

MAPPING = """\
["Move to Waypoint"]
node = "Go"
ports = { to = "waypoint_name" }

[[MoveGripperAction]]
when = "position < 0.1"
node = "Open"

[[MoveGripperAction]]
when = "position > 0.5"
node = "Close"
set = { force = 40, gently = true }
"""
TREE = """\
<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <Control ID="Sequence">
      <SubTree ID="Move to Waypoint" waypoint_name="Above" group="arm" _collapsed="true"/>
      <Action ID="MoveGripperAction" name="grip" position="{}" topic="/x" _skipIf="false"/>
    </Control>
  </BehaviorTree>
</root>
"""


class Noting(Action):
    """Note what was given."""

    def update(self):
        given = {name: self.read_port(name) for name in self.ports}
        NOTES.append((self.registration, self.name, given))
        return Status.SUCCESS


class Go(Noting):
    to = Input(str)


class Open(Noting):
    """Open."""


class Close(Noting):
    force = Input(float)
    gently = Input(bool)


NOTES = []


@pytest.fixture
def read(tmp_path):
    NOTES.clear()
    registry = BehaviourRegistry([Go, Open, Close])
    registry.register_dialect(MOVEIT_PRO)

    def read(position, mapping=MAPPING, **options):
        (tmp_path / "mapping.toml").write_text(mapping)
        (tmp_path / "tree.xml").write_text(TREE.format(position))
        return read_tree(
            tmp_path / "tree.xml",
            registry,
            dialect="auto",
            mapping=LeafMapping.read(tmp_path / "mapping.toml"),
            **options,
        )

    return read


def test_leaves_and_sub_trees_become_behaviours_with_their_ports(read):
    tree = read("0.79").usable_tree()
    tree.tick()
    assert NOTES == [
        ("Go", "Go", {"to": "Above"}),
        ("Close", "grip", {"force": 40.0, "gently": True}),
    ]
    read("0").usable_tree().tick()
    assert NOTES[-1] == ("Open", "grip", {})


@pytest.mark.parametrize(("opening", "expected"), [(0.0, "Open"), (0.9, "Close")])
def test_a_rule_over_an_entry_chooses_at_the_tick(read, opening, expected):
    entries = {"opening": opening}
    assert "no rule holds" in str(read("{opening}", blackboard=entries).errors[0])
    last = MAPPING.replace('when = "position > 0.5"\n', "")  # which always holds
    read("{opening}", last, blackboard=entries).usable_tree().tick()
    assert NOTES[-1][0] == expected


def test_a_leaf_that_no_rule_holds_for_is_an_error_at_its_place(read):
    (error,) = [e for e in read("0.3").errors if "no rule" in str(e)]
    assert error.place.line == 5
    assert "MoveGripperAction: no rule holds for position=0.3, topic=/x" in str(error)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[A]\nwhen = 'x'", "'node' is missing"),
        ("[A]\nnode = 'Go'\nport = {}", "'port' means nothing; did you mean 'ports'"),
        ("[A]\nnode = 'Go'\nwhen = 'x <'", "when: "),
        ("[A]\nnode = 'Go'\nports = { a = 1 }", "table of names of ports"),
        ("[A", "mapping.toml: "),
    ],
)
def test_a_wrong_mapping_is_refused(tmp_path, text, message):
    path = tmp_path / "mapping.toml"
    path.write_text(text)
    with pytest.raises(TreeError, match=message):
        LeafMapping.read(path)

"""What is read as version 3, and what its constructs mean; the traces are those of the engine."""

import sys

import pytest

from bt_manip.bt import read_tree
from bt_manip.exceptions import TreeError
from bt_manip_btcpp3 import BTCPP3

from .engine import converted, leaves, run

ROOT = '<root main_tree_to_execute="Main"><BehaviorTree ID="Main">{}</BehaviorTree>{}</root>'


def tree(body, *inner):
    rest = "".join(
        f'<BehaviorTree ID="In{i or ""}">{text}</BehaviorTree>' for i, text in enumerate(inner)
    )
    return ROOT.format(body, rest)


def leaf(name, outcomes, kind="Scripted"):
    return f'<{kind} name="{name}" outcomes="{",".join(outcomes)}"/>'


def old_parallel(attributes):
    return f"<Parallel {attributes}>{leaf('a', 'S')}{leaf('b', 'F')}{leaf('c', 'RS')}</Parallel>"


def read(path, xml, **options):
    path.write_text(xml)
    return read_tree(path, leaves()[0], **{"dialect": "auto", **options})


@pytest.mark.parametrize(
    ("body", "inner", "trace"),
    [
        pytest.param(
            f"<FallbackStar>{leaf('a', 'F')}{leaf('b', 'RS')}</FallbackStar>", [],
            ["R asF bsR", "S brS"], id="FallbackStar",
        ),
        pytest.param(
            f'<RetryUntilSuccesful num_attempts="2">{leaf("a", "FS")}</RetryUntilSuccesful>', [],
            ["S asF asS"], id="RetryUntilSuccesful",
        ),
        pytest.param(old_parallel('threshold="2"'), [], ["R asS bsF csR", "S crS"], id="threshold"),
        pytest.param(
            old_parallel('success_threshold="2"'), [], ["F asS bsF"], id="failure_threshold=1"
        ),
        pytest.param(
            '<Sequence><Put name="p" value="v" out="{x}"/><SubTree ID="In" y="x"/></Sequence>',
            ['<Say name="s" msg="{y}"/>'], ["S pw1 smv"], id="an unbraced port is an entry",
        ),
        pytest.param(
            '<Sequence><Put name="p" value="v" out="{x}"/><SubTree ID="In" y="{x}"/></Sequence>',
            ['<Say name="s" msg="{y}"/>'], ["S pw1 sm?"], id="braces are part of the name",
        ),
        pytest.param(
            '<Sequence><Put name="p" value="v" out="{x}"/><SubTree ID="In"/></Sequence>',
            ['<Say name="s" msg="{x}"/>'], ["S pw1 sm?"], id="a blackboard of its own",
        ),
        pytest.param(
            '<Sequence><SubTreePlus ID="In" __autoremap="1" x="t"/><Say name="s" msg="{x}"/>'
            "</Sequence>", ["<AlwaysSuccess/>"], ["S smt"], id="a constant after __autoremap",
        ),
        pytest.param(
            '<Action ID="In" y="x"/>', [leaf("a", "S")], ["S asS"], id="a tree as an action"
        ),
    ],
)  # fmt: skip
def test_a_construct_of_version_3_has_its_meaning(body, inner, trace):
    assert run(tree(body, *inner), len(trace)) == trace


def test_converted_python_can_import_each_node():
    for name, cls in BTCPP3.nodes.items():
        assert getattr(sys.modules[cls.__module__], name) is cls


TRAITS = [
    '<Control ID="SequenceStar"><AlwaysSuccess/></Control>',
    '<SubTree ID="In" x="y"/>',
    '<SubTree ID="In" __shared_blackboard="false"/>',
    '<SubTreePlus ID="In"/>',
    '<Parallel success_threshold="1"><AlwaysSuccess/></Parallel>',
    '<RetryUntilSuccesful num_attempts="1"><AlwaysSuccess/></RetryUntilSuccesful>',
]


@pytest.mark.parametrize("body", TRAITS)
def test_a_document_with_a_trait_of_version_3_says_once_what_it_is_and_what_to_do(tmp_path, body):
    reading = read(
        tmp_path / "t.xml", tree(f"<Sequence>{body}{body}</Sequence>", "<AlwaysSuccess/>")
    )
    (warning,) = [p for p in reading.problems if "BehaviorTree.CPP 3" in p.message]
    assert not reading.errors and "tree convert --to xml" in warning.message
    quiet = read(tmp_path / "t.xml", tree(body, "<AlwaysSuccess/>"), dialect="btcpp-3")
    assert not any("version 3" in p.message or "CPP 3" in p.message for p in quiet.problems)


@pytest.mark.parametrize(
    "xml",
    [
        tree('<SubTree ID="In" x="y" _skipIf="false"/>', "<AlwaysSuccess/>"),
        tree('<SubTree ID="In" x="y" _autoremap="true"/>', "<AlwaysSuccess/>"),
        tree('<SubTree ID="In" x="{y}"/>', "<AlwaysSuccess/>"),
        tree(TRAITS[1], "<AlwaysSuccess/>").replace("<root", '<root BTCPP_format="4"'),
    ],
)
def test_others_are_not_taken_for_it(tmp_path, xml):
    assert read(tmp_path / "t.xml", xml).dialect.name == "btcpp"


def test_a_file_of_version_4_is_not_read_as_version_3(tmp_path):
    xml = tree("<AlwaysSuccess/>").replace("<root", '<root BTCPP_format="4"')
    with pytest.raises(TreeError, match="this file is of version 4"):
        read(tmp_path / "t.xml", xml, dialect="btcpp-3").usable_tree()


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ('<Scripted outcomes="S" _successIf="S"/>', "3:24: error: '_successIf' is no port"),
        ('<SubTree ID="In" _k="x"/>', "'_k' cannot be the key of a sub-tree in version 4"),
        ("<Parallel><AlwaysSuccess/></Parallel>", "Parallel needs the port 'success_threshold'"),
        ("<WhileDoElse><AlwaysSuccess/><AlwaysSuccess/></WhileDoElse>", "WhileDoElse has 3"),
    ],
)
def test_what_has_no_meaning_is_an_error_at_its_line(tmp_path, body, message):
    xml = ROOT.format(f"\n\n{body}", '<BehaviorTree ID="In"><AlwaysSuccess/></BehaviorTree>')
    errors = "\n".join(map(str, read(tmp_path / "t.xml", xml, dialect="btcpp-3").errors))
    assert message in errors and "t.xml:3:" in errors


OLD = """\
<root main_tree_to_execute="Main">
  <!-- what it does -->
  <BehaviorTree ID="Main">
    <SequenceStar name="top">
      <!-- first -->
      <SetBlackboard output_key="x" value="shelf"/>
      <Parallel threshold="1">
        <SubTreePlus ID="In" y="{x}" __autoremap="true"/>
        <SubTree ID="In" y="x"/>
      </Parallel>
      <SubTree ID="In" __shared_blackboard="true"/>
    </SequenceStar>
  </BehaviorTree>
  <BehaviorTree ID="In">
    <AlwaysSuccess/>
  </BehaviorTree>
  <TreeNodesModel>
    <SubTree ID="In">
      <input_port name="__shared_blackboard" default="false"/>
    </SubTree>
  </TreeNodesModel>
</root>
"""
NEW = """\
<root BTCPP_format="4" main_tree_to_execute="Main">
  <!-- what it does -->
  <BehaviorTree ID="Main">
    <SequenceWithMemory name="top">
      <!-- first -->
      <SetBlackboard output_key="x" value="shelf"/>
      <Parallel success_count="1" failure_count="2">
        <SubTree ID="In" y="{x}" _autoremap="true"/>
        <SubTree ID="In" y="{x}"/>
      </Parallel>
      <SubTree ID="In" _autoremap="true"/>
    </SequenceWithMemory>
  </BehaviorTree>
  <BehaviorTree ID="In">
    <AlwaysSuccess/>
  </BehaviorTree>
  <TreeNodesModel>
    <SubTree ID="In"/>
  </TreeNodesModel>
</root>
"""


def test_a_conversion_keeps_comments_and_order(tmp_path):
    text, problems = converted(tmp_path / "old.xml", OLD)
    assert text == NEW
    assert [str(p).partition(": warning: ")[2][:32] for p in problems] == [
        "version 3 counts the children in"
    ]


@pytest.mark.parametrize(
    ("body", "inner", "message"),
    [
        ('<SubTree ID="In" __shared_blackboard="1"/>', '<Say msg="{_k}"/>', "starts with '_'"),
        ('<Parallel threshold="{n}"><AlwaysSuccess/></Parallel>', "", "cannot derive"),
        ('<SubTreePlus ID="In" __autoremap="1" x="t"/>', "<AlwaysSuccess/>", "put '__autoremap'"),
        ('<Parallel success_threshold="0"><AlwaysSuccess/></Parallel>', "", "threshold of 0"),
    ],
)
def test_a_conversion_refuses_what_version_4_cannot_say(tmp_path, body, inner, message):
    _, problems = converted(tmp_path / "old.xml", tree(body, inner or "<AlwaysSuccess/>"))
    assert any(p.is_error and message in p.message for p in problems)


def test_checks_become_preconditions(tmp_path):
    body = (
        '<BlackboardCheckString value_A="{x}" value_B="v" return_on_mismatch="SUCCESS">'
        "<AlwaysSuccess/></BlackboardCheckString>"
    )
    text, (problem,) = converted(tmp_path / "old.xml", tree(body))
    assert """<Precondition if="x == 'v'" else="SUCCESS">""" in text and not problem.is_error

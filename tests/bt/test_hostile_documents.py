"""Documents made to hurt get an error, never a crash or a hang."""

import time

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bt_manip.bt import Action, BehaviourRegistry, Input
from bt_manip.bt.loading import read_tree_text
from bt_manip.exceptions import BtManipError
from tests.support.corpus_leaves import corpus_registry

SEEDS = [
    '<root BTCPP_format="4" main_tree_to_execute="Main"><BehaviorTree ID="Main"><Sequence name="s">'
    '<Script code="x := 1; y := \'a\' .. x"/><SubTree ID="Sub" name="q" p="{x}" c="5" '
    '_autoremap="1"/><Repeat num_cycles="2" _skipIf="x &gt; 3" _post="x += 1"><SetOutInt '
    'value="3" out="{z}"/></Repeat></Sequence></BehaviorTree><BehaviorTree ID="Sub"><Fallback>'
    '<LoopInt queue="1;2" value="{p}" if_empty="FAILURE"><CheckInInt in="{p}" expected="2"/>'
    '</LoopInt><Switch2 variable="{c}" case_1="RED" case_2="5"><AlwaysSuccess/><AlwaysFailure/>'
    '<Sleep msec="10"/></Switch2></Fallback></BehaviorTree><TreeNodesModel><SubTree ID="Sub">'
    '<input_port name="p" default="1"/></SubTree></TreeNodesModel></root>',
    '<?xml version="1.0"?>\n<!-- c --><root>\n<BehaviorTree ID="A"><Action ID="Scripted" '
    'outcomes="S,F" _while="true"/></BehaviorTree>\n<include path="no.xml"/></root>',
]
PIECES = [
    "<", ">", "/>", "</", '"', "'", "&", "&amp;", "&#0;", "&#xD800;", "&#99999999;", "<!--", "-->",
    "<![CDATA[", "]]>", "<?", "?>", "<!DOCTYPE a [", "\0", "\ud7ff", "\uffff", "é", "{", "}", "{=}",
    "{@@x}", "=", ";", "Main", "Sub", "root", "ID", ' ID="Main"', ' name=""',
    "<SubTree ID='Main'/>",
    "<Sequence>", "</Sequence>", ' _autoremap="x"', " num_cycles='-1'", "9" * 400, "(" * 200, "\n",
    "json:[[[[", "1e999", "x := y", "inf", "nan", " ", "\t",
]  # fmt: skip

mutations = st.lists(
    st.tuples(
        st.integers(0, 2000),
        st.integers(0, 30),
        st.one_of(st.sampled_from(PIECES), st.text(max_size=4)),
    ),
    min_size=1,
    max_size=6,
)
registry = corpus_registry([])


def check_mutated(seed, changes, strict):
    text = seed
    for position, removed, inserted in changes:
        start = position % (len(text) + 1)
        text = text[:start] + inserted + text[start + removed :]
    try:
        reading = read_tree_text(text, registry, strict=strict, dialect="auto")
    except BtManipError:
        return
    assert (reading.tree is not None) or reading.errors
    for problem in reading.problems:
        assert problem.place.line >= 1 and problem.place.column >= 1


@pytest.mark.parametrize("count", [100, pytest.param(100_000, marks=pytest.mark.soak)])
def test_reading_mutated_documents_raises_nothing_but_our_errors(count):
    limits = settings(
        max_examples=count, deadline=None, suppress_health_check=list(HealthCheck), database=None
    )
    limits(given(st.sampled_from(SEEDS), mutations, st.booleans())(check_mutated))()


def billion_laughs():
    entities = "".join(f'<!ENTITY l{i + 1} "{f"&l{i};" * 10}">' for i in range(9))
    return f'<!DOCTYPE r [<!ENTITY l0 "lol">{entities}]><root>&l9;</root>'


def ladder(count):
    trees = "".join(
        f'<BehaviorTree ID="T{i}"><Sequence><SubTree ID="T{i + 1}"/><SubTree ID="T{i + 1}"/>'
        "</Sequence></BehaviorTree>"
        for i in range(count)
    )
    return (
        f'<root main_tree_to_execute="T0">{trees}'
        f'<BehaviorTree ID="T{count}"><AlwaysSuccess/></BehaviorTree></root>'
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (billion_laughs(), "document types and entities are not allowed"),
        ("<!DOCTYPE r SYSTEM 'file:///etc/passwd'><root/>", "document types and entities"),
        ("<a>" * 100_000, "nested deeper than 498 levels"),
        ("<root>" + "<!--" * 100_000, "the comment is not closed"),
        ("<root " + "a " * 100_000, "has no value in quotes"),
        ("<root " + "".join(f"a{i}='1' " for i in range(50_000)), "has more than 1000 attributes"),
        ("<root>" + "<a/>" * 35_000 + "<!---->" * 35_000, "more than 70000 elements, comments"),
        ("x" * 17_000_000, "more than 16000000 characters"),
        (ladder(40), "the tree has more than 2000 nodes"),
    ],
    ids=[
        "entities", "external", "deep", "comment", "attributes", "many", "wide", "long", "bomb",
    ],
)  # fmt: skip
def test_a_bomb_is_refused_before_it_bursts(text, message, monkeypatch):
    monkeypatch.setattr("bt_manip.bt.xml.builder.MAX_NODES", 2000)
    start = time.process_time()
    reading = read_tree_text(text, BehaviourRegistry())

    assert message in str(reading.errors[0])
    assert time.process_time() - start < 20  # not a measurement: a bomb takes hours


def test_an_error_of_a_parser_of_a_behaviours_own_is_a_finding():
    def parse(text):
        raise ZeroDivisionError("cannot")

    class Odd(Action):
        thing = Input(dict, parse=parse)

    text = '<root><BehaviorTree ID="A"><Odd thing="1"/></BehaviorTree></root>'
    reading = read_tree_text(text, BehaviourRegistry([Odd]))

    assert "port 'thing': cannot" in str(reading.errors[0])

"""The same trees do the same as in the real engine."""

import json
from pathlib import Path

import pytest

from tests.conformance.__main__ import cases, main
from tests.conformance.compare import differences
from tests.conformance.options import options_in, parse_options
from tests.conformance.runner import run

TRACES = Path(__file__).with_name("traces")
RANDOM = ("nodes", "ports", "scripts", "documents", "timers", "substitutes")


@pytest.mark.parametrize(("name", "least"), [*((name, 100) for name in RANDOM), ("details", 27)])
def test_trees_do_what_the_engine_did(name, least):
    results = dict(cases(TRACES / f"{name}.jsonl"))

    assert len(results) >= least
    assert {seed: found for seed, found in results.items() if found} == {}


def test_the_whole_corpus_agrees(engine_facts, capsys):
    assert main([str(engine_facts / "corpus")]) == 0
    assert capsys.readouterr().out == "163 of 163 agree\n"


@pytest.mark.soak
def test_all_random_trees_of_the_facts_agree(engine_facts, capsys):
    assert main([str(engine_facts / "random_trees.jsonl")]) == 0
    assert capsys.readouterr().out == "600 of 600 agree\n"


TREE = (
    '<root BTCPP_format="4"><!-- conformance: ticks=2; bb.int.x=3 --><BehaviorTree ID="Main">'
    '<Sequence><Script code="x += 1"/><Scripted name="a" outcomes="R,S"/></Sequence>'
    "</BehaviorTree></root>"
)
TRACE = {
    "ticks": [
        {"root": "RUNNING", "events": [["a", "start", "R"]]},
        {"root": "SUCCESS", "events": [["a", "running", "S"]]},
    ],
    "final_blackboard": {"Main": {"x": {"value": 4}}},
}


def compare(trace):
    return differences(run(TREE, parse_options(options_in(TREE))), trace)


@pytest.mark.parametrize(
    "change",
    [
        lambda trace: trace["ticks"][1].update(root="FAILURE"),
        lambda trace: trace["ticks"][0].update(error="it raised"),
        lambda trace: trace["ticks"][0].update(op="haltTree"),
        lambda trace: trace["ticks"][0]["events"].append(["a", "halt"]),
        lambda trace: trace["ticks"][0]["events"][0].__setitem__(2, "S"),
        lambda trace: trace["ticks"].pop(),
        lambda trace: trace["final_blackboard"]["Main"]["x"].update(value=5),
        lambda trace: trace["final_blackboard"]["Main"].update(y={"value": 1}),
        lambda trace: trace["final_blackboard"]["Main"].pop("x"),
        lambda trace: trace["final_blackboard"].update(sub={}),
        lambda trace: (trace.clear(), trace.update(error="rejected")),
    ],
)
def test_every_kind_of_difference_is_found(change):
    trace = json.loads(json.dumps(TRACE))
    assert compare(trace) == []
    change(trace)

    assert len(compare(trace)) >= 1


def test_a_difference_makes_the_exit_code_1(tmp_path, capsys):
    file = tmp_path / "trees.jsonl"
    file.write_text(json.dumps({"seed": 7, "xml": TREE, "trace": {"error": "rejected"}}))

    assert main([str(file)]) == 1
    out = capsys.readouterr().out.splitlines()
    assert out[0].startswith("trees.jsonl:7: ") and out[-1] == "0 of 1 agree"
    assert main([str(tmp_path / "nothing")]) == main([]) == 2

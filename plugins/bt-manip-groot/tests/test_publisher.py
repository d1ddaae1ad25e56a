"""The publisher answers as that of BehaviorTree.CPP, and leaves the run alone."""

import json
import random
import struct
import threading
import time
from pathlib import Path

import msgpack
import pytest

from bt_manip.behaviours import MoveHome, MoveToConfiguration
from bt_manip.bt import BehaviourRegistry, Sequence, Sleep, Tree, parse_tree
from bt_manip.record import Recorder
from bt_manip.runner import RunObserver
from bt_manip_groot.publisher import GrootPublisher

from .client import Client, free_ports, hook
from .conftest import run_of, sample_tree

TICKS_BEFORE = {1: 1, 2: 1, 3: 1, 4: 1, 8: 1, 9: 5}
"""Ticks of the tree before some requests of the transcript, by their index."""


def decoded(request, parts):
    """Give the kinds, lengths and fields of a reply, without what each run has of its own."""
    if parts[0] == b"error":
        return "error", len(parts)
    assert len(parts[0]) == 22
    body = parts[1:]
    kind = request[0][1:2]
    if kind == b"T":
        body = ["xml"]
    elif kind == b"t":
        assert len(body[0]) % 9 == 0
        body = [[struct.unpack("<HB", body[0][i + 6 : i + 9]) for i in range(0, len(body[0]), 9)]]
    elif kind == b"B":
        body = [msgpack.unpackb(body[0])]
    elif kind == b"D":
        body = [json.loads(body[0])]
    elif kind == b"r" and body:
        body = [len(body[0])]
    return parts[0][:6], body


def test_the_transcript_of_groot2_gets_the_same_replies(groot2, watch):
    document = (groot2 / "demo.xml").read_text()
    tree = sample_tree(document)
    watched = watch(tree)
    client, steps = watched.client, watched.steps
    uuids = set()

    for index, entry in enumerate(json.loads((groot2 / "transcript.json").read_text())):
        if entry["type"] == "N":
            steps.start_tick()
            assert client.reached() == 7
            continue
        steps.tick(TICKS_BEFORE.get(index, 0))
        request = [bytes.fromhex(part) for part in entry["request_hex"]]
        wanted = [bytes.fromhex(part) for part in entry["reply_hex"]]
        reply = client.send(request)
        assert decoded(request, reply) == decoded(request, wanted), entry["note"]
        if len(reply[0]) == 22:
            uuids.add(reply[0][6:])
        if index == 14:  # it waits within the tick
            time.sleep(0.1)
            assert not steps.done.acquire(blocking=False)
        if index == 15:
            steps.wait()
    assert len(uuids) == 1


TREE = (
    '<root BTCPP_format="4" main_tree_to_execute="Main"><BehaviorTree ID="Main"><Sequence>'
    "<Script code=\"n := 3; big := 0.1; text := 'a'\"/>"
    '<SubTree ID="Sub" name="sub" given="{n}" own="4.5"/><Sleep msec="20"/>'
    '</Sequence></BehaviorTree><BehaviorTree ID="Sub"><AlwaysSuccess/></BehaviorTree></root>'
)


@pytest.fixture
def small_tree():
    return parse_tree(TREE, BehaviourRegistry())


def test_the_blackboard_of_a_sub_tree_comes_with_that_of_the_root_and_long_texts_are_cut(
    watch, small_tree
):
    watched = watch(small_tree)
    watched.steps.tick()
    found = msgpack.unpackb(watched.client.ask("B", b"sub;nonsense"))
    root = {"n": 3, "big": 0.1, "text": "a"}
    assert found == {"sub": {"own": 4.5}, "ROOT": root}
    assert msgpack.unpackb(watched.client.ask("B", b"a;b;c;d;Main")) == {"Main": root}

    small_tree.blackboard["long"] = "x" * 1_000_000
    watched.steps.tick()
    found = msgpack.unpackb(watched.client.ask("B", b"Main"))
    assert found["Main"]["long"] == "x" * 10_000


def test_transitions_have_simulated_times(watch, small_tree):
    watched = watch(small_tree)
    client = watched.client
    assert abs(int(client.ask("r", b"start")) / 1e6 - time.time()) < 60.0
    watched.steps.tick(3)
    data = client.ask("t")
    rows = [
        (int.from_bytes(data[i : i + 6], "little"), *struct.unpack("<HB", data[i + 6 : i + 9]))
        for i in range(0, len(data), 9)
    ]
    assert rows[0] == (0, 1, 1)
    assert rows[-1] == (20_000, 1, 0)
    assert client.ask("t") == b""


def test_a_tree_that_is_replaced_has_another_uuid_and_no_hooks(watch, small_tree):
    watched = watch(small_tree)
    client = watched.client
    watched.steps.tick()
    client.ask("I", hook(1))
    first, xml = client.send([b"\x02T\0\0\0\0"])
    watched.tree.replace(parse_tree(TREE.replace("20", "30"), BehaviourRegistry()))
    watched.steps.tick()
    other, new_xml = client.send([b"\x02T\0\0\0\0"])
    assert first[6:] != other[6:]
    assert b'msec="20"' in xml and b'msec="30"' in new_xml
    assert client.hooks() == []


def test_a_publisher_that_stays_answers_between_runs_with_the_last_tree(station):
    port = free_ports()
    publisher = GrootPublisher(port, stays=True)
    client, seen = None, set()
    try:
        for name in ("first", "second"):
            run_of(station, Tree(Sleep(name, msec=30))).execute([publisher])
            client = client or Client(port)
            xml = client.ask("T")
            assert f'name="{name}"'.encode() in xml
            seen.add(xml)
    finally:
        publisher.close()
        if client:
            client.close()
    assert len(seen) == 2


def test_only_loopback_is_listened_to(watch, small_tree):
    watched = watch(small_tree)
    listening = set()
    for table in ("tcp", "tcp6"):
        for line in Path(f"/proc/net/{table}").read_text().splitlines()[1:]:
            address, port = line.split()[1].split(":")
            if line.split()[3] == "0A" and int(port, 16) in (watched.port, watched.port + 1):
                listening.add((address, int(port, 16)))
    assert listening == {("0100007F", watched.port), ("0100007F", watched.port + 1)}


def messages(number):
    """Give malformed requests of many kinds."""
    rng = random.Random(1)
    kinds = b"TSBIRUDAXrtN\0\xff"
    names = ("uid", "position", "mode", "enabled", "once", "desired_status", "remove_when_done")
    values = (0, 1, -1, 7, 1 << 16, 10**30, 1.5, None, True, "", "FAILURE", "x" * 100, [], {})
    fixed = [
        [b""], [b"", b""], [b"\x02"], [b"\x02I\0\0\0\0", b"[" * 100_000], [b"x" * 200_000],
        [b"\x02I\0\0\0\0", b"9" * 100_000], [b"\x02I\0\0\0\0", b"[1, null, [], {}]"],
        [b"\x02B\0\0\0\0", b";" * 100_000], [b"\x02B\0\0\0\0", b"\xff\xfe"],
        [b"\x02r\0\0\0\0", b"stop it"], [b"\x02S\0\0\0\0"] * 1000,
    ]  # fmt: skip
    for index in range(number):
        if index < len(fixed):
            yield fixed[index]
            continue
        header = bytearray(b"\x02" + bytes([rng.choice(kinds)]) + rng.randbytes(4))
        if rng.random() < 0.2:
            header = rng.randbytes(rng.randrange(12))
        fields = {n: rng.choice(values) for n in names if rng.random() < 0.7}
        if "position" in fields:  # never 0 or 1: nothing is hooked
            fields["position"] = rng.choice(values[2:])
        body = json.dumps(fields).encode()
        body = rng.choice((body, body[: rng.randrange(len(body) + 1)], rng.randbytes(20)))
        yield [bytes(header), body][: rng.choice((1, 2, 2, 2))]


def digest_of(make_run, *observers):
    """Run a motion and give the digest of all states."""
    recorder = Recorder("test", 0)
    move = MoveToConfiguration(configuration=[0.5, -0.5, 0.0, -2.0, 0.0, 1.6, 0.8])
    make_run(Sequence(move, MoveHome())).execute([recorder, *observers])
    return recorder.report().state_digest


@pytest.mark.parametrize("number", [500, pytest.param(10_000, marks=pytest.mark.soak)])
def test_malformed_messages_get_errors_and_leave_the_run_as_it_is(
    make_run, shared_stations, number
):
    port = free_ports()
    client = Client(port)
    replies, attack = [], RunObserver()

    def send() -> None:
        replies.extend(client.send(message) for message in messages(number))

    thread = threading.Thread(target=send)
    attack.run_started = lambda run: thread.start()
    attack.before_tick = lambda: time.sleep(0.005 * thread.is_alive())  # the run lasts as long
    attack.run_ended = thread.join
    assert digest_of(make_run, attack, GrootPublisher(port)) == digest_of(make_run)
    client.close()
    errors = [reply for reply in replies if reply[0] == b"error"]
    assert len(replies) > 0.9 * number and all(len(reply) == 2 for reply in errors)
    assert len(errors) > number / 2
    assert all(len(reply[0]) == 22 for reply in replies if reply[0] != b"error")

"""What a page has to show at a past time, read from a recording by the library of MCAP."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from mcap.exceptions import McapError
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader

from .conftest import Window, wait_until

SIGNS = {"IDLE": "·", "RUNNING": "▶", "SUCCESS": "✓", "FAILURE": "✗", "SKIPPED": "-"}

ANSWERS = SIGNS | {"SUCCESS": "yes", "FAILURE": "no"}
"""Signs of conditions."""

ROWS = """
    () => Object.fromEntries([...document.querySelectorAll('.line:not([hidden])')].map((line) => [
        line.dataset.uid,
        [line.querySelector('.sign').textContent, line.querySelector('.message').textContent],
    ]))
"""
"""Gives sign and message of the rows of the tree in view, by uid."""

BOARD = """
    () => Object.fromEntries([...document.querySelectorAll('.tab:not([hidden]) tr')].map((row) =>
        [...row.children].map((cell) => cell.textContent)))
"""
"""Gives the entries of the blackboard, whose tab is open."""

POSITIONS = """
    names => names.map((name) => {
        const { nodeRefFromName, camera } = __viserMutable, node = nodeRefFromName[name];
        return node ? node.position.toArray() : null;
    })
"""
"""Gives the positions of nodes of the scene [m]."""

WORDS = 100
"""Characters up to which values of the blackboard are compared: the page cuts long ones."""


class Past:
    """The states of a run at the end of a tick."""

    def __init__(self, path: Path) -> None:
        self.messages: list[tuple[int, float, str, bytes]] = []  # ticks, time [s], topic, content
        channels: dict[int, str] = {}
        with path.open("rb") as file:
            try:
                for record in StreamReader(file).records:
                    if isinstance(record, Channel):
                        channels[record.id] = record.topic
                    elif isinstance(record, Message):
                        topic, time = channels[record.channel_id], record.log_time / 1e9
                        self.messages.append((record.sequence, time, topic, record.data))
            except McapError:  # the run goes on
                pass
        poses = [one for one in self.messages if one[2] == "/tf"]
        self.times = np.array([time for _, time, _, _ in poses])
        self._poses = poses

    def at(self, time: float) -> tuple[int, bytes]:
        """Return the number of ticks at a time [s], and the poses then."""
        tick, _, _, data = self._poses[int(np.searchsorted(self.times, time + 1e-6)) - 1]
        return tick, data

    def board(self, tick: int) -> dict[str, str]:
        """Return the entries of the blackboard, as the page shows them."""
        values: dict[str, Any] = {}
        for number, _, topic, data in self.messages:
            if topic == "/blackboard" and number <= tick:
                values |= {(one := json.loads(data))["key"]: one["value"]}
        return {key: str(value)[:WORDS] for key, value in values.items() if value is not None}

    def states(self, tick: int) -> dict[str, tuple[str, str]]:
        """Return sign and message of all nodes, by uid."""
        texts: dict[int, str] = {}
        found: dict[int, list[str]] = {}
        kinds: dict[int, str] = {}
        for number, _, topic, data in self.messages:
            if number > tick or not topic.startswith(("/tree/", "/cycles")):
                continue
            one = json.loads(data)
            if topic == "/tree/nodes":
                kinds |= {node["uid"]: node["kind"] for node in one["nodes"]}
            elif topic == "/cycles" and one["status"] == "RUNNING":
                found.clear()
            elif topic == "/tree/messages":
                texts[one["uid"]] = one["text"]
                if one["uid"] in found:
                    found[one["uid"]][1] = one["text"]
            elif topic == "/tree/status" and (one["status"] != "IDLE" or one["old"] == "RUNNING"):
                # Parents reset their children as soon as they end.
                text = one["reason"] or texts.get(one["uid"], "")
                found[one["uid"]] = [one["status"], text]
        return {
            str(uid): ((ANSWERS if kinds[uid] == "Condition" else SIGNS)[status], text)
            for uid, (status, text) in found.items()
        }


def wrong_rows(window: Window, states: dict[str, tuple[str, str]]) -> list[Any]:
    """Return sign and message of rows of the tree that differ from some states, with those."""
    rows = window.page.evaluate(ROWS)
    expected = {uid: states.get(uid, (SIGNS["IDLE"], "")) for uid in rows}
    wrong = [(row, expected[uid]) for uid, row in rows.items() if tuple(row) != expected[uid]]
    return wrong if rows else ["no rows"]


def back_to_now(window: Window) -> None:
    """Show the present."""
    line = window.page.get_by_role("slider", name="Timeline")

    def is_now() -> bool:
        if line.get_attribute("data-shown") is not None:  # a click is lost on a new connection
            window.page.get_by_text("Back to now", exact=True).dispatch_event("click")
            window.page.wait_for_timeout(300)
        return line.get_attribute("data-shown") is None

    wait_until(is_now)


def check_moments(
    window: Window, path: Path, *, share_of: tuple[float, ...], scene: bool = True
) -> None:
    """Click at moments of the run; compare scene, tree and blackboard with its recording.

    Args:
        window: The page.
        path: The recording.
        share_of: The moments, as shares of the shown range.
        scene: Whether the window has the scene.
    """
    window.open_tab("Blackboard")
    line = window.page.get_by_role("slider", name="Timeline")
    for share in share_of:
        back_to_now(window)
        box = line.bounding_box()
        line.click(position={"x": 8 + share * (box["width"] - 16), "y": 30}, force=True)
        wait_until(lambda: line.get_attribute("data-shown") is not None)
        _check_moment(window, path, float(line.get_attribute("data-shown")), scene)


def _check_moment(window: Window, path: Path, moment: float, scene: bool) -> None:
    past: Past

    def recorded() -> bool:
        nonlocal past
        past = Past(path)  # of a run that goes on, a moment is in the file a little later
        is_complete = past.times.max(initial=0.0) > moment + 0.1
        return is_complete or not window.button("Stop").count()

    wait_until(recorded)
    tick, data = past.at(moment)
    states, board = past.states(tick), past.board(tick)
    frames = FrameTransforms.FromString(data).transforms
    arms = {one.child_frame_id: one.translation for one in frames}
    arms = {name: at for name, at in arms.items() if "link" in name or "hand" in name}
    names = [f"/{name.partition('/')[0]}/{name.replace('/', ':')}" for name in arms]
    expected = np.array([(at.x, at.y, at.z) for at in arms.values()])
    assert len(expected) >= 8

    def differences() -> list[Any]:
        wrong = wrong_rows(window, states)
        shown = {key: value[:WORDS] for key, value in window.page.evaluate(BOARD).items()}
        if shown != board:
            wrong.append((shown, board))
        at = window.evaluate(POSITIONS, names) if scene else expected.tolist()
        if None in at or np.abs(np.array(at) - expected).max() > 1e-4:
            wrong.append((names, at, expected))
        return wrong

    wait_until(lambda: not differences(), lambda: f"at {moment} s: {differences()}")

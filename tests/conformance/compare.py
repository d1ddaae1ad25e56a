"""Comparing a run with what the engine did."""

import math
from collections.abc import Mapping, Sequence
from enum import Enum
from typing import Any

from bt_manip.bt.blackboard import EMPTY
from tests.conformance.runner import EngineTrace
from tests.support.corpus_leaves import Event

_TEXTS = ("input_error", "output_error")
_NOT_COMPARED = ("uid",)
_MEANING = {"node", "ev", "outcome", "read", "expected", "wrote", "msg", "child", *_TEXTS}


def differences(trace: EngineTrace, expected: Mapping[str, Any]) -> list[str]:
    """List in what a run differs from what the engine did.

    Args:
        trace: The run.
        expected: The trace of the engine, of a corpus file or of a line of random trees.
    """
    rejected = "ticks" not in expected
    if rejected or trace.error is not None:
        if rejected and trace.error is not None:
            return []
        return [
            f"the engine rejects it: {expected.get('error')}"
            if rejected
            else f"the engine accepts it, but: {trace.error}"
        ]
    found: list[str] = []
    ticks = expected["ticks"]
    for number, (ours, theirs) in enumerate(zip(trace.ticks, ticks, strict=False), start=1):
        where = f"step {number}"
        if ours.halt != (theirs.get("op") == "haltTree"):
            found.append(f"{where}: only one of the two halts the tree here")
        if (ours.error is None) != ("error" not in theirs):
            found.append(f"{where}: raised {ours.error}, engine {theirs.get('error')}")
        elif not ours.halt and ours.error is None and ours.root != theirs["root"]:
            found.append(f"{where}: root {ours.root}, engine {theirs['root']}")
        found += _events(where, ours.events, theirs["events"])
        before = theirs.get("events_before_tick", [])
        found += _events(f"before {where}", ours.events_before, before)
        if "bb" in theirs and theirs["bb"] is not None:
            found += _values(where, ours.values, theirs["bb"])
    if len(trace.ticks) != len(ticks):
        found.append(f"{len(trace.ticks)} steps, engine {len(ticks)}")
    final = expected.get("final_blackboard")
    if final is not None:
        found += _scopes(trace.scopes, final)
    return found


def _events(where: str, ours: Sequence[Event], theirs: Sequence[Any]) -> list[str]:
    expected = [_event(event) for event in theirs]
    actual = [_event(event) for event in ours]
    if any(isinstance(event, list) for event in theirs):  # random trees hold less of an event
        actual = [_short(event) for event in actual]
        expected = [_short(event) for event in expected]
    if len(actual) == len(expected) and all(map(_same_event, actual, expected)):
        return []
    return [f"{where}: events {actual}, engine {expected}"]


def _event(event: Any) -> Event:
    if isinstance(event, list):
        node, kind, *rest = event
        return {"node": node, "ev": kind, "outcome": rest[0] if rest else None}
    return {
        key: bool(value) if key in _TEXTS else value
        for key, value in event.items()
        if key not in _NOT_COMPARED
    }


def _short(event: Event) -> Event:
    return {"node": event["node"], "ev": event["ev"], "outcome": event.get("outcome")}


def _same_event(ours: Event, theirs: Event) -> bool:
    """Compare what an event is for; what a leaf logs beyond that counts where both log it."""
    if ours.keys() & _MEANING != theirs.keys() & _MEANING:
        return False
    return all(same(ours[key], theirs[key]) for key in ours.keys() & theirs.keys())


def _scopes(ours: Mapping[str, Mapping[str, Any]], theirs: Mapping[str, Any]) -> list[str]:
    found = []
    for name in sorted(ours.keys() | theirs.keys()):
        if name not in ours or name not in theirs:
            found.append(f"final blackboard: scope '{name}' is only on one side")
            continue
        expected = {
            key: EMPTY if entry.get("empty") else entry["value"]
            for key, entry in theirs[name].items()
        }
        found += _values(f"final blackboard '{name}'", ours[name], expected)
        for key in ours[name].keys() - expected.keys():
            found.append(f"final blackboard '{name}': '{key}' is not in the engine's")
    return found


def _values(where: str, ours: Mapping[str, Any], theirs: Mapping[str, Any]) -> list[str]:
    return [
        f"{where}: '{key}' is {ours.get(key, 'missing')!r}, engine {value!r}"
        for key, value in theirs.items()
        if key not in ours or not same(ours[key], value)
    ]


def same(ours: Any, theirs: Any) -> bool:
    """Tell whether two values are equal, numbers by value."""
    if ours is EMPTY or theirs is EMPTY:
        return ours is theirs or theirs is None
    if isinstance(ours, Enum):
        ours = ours.value
    if isinstance(ours, float) and not math.isfinite(ours):
        return theirs is None or ours == theirs
    if isinstance(ours, bool | int | float) and isinstance(theirs, bool | int | float):
        return ours == theirs or math.isclose(ours, theirs, rel_tol=1e-12)
    if isinstance(ours, list) and isinstance(theirs, list):
        return len(ours) == len(theirs) and all(map(same, ours, theirs))
    return type(ours) is type(theirs) and bool(ours == theirs)
